"""The accuracy that is needed: the sizes that were tried, and where the goal is passed."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from kneecore.figures.columns import column_label, size_label
from kneecore.figures.style import COLOURS, styled
from kneecore.knee.model import Knee
from kneecore.study.needed_accuracy import NeededAccuracy

__all__ = ["draw", "mark_answer"]


def draw(need: NeededAccuracy) -> dict[str, Figure]:
    """Return the figures of a needed accuracy by name."""
    with styled():
        figure = Figure(figsize=(5.6, 3.8), layout="constrained")
        axes = figure.add_subplot()
        axes.plot(*need.tried.T, "o-", color=COLOURS["model_2"], markersize=4, linewidth=1.2)
        axes.set_xlim(left=0.0)
        axes.set_xlabel(size_label(need.model))
        axes.set_ylabel(f"largest {column_label(need.model, need.column)}")
        mark_answer(axes, need)
        axes.margins(y=0.15)
    return {"figure_needed_accuracy": figure}


def _answer(need: NeededAccuracy) -> str:
    if isinstance(need.model, Knee):
        return f"{need.size:.2f} mm: all within {need.settings.within:g} deg"
    unit = need.model.columns[need.column].output.unit
    size = f"{need.size:.3g} {need.model.size_unit}".rstrip()
    return f"{size}: at most {need.settings.within:g} {unit}".rstrip()


def mark_answer(axes: Axes, need: NeededAccuracy) -> None:
    """Mark what is good enough, and the widest bounds with which it is."""
    if need.size is None or need.settings.within is None:
        return
    at = (need.size, need.settings.within)
    axes.axhline(need.settings.within, color="0.5", linewidth=0.8)
    if need.reaches_largest and not isinstance(need.model, Knee):
        return
    axes.plot(*at, "D", color="k", zorder=4, markersize=5)
    axes.annotate(
        _answer(need),
        at,
        xytext=(-14, 52),
        textcoords="offset points",
        fontsize="small",
        arrowprops={"arrowstyle": "-", "color": "0.4", "linewidth": 0.8},
    )

"""Worst cases over bounds of several sizes."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from kneecore.figures.columns import column_label, size_label
from kneecore.figures.needed_accuracy import mark_answer
from kneecore.figures.style import COLOURS, axis_label, styled
from kneecore.knee.model import Knee
from kneecore.study.bound_sweep import BoundSweep
from kneecore.study.needed_accuracy import NeededAccuracy

__all__ = ["bound_figure", "draw"]


def draw(sweep: BoundSweep, need: NeededAccuracy | None = None) -> dict[str, Figure]:
    """Return a sweep's figures by name, with a needed accuracy if there is one."""
    return {"figure_bound": bound_figure(sweep, need)}


def bound_figure(sweep: BoundSweep, need: NeededAccuracy | None = None) -> Figure:
    """Return f and the watched output against the bounds' size, with a needed accuracy."""
    knee = isinstance(sweep.model, Knee)
    with styled():
        figure = Figure(figsize=(9.0, 3.8), layout="constrained")
        left, right = figure.subplots(1, 2)
        left.plot(sweep.size, sweep.objective, "o-", color="0.2", markersize=4)
        left.set_ylabel(
            "f of the worst pair, deg over 12 loads"
            if knee
            else axis_label("f of the worst pair", sweep.model.objective_unit)
        )
        left.set_ylim(bottom=0.0)
        _watched(right, sweep)
        if need is not None:
            mark_answer(right, need)
        for axes in (left, right):
            axes.set_xlim(left=0.0)
            axes.set_xlabel(size_label(sweep.model))
        right.legend(fontsize="x-small")
    return figure


def _watched(axes: Axes, sweep: BoundSweep) -> None:
    """Draw the worst pair's and the extreme values of the watched output."""
    knee = isinstance(sweep.model, Knee)
    for k, name in enumerate(("model_1", "model_2")):
        pair = (
            f"worst pair, the knee that {('over-extends', 'cannot extend')[k]}"
            if knee
            else f"worst pair, {('lower', 'higher')[k]}"
        )
        end = ("least", "largest")[k]
        axes.plot(sweep.size, sweep.pair[:, k], "o-", color=COLOURS[name], markersize=4, label=pair)
        axes.plot(
            sweep.size,
            sweep.extremes[:, k],
            "--",
            color=COLOURS[name],
            linewidth=1.2,
            label=f"{end} angle of any knee" if knee else f"{end} of any model",
        )
    if knee:
        axes.axhline(0.0, color="0.5", linewidth=0.8, linestyle=":")
    axes.set_ylabel(column_label(sweep.model, sweep.column))

"""Which measurement must be how good: tolerances as bars, one for all beside the cheapest."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from kneecore.figures.style import COLOURS, axis_label, styled
from kneecore.knee.model import Knee
from kneecore.study.accuracy_allocation import AccuracyAllocation

__all__ = ["draw"]

_ROW, _FOOT = 0.3, 0.75  # inches of a measurement, and of an axis with its label


def draw(found: AccuracyAllocation) -> dict[str, Figure]:
    """Return the figures of an allocation by name."""
    units = list(dict.fromkeys(found.units))
    rows = [[k for k, u in enumerate(found.units) if u == unit] for unit in units]
    ratios = [len(row) for row in rows]
    height = _ROW * sum(ratios) + _FOOT * len(rows) + 0.4
    with styled():
        figure = Figure(figsize=(5.6, height), layout="constrained")
        grid = figure.subplots(len(units), 1, squeeze=False, height_ratios=ratios)[:, 0]
        for axes, row, unit in zip(grid, rows, units, strict=True):
            _bars(axes, found, row, unit)
        figure.suptitle(_title(found), fontsize="medium")
        handles, labels = grid[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize="small")
    return {"figure_accuracy_allocation": figure}


def _title(found: AccuracyAllocation) -> str:
    within, one = found.settings.within, found.model.columns[found.column]
    if isinstance(found.model, Knee):
        return f"Tolerances with which every knee extends to within {within:g} deg"
    return f"Tolerances with which {one.title} is at most {within:g} {one.output.unit}".rstrip()


def _bars(axes: Axes, found: AccuracyAllocation, row: Sequence[int], unit: str) -> None:
    """Draw the measurements of one unit."""
    at, stated = np.arange(len(row)), found.stated[list(row)]
    axes.barh(at, stated, height=0.86, color="0.93", label="stated")
    for shift, shares, colour, word in (
        (-0.2, found.equal_factors, COLOURS["baseline"], "one for all"),
        (0.2, found.factors, COLOURS["model_1"], "cheapest"),
    ):
        # An empty bar keeps its place in the legend, where there is no answer.
        values = np.zeros(len(row)) if shares is None else shares[list(row)] * stated
        axes.barh(at + shift, values, height=0.36, color=colour, label=word)
        for y, value, k in zip(at + shift, values, row, strict=True):
            if shares is not None:
                as_stated = word == "cheapest" and found.as_stated[k]
                told = f"{value:.3g}" + (" as stated" if as_stated else "")
                inside = value > 0.75 * stated.max()
                axes.annotate(
                    told,
                    (value, y),
                    xytext=(-3 if inside else 3, 0),
                    textcoords="offset points",
                    ha="right" if inside else "left",
                    va="center",
                    fontsize="x-small",
                    color="white" if inside else "black",
                )
    axes.set_yticks(at, [found.names[k] for k in row])
    axes.set_ylim(len(row) - 0.5, -0.5)
    axes.grid(axis="y", visible=False)
    axes.set_xlabel(axis_label("tolerance", f"± {unit}".rstrip(" ±")))

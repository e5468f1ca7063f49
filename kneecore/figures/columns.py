"""A model's outputs in figures: what they are called, and where they stand."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from kneecore.figures.style import axis_label
from kneecore.knee.model import Knee
from kneecore.model import Model

__all__ = ["column_label", "grid_of", "name_columns", "size_label"]

_MANY, _MANY_LONG, _LONG = 24, 12, 6
"""Outputs, and those with long names: of more, only some are named. What is long, in letters."""


def name_columns(axes: Axes, model: Model, labels: Sequence[str] | None = None) -> None:
    """Name the outputs along the axis to the right, which has one a whole number, in their order.

    `labels` are other names, in the same order.
    """
    told = [model.columns[k].label for k in model.order] if labels is None else list(labels)
    long = max(map(len, told)) > _LONG
    step = -(-len(told) // (_MANY_LONG if long else _MANY))
    places = list(range(0, len(told), step))
    slanted = long and len(places) > 3
    axes.set_xticks(
        places,
        [told[k] for k in places],
        rotation=45 if slanted else 0,
        ha="right" if slanted else "center",
    )
    axes.grid(axis="x", visible=False)


def column_label(model: Model, column: int) -> str:
    """Return the axis label of one of a model's outputs."""
    one = model.columns[column]
    if isinstance(model, Knee):
        return f"knee angle at {one.label}, deg (flexion > 0)"
    return axis_label(one.title, one.output.unit)


def size_label(model: Model) -> str:
    """Return the axis label of the size of a model's bounds."""
    sign = "± " if isinstance(model, Knee) else ""
    return axis_label(model.size_name, sign + model.size_unit if model.size_unit else "")


def grid_of(n: int) -> tuple[Figure, list[Axes]]:
    """Return a figure with a place for each of `n` outputs, two side by side."""
    n_columns = min(n, 2)
    n_rows = -(-n // n_columns)
    figure = Figure(figsize=(6.0 * n_columns, 4.2 * n_rows), layout="constrained")
    grid = np.atleast_1d(figure.subplots(n_rows, n_columns)).ravel()
    for axes in grid[n:]:
        axes.set_axis_off()
    return figure, list(grid[:n])

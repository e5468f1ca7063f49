"""A search's figures: the paper's 1 to 4 for knees, their general form for any other model."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from kneecore.figures import names
from kneecore.figures.evidence import convergence_figure, repair_figure
from kneecore.figures.knee_pair import ap_position, ligament_forces, moment_angle
from kneecore.figures.style import (
    COLOURS,
    LABELS,
    REST_DEG,
    axis_label,
    lay_axis,
    output_slices,
    styled,
)
from kneecore.knee.model import Knee
from kneecore.model import Shape
from kneecore.outputs import Output
from kneecore.search.result import MODELS, SearchResult

__all__ = ["draw"]

FloatArray = NDArray[np.float64]

_MOST_OUTPUTS = 24
_KNEE = {
    names.MOMENT_ANGLE: moment_angle,
    names.FORCES: ligament_forces,
    names.AP_POSITION: ap_position,
}


def draw(result: SearchResult) -> dict[str, Figure]:
    """Return a search's figures by name."""
    drawn: dict[str, Figure] = {}
    with styled():
        if isinstance(result.model, Knee):
            drawn |= {name: figure(result) for name, figure in _KNEE.items()}
            title = f"Geometry in the load-free pose ({REST_DEG:.2f} deg)"
            drawn[names.GEOMETRY] = _picture(result, title, ("anterior", "proximal"))
            drawn[names.GEOMETRY].axes[0].legend(loc="lower right")
        else:
            drawn[names.OUTPUTS] = _outputs(result)
            if result.model.has_picture:
                drawn[names.PICTURE] = _picture(result, result.model.name, ("x", "y"))
                drawn[names.PICTURE].legend(loc="outside lower center", ncols=len(MODELS))
    if result.repair is not None:
        drawn[names.REPAIR] = repair_figure(result.repair, result.model)
    if result.methods:
        drawn[names.CONVERGENCE] = convergence_figure(result)
    return dict(sorted(drawn.items()))


def _outputs(result: SearchResult) -> Figure:
    """Draw each output of the three models: a curve over its axis, or a bar."""
    slices = _shown_outputs(result)
    few = len(slices) <= 4
    n_columns = min(len(slices), 2 if few else 4)
    n_rows = -(-len(slices) // n_columns)
    width, height = (6.0, 4.2) if few else (4.0, 3.0)
    figure = Figure(figsize=(width * n_columns, height * n_rows), layout="constrained")
    grid = np.atleast_1d(figure.subplots(n_rows, n_columns)).ravel()
    for axes, (output, columns) in zip(grid, slices, strict=False):
        if output.axis is None:
            _bars(axes, result, output, columns)
        else:
            _curves(axes, result, output, columns)
        axes.ticklabel_format(axis="y", useOffset=False)
    for axes in grid[len(slices) :]:
        axes.set_axis_off()
    # Bars have their names on the axis, curves have them here.
    curves = [k for k, (output, _) in enumerate(slices) if output.axis is not None]
    if curves:
        handles, labels = grid[curves[0]].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def _shown_outputs(result: SearchResult) -> list[tuple[Output, slice]]:
    """Return the outputs to draw: all, or of very many those that make most of f."""
    slices = output_slices(result.model)
    if len(slices) <= _MOST_OUTPUTS:
        return slices
    weights = result.model.weights(result.settings.objective, result.settings.weights)
    parts = np.nan_to_num(weights * np.abs(result.y[0] - result.y[1]))
    largest = np.argsort([-parts[columns].sum() for _, columns in slices], kind="stable")
    return [slices[k] for k in sorted(largest[:_MOST_OUTPUTS])]


def _values(result: SearchResult, columns: slice) -> list[tuple[str, FloatArray]]:
    rows = (result.y_nominal, *result.y)
    return [(name, y[columns]) for name, y in zip(MODELS, rows, strict=True)]


def _curves(axes: Axes, result: SearchResult, output: Output, columns: slice) -> None:
    at = np.array(output.axis)
    if result.training_y is not None:
        for k, y in enumerate(result.training_y):
            label = "training samples" if k == 0 else None
            axes.plot(at, y[columns], color="0.8", linewidth=0.6, label=label, zorder=1)
    for name, y in _values(result, columns):
        axes.plot(
            at,
            y,
            marker="o",
            markersize=3,
            linewidth=1.6,
            color=COLOURS[name],
            label=LABELS[name],
            zorder=3,
        )
    lay_axis(axes, output)
    axes.set_ylabel(axis_label(output.name, output.unit))


def _bars(axes: Axes, result: SearchResult, output: Output, columns: slice) -> None:
    """Draw one number of each model, and the training samples' as dots."""
    if result.training_y is not None:
        y = result.training_y[:, columns].ravel()
        spread = np.linspace(-0.3, 0.3, len(y))
        axes.plot(spread, y, ".", color="0.6", markersize=3, zorder=1)
    for k, (name, value) in enumerate(_values(result, columns), start=1):
        axes.plot(
            [k - 0.35, k + 0.35],
            [value[0], value[0]],
            color=COLOURS[name],
            linewidth=3.0,
        )
    axes.set_xticks(range(4), ["training", *(LABELS[name] for name in MODELS)])
    axes.grid(axis="x", visible=False)
    axes.set_ylabel(axis_label(output.name, output.unit))


def _picture(result: SearchResult, title: str, directions: tuple[str, str]) -> Figure:
    """Lay the pictures of the three models over each other."""
    figure = Figure(figsize=(5.2, 5.6), layout="constrained")
    axes = figure.add_subplot()
    points = (result.model.nominal, *result.x)
    for name, x in zip(MODELS, points, strict=True):
        for k, shape in enumerate(result.model.draw(x)):
            _draw_shape(axes, shape, name, LABELS[name] if k == 0 else None)
    axes.set_aspect("equal")
    unit = result.model.picture_unit
    axes.set_xlabel(axis_label(directions[0], unit))
    axes.set_ylabel(axis_label(directions[1], unit))
    axes.set_title(title)
    return figure


def _draw_shape(axes: Axes, shape: Shape, name: str, label: str | None) -> None:
    points = shape.points
    if shape.kind == "closed":
        points = np.concatenate([points, points[:1]])
    link = shape.kind == "link"
    axes.plot(
        *points.T,
        color=COLOURS[name],
        linewidth=1.4,
        linestyle="--" if link else "-",
        marker="o" if link else None,
        markersize=3,
        label=label,
    )
    if shape.label and name == MODELS[0]:
        axes.annotate(
            shape.label,
            points[-1],
            xytext=(9, -10),
            textcoords="offset points",
            fontsize=8,
            color="0.2",
            bbox={"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none"},
            zorder=5,
        )

"""The paper's Figures 1, 3 and 4 for two worst-case knees."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from kneecore.figures.style import COLOURS, LABELS, along, angle_axes, curve, through_rest
from kneecore.knee.model import ALONG_LOADS
from kneecore.knee.parameters import LIGAMENTS
from kneecore.knee.response import MOMENT
from kneecore.search.result import SearchResult

__all__ = ["ap_position", "ligament_forces", "moment_angle"]

FloatArray = NDArray[np.float64]


def _draw(axes: Axes, result: SearchResult, values: dict[str, FloatArray]) -> None:
    """Draw values (12,) of the three knees against their angles."""
    model = result.model
    for name, response in result.responses.items():
        if response.status == "failed":
            continue
        axes.plot(
            along(model, np.degrees(response.flexion), through_rest(model)),
            along(model, values[name], 0.0),
            marker="o",
            markersize=3,
            linewidth=1.6,
            color=COLOURS[name],
            label=LABELS[name],
            zorder=3,
        )
    angle_axes(axes)


def moment_angle(result: SearchResult) -> Figure:
    """Draw Figure 1: moment against angle, the surrogate's training samples behind."""
    figure = Figure(figsize=(6.0, 4.2), layout="constrained")
    axes = figure.add_subplot()
    if result.training_y is not None:
        for row, y in enumerate(result.training_y):
            label = "training samples" if row == 0 else None
            axes.plot(*curve(result.model, y), color="0.8", linewidth=0.6, label=label, zorder=1)
    _draw(axes, result, dict.fromkeys(result.responses, MOMENT))
    axes.axhline(0.0, color="0.5", linewidth=0.8)
    axes.set_ylabel("external moment, N m (extension > 0)")
    axes.set_title("Moment against angle")
    axes.legend()
    return figure


def ligament_forces(result: SearchResult) -> Figure:
    """Draw Figure 3: the tension of each ligament against angle."""
    figure = Figure(figsize=(7.2, 5.4), layout="constrained")
    grid = figure.subplots(2, 2, sharex=True, sharey=True)
    for i, (axes, ligament) in enumerate(zip(grid.flat, LIGAMENTS, strict=True)):
        _draw(axes, result, {n: r.tension[:, i] for n, r in result.responses.items()})
        axes.set_title(ligament.upper())
        axes.set_ylabel("tension, N")
    grid[0, 0].legend()
    return figure


def ap_position(result: SearchResult) -> Figure:
    """Draw Figure 4: where the condyle touches the plateau, against angle."""
    figure = Figure(figsize=(6.0, 4.2), layout="constrained")
    axes = figure.add_subplot()
    order = list(ALONG_LOADS)
    for name, response in result.responses.items():
        axes.plot(
            np.degrees(response.flexion[order]),
            1e3 * response.ap_position[order],
            marker="o",
            markersize=3,
            linewidth=1.6,
            color=COLOURS[name],
            label=LABELS[name],
        )
    angle_axes(axes)
    axes.set_ylabel("contact position on the plateau, mm (anterior > 0)")
    axes.set_title("Anterior-posterior displacement")
    axes.legend()
    return figure

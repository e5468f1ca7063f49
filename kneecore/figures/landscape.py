"""A slice of a model as maps: the true model, the surrogate, and their difference."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from numpy.typing import NDArray

from kneecore.figures.style import axis_label, styled
from kneecore.study.landscape import Landscape

__all__ = ["draw", "slice_figure"]

FloatArray = NDArray[np.float64]


def draw(found: Landscape) -> dict[str, Figure]:
    """Return a slice's figures by name."""
    return {"figure_landscape": slice_figure(found)}


def slice_figure(found: Landscape, column: int | None = None) -> Figure:
    """Return the maps of one output, the one that is watched unless told otherwise."""
    model = found.model
    column = model.watched if column is None else column
    one = model.columns[column]
    sheets = {"true model": found.y[..., column]}
    if found.y_surrogate is not None and found.error is not None:
        sheets["surrogate"] = found.y_surrogate[..., column]
        sheets["surrogate - true model"] = found.error[..., column]
    both = np.stack(list(sheets.values())[:2])
    known = both[np.isfinite(both)]
    ends = (known.min(), known.max()) if len(known) else (0.0, 1.0)
    with styled():
        figure = Figure(figsize=(0.6 + 4.2 * len(sheets), 3.8), layout="constrained")
        grid = np.atleast_1d(figure.subplots(1, len(sheets), sharex=True, sharey=True))
        for k, (axes, (title, sheet)) in enumerate(zip(grid, sheets.items(), strict=True)):
            difference = k == 2
            drawn = _map(axes, found, sheet, _symmetric(sheet) if difference else ends, difference)
            figure.colorbar(drawn, ax=axes, label=axis_label(one.title, one.output.unit))
            axes.set_title(title)
            if k == 0:
                axes.set_ylabel(_input_label(found, 1))
    return figure


def _symmetric(sheet: FloatArray) -> tuple[float, float]:
    known = np.abs(sheet[np.isfinite(sheet)])
    largest = float(known.max()) if len(known) and known.max() > 0.0 else 1.0
    return -largest, largest


def _shown(found: Landscape, which: int) -> FloatArray:
    one = found.model.inputs[found.model.names.index(found.names[which])]
    return np.array([one.shown(v) for v in found.axes[which]])


def _input_label(found: Landscape, which: int) -> str:
    one = found.model.inputs[found.model.names.index(found.names[which])]
    return axis_label(one.name, "" if one.label == "-" else one.label)


def _map(
    axes: Axes, found: Landscape, sheet: FloatArray, ends: tuple[float, float], difference: bool
) -> ScalarMappable:
    """Draw one sheet, the first input to the right; where the model failed it is left white."""
    one, two = _shown(found, 0), _shown(found, 1)
    half = [0.5 * (v[1] - v[0]) for v in (one, two)]
    colours: dict[str, Any] = {"cmap": "RdBu_r" if difference else "viridis"}
    colours |= {"vmin": ends[0], "vmax": ends[1]}
    drawn: ScalarMappable
    inputs = [found.model.inputs[found.model.names.index(name)] for name in found.names]
    continuous = not any(each.is_discrete for each in inputs)
    if continuous:
        drawn = axes.imshow(
            sheet.T,
            origin="lower",
            aspect="auto",
            extent=(one[0] - half[0], one[-1] + half[0], two[0] - half[1], two[-1] + half[1]),
            interpolation="nearest",
            **colours,
        )
    else:  # perhaps not evenly spaced
        drawn = axes.pcolormesh(one, two, sheet.T, shading="nearest", **colours)
    if continuous and np.isfinite(sheet).all() and np.ptp(sheet) > 0.0:
        axes.contour(one, two, sheet.T, levels=8, colors="k", linewidths=0.5, alpha=0.5)
    axes.grid(visible=False)
    axes.set_xlabel(_input_label(found, 0))
    return drawn

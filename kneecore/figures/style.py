"""One style for all figures: PNG for people, SVG for print, the same bytes each time.

Colours mean the same everywhere (Okabe-Ito, safe for colour-blind readers): the baseline grey,
model 1 blue, model 2 orange, the surrogate purple.
"""

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from kneecore.knee.model import Knee
from kneecore.knee.parameters import N_PARAMETERS
from kneecore.knee.physics.forces import THETA_0
from kneecore.model import Model
from kneecore.outputs import Output

__all__ = [
    "COLOURS",
    "LABELS",
    "REST_DEG",
    "STYLE",
    "SURROGATE",
    "along",
    "angle_axes",
    "axis_label",
    "curve",
    "lay_axis",
    "output_slices",
    "render",
    "styled",
    "through_rest",
]

FloatArray = NDArray[np.float64]

COLOURS = {"baseline": "#8c8c8c", "model_1": "#0072B2", "model_2": "#D55E00"}
LABELS = {"baseline": "baseline", "model_1": "model 1", "model_2": "model 2"}
SURROGATE = "#CC79A7"
REST_DEG = float(np.degrees(THETA_0))
STYLE: dict[Any, Any] = {
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "figure.dpi": 150,
    "font.size": 9,
    "grid.alpha": 0.25,
    "legend.frameon": False,
    "svg.hashsalt": "kneecore",
}
_UNDATED: dict[str, dict[str, Any]] = {"png": {"Software": None}, "svg": {"Date": None}}
"""Metadata of each kind of file that would change from run to run, left out."""


@contextmanager
def styled() -> Iterator[None]:
    """Draw in our style on Matplotlib's own defaults, whatever the user's matplotlibrc says.

    Another font, or LaTeX that is not there, would change the bytes or end the drawing.
    """
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(STYLE)
        yield


def render(
    figures: Mapping[str, Figure], endings: Sequence[str] = tuple(_UNDATED)
) -> Iterator[tuple[str, bytes]]:
    """Yield (file name, content) of each figure as PNG and as SVG; the bytes are reproducible."""
    for name, figure in figures.items():
        for ending in endings:
            buffer = io.BytesIO()
            with styled():
                figure.savefig(buffer, format=ending, metadata=_UNDATED[ending])
            yield f"{name}.{ending}", buffer.getvalue()


def axis_label(name: str, unit: str) -> str:
    """Return an axis's label: `gain, dB`."""
    return f"{name}, {unit}" if unit else name


def lay_axis(axes: Axes, output: Output) -> None:
    """Label the horizontal axis as an output's, by decades where its steps are equal factors."""
    axes.set_xlabel(axis_label(output.axis_name or "axis", output.axis_unit))
    at = np.array(output.axis)
    if len(at) > 2 and at.min() > 0.0 and at.max() > 3.0 * at.min():
        factors = at[1:] / at[:-1]
        if np.ptp(factors) < 1e-6 * abs(factors[0]):
            axes.set_xscale("log")


def through_rest(model: Model) -> float | None:
    """Return the angle (deg) in which all knees of a model are at rest without load, or None.

    Not knees with the baseline's rest lengths, or with lengths that are uncertain themselves; no
    other model has such a point.
    """
    if not isinstance(model, Knee):
        return None
    strain_free = model.rest_length == "recomputed" and len(model.lower) == N_PARAMETERS
    return REST_DEG if strain_free else None


def output_slices(model: Model) -> list[tuple[Output, slice]]:
    """Return each output with its columns."""
    first, found = 0, []
    for output in model.outputs:
        found.append((output, slice(first, first + output.n_columns)))
        first += output.n_columns
    return found


def along(model: Model, values: FloatArray, at_rest: float | None) -> FloatArray:
    """Return the columns' values in `Model.order`, with a knee's value without load between."""
    ordered = values[..., list(model.order)]
    if at_rest is None or through_rest(model) is None:
        return ordered
    return np.insert(ordered, ordered.shape[-1] // 2, at_rest, axis=-1)


def curve(model: Model, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a knee's (angles in deg, moments in N m) in the order of the motion."""
    moments = np.array(model.outputs[0].axis)
    return along(model, y, through_rest(model)), along(model, moments, 0.0)


def angle_axes(axes: Axes) -> None:
    """Label the axes of moment against knee angle, as the paper has them."""
    axes.axvline(0.0, color="0.5", linewidth=0.8, linestyle=":")
    axes.set_xlabel("knee angle, deg (flexion > 0)")

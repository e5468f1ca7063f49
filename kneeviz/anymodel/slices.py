"""What a model's landscape shows: one output over two inputs. Pure."""

import numpy as np
from numpy.typing import NDArray

from kneecore import Landscape
from kneeviz.anymodel.dials import Dial
from kneeviz.anymodel.state import ModelState
from kneeviz.geometry.picture import Mark, Picture

FloatArray = NDArray[np.float64]

_LEAST_SPAN = 1e-6
"""Of the values: a flat sheet is no mountain of rounding errors."""


def picture_of(state: ModelState, found: Landscape) -> Picture:
    """Return the landscape of the output that was chosen."""
    k, model = state.column, state.model
    first, second = (model.names.index(name) for name in found.names)
    free = np.cumsum(model.free) - 1
    spot = free[[first, second]]
    y = found.y[..., k]
    sheet = None if found.y_surrogate is None else found.y_surrogate[..., k]
    if state.in_surrogate:
        y, sheet = np.full(y.shape, np.nan), y
    known = found.y[..., k][np.isfinite(found.y[..., k])]
    return Picture(
        names=found.names,
        ends=(_ends(state.dials[spot[0]]), _ends(state.dials[spot[1]])),
        model=y,
        surrogate=sheet,
        training=_training(state, spot, k),
        own=_own(state, found, spot),
        predicted=None,
        worst=_worst(state, spot, k),
        unit=model.columns[k].output.unit,
        own_label="yours",
        least_span=max(_LEAST_SPAN * float(np.abs(known).max(initial=0.0)), 1e-300),
    )


def _ends(one: Dial) -> tuple[float, float]:
    return one.lower / one.scale, one.upper / one.scale


def _place(state: ModelState, x: FloatArray, spot: NDArray[np.int64]) -> tuple[float, float]:
    unit = state.model.to_free_unit(x)
    return float(unit[spot[0]]), float(unit[spot[1]])


def _own(state: ModelState, found: Landscape, spot: NDArray[np.int64]) -> Mark:
    """Return the slice's point: the model there, or the nearest of the grid."""
    k, last = state.column, state.last
    place = _place(state, found.x, spot)
    if last is not None and last.y is not None and np.array_equal(last.x, found.x):
        value = float(last.y[k])
    else:
        i, j = (round(p * (n - 1)) for p, n in zip(place, found.y.shape, strict=False))
        value = float(found.y[i, j, k])
    return Mark(place=place, value=value)


def _worst(state: ModelState, spot: NDArray[np.int64], k: int) -> tuple[Mark | None, Mark | None]:
    if state.result is None:
        return None, None
    one, two = (
        Mark(place=_place(state, x, spot), value=float(y[k])) if np.isfinite(y[k]) else None
        for x, y in zip(state.result.x, state.result.y, strict=True)
    )
    return one, two


def _training(state: ModelState, spot: NDArray[np.int64], k: int) -> FloatArray:
    if state.surrogate is None:
        return np.zeros((0, 3))
    trained = state.surrogate
    places = state.model.to_free_unit(trained.training_x)[:, spot]
    points = np.column_stack([places, trained.training_y[:, k]])
    return points[np.isfinite(points).all(axis=1)]

"""What a landscape shows: two sheets over two parameters, and knees marked on them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore import Knee, Landscape, ParameterSpace, TrainedSurrogate, reading
from kneecore.knee.parameters import display_values

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Mark:
    """One knee over the two parameters."""

    place: tuple[float, float]
    """Where it lies between the bounds of the two parameters, 0 to 1 inside."""
    value: float
    """Its reading, deg."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Picture:
    """What the landscape shows."""

    names: tuple[str, str]
    ends: tuple[tuple[float, float], tuple[float, float]]
    """Bounds of the two parameters in their display units."""
    model: FloatArray
    """The true model's sheet, shape (n, n), deg; NaN where the model failed."""
    surrogate: FloatArray | None
    """The surrogate's sheet, shape (n, n), deg."""
    training: FloatArray
    """The surrogate's training knees, shape (k, 3): place and reading."""
    own: Mark
    """The visitor's knee in the true model."""
    predicted: Mark | None
    """The same in the surrogate."""
    worst: tuple[Mark | None, Mark | None]
    """The two worst cases in the true model."""
    unit: str = "°"
    own_label: str = "your knee"
    least_span: float = 1.0
    """Least height, in `unit`: a flat sheet is no mountain of rounding errors."""


def space_of(found: Landscape) -> ParameterSpace:
    """Return the bounds that a slice lies in."""
    assert isinstance(found.model, Knee)
    return found.model.space


def _marked(
    place: FloatArray, angles_deg: ArrayLike | None, columns: Sequence[int], name: str
) -> Mark | None:
    if angles_deg is None:
        return None
    value = float(reading(angles_deg, name))
    first, second = (float(place[i]) for i in columns)
    return Mark(place=(first, second), value=value) if np.isfinite(value) else None


def _training(
    surrogate: TrainedSurrogate | None, space: ParameterSpace, columns: Sequence[int], name: str
) -> FloatArray:
    if surrogate is None:
        return np.zeros((0, 3))
    places = space.to_unit(surrogate.training_x)[:, list(columns)]
    values = reading(surrogate.training_y, name)
    points = np.column_stack([places, values])
    return points[np.isfinite(values)]


def picture(
    found: Landscape,
    name: str,
    *,
    own_deg: ArrayLike,
    predicted_deg: ArrayLike | None,
    surrogate: TrainedSurrogate | None,
    worst: Sequence[tuple[FloatArray, ArrayLike]] = (),
) -> Picture:
    """Return what a slice shows for one reading.

    Parameters
    ----------
    found : Landscape
    name : str
        One of kneecore's `READINGS`.
    own_deg, predicted_deg : array_like, shape (12,)
        Angles of the slice's knee in the true model and in the surrogate, deg.
    surrogate : TrainedSurrogate or None
        Its training knees are shown.
    worst : sequence of (x, angles in deg)
        The two worst cases, or nothing.
    """
    space = space_of(found)
    columns = [space.names.index(n) for n in found.names]
    place = space.to_unit(found.x[: len(space.names)])  # rest lengths may be changed, but held
    own = _marked(place, own_deg, columns, name)
    assert own is not None  # the knee on screen is one that did not fail
    marks = [_marked(space.to_unit(x), angles, columns, name) for x, angles in worst]
    one, two = marks if len(marks) == 2 else (None, None)
    return Picture(
        names=found.names,
        ends=_ends(found),
        model=reading(found.y, name),
        surrogate=None if found.y_surrogate is None else reading(found.y_surrogate, name),
        training=_training(surrogate, space, columns, name),
        own=own,
        predicted=_marked(place, predicted_deg, columns, name),
        worst=(one, two),
    )


def _ends(found: Landscape) -> tuple[tuple[float, float], tuple[float, float]]:
    space = space_of(found)
    lower, upper = display_values(space.lower), display_values(space.upper)
    first, second = (space.names.index(name) for name in found.names)
    return (lower[first], upper[first]), (lower[second], upper[second])

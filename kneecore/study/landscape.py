"""A slice of the parameter space: the angles over two parameters, the others held.

The true model's angles and, beside them, a surrogate's.

Examples
--------
>>> import kneecore
>>> space = kneecore.ParameterSpace()
>>> slice_ = kneecore.landscape(space.baseline, ("condyle_x", "pcl_femur_x"), n_points=5)
>>> slice_.reading("+5 N m").shape
(5, 5)
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore.errors import ParameterError
from kneecore.knee.model import KneeSurrogate
from kneecore.knee.parameters import check_physical, widened
from kneecore.knee.response import MOMENT, RestLength, simulate_batch
from kneecore.knee.space import ParameterSpace
from kneecore.numerics.sampling import check_count
from kneecore.search.result import LARGEST_EXTENSION

__all__ = ["DEFICIT", "READINGS", "Landscape", "landscape", "reading"]

FloatArray = NDArray[np.float64]

DEFICIT = "extension deficit"
"""How far a knee stays bent under the largest extending moment, deg; 0 if it becomes straight."""
READINGS = (DEFICIT, *(f"{m:+g} N m" for m in MOMENT[np.argsort(-MOMENT)]))
"""What can be read from 12 angles: the deficit, or the angle at a load."""


def reading(flexion_deg: ArrayLike, name: str) -> FloatArray:
    """Return one number for each knee, shape (..., 12) -> (...,), deg.

    Parameters
    ----------
    flexion_deg : array_like, shape (..., 12)
        Angles at the 12 loads, deg.
    name : str
        One of `READINGS`.

    Raises
    ------
    ParameterError
        If there is no such reading.
    """
    angles = np.asarray(flexion_deg, dtype=np.float64)
    if name not in READINGS:
        raise ParameterError(f"`name` is {name!r}; {', '.join(READINGS)} are allowed")
    if name == DEFICIT:
        return np.maximum(angles[..., LARGEST_EXTENSION], 0.0)
    load = next(k for k, m in enumerate(MOMENT) if f"{m:+g} N m" == name)
    return np.asarray(angles[..., load])


@dataclass(frozen=True, kw_only=True, eq=False)
class Landscape:
    """The 12 angles over a square grid of two parameters."""

    space: ParameterSpace
    rest_length: RestLength
    names: tuple[str, str]
    """The two parameters."""
    x: FloatArray
    """The knee whose other values are held, shape (28,) or (32,), SI."""
    axes: tuple[FloatArray, FloatArray]
    """The two parameters' values from bound to bound, shape (n,) each, SI."""
    model_deg: FloatArray
    """The true model's angles, shape (n, n, 12), deg, the first parameter along the first axis;
    NaN where the model failed."""
    surrogate_deg: FloatArray | None
    """The surrogate's angles, shape (n, n, 12), deg, or None where there is no surrogate."""

    @property
    def n_models(self) -> int:
        """Number of knees that were simulated."""
        return int(self.model_deg[..., 0].size)

    @property
    def n_failed(self) -> int:
        """Number of knees whose model failed."""
        return int(np.isnan(self.model_deg[..., 0]).sum())

    def reading(self, name: str) -> FloatArray:
        """Return the true model's sheet, shape (n, n), deg; `name` is one of `READINGS`."""
        return reading(self.model_deg, name)

    def surrogate_reading(self, name: str) -> FloatArray | None:
        """Return the surrogate's sheet, shape (n, n), deg, or None."""
        return None if self.surrogate_deg is None else reading(self.surrogate_deg, name)

    def error(self, name: str) -> FloatArray | None:
        """Return surrogate less true model, shape (n, n), deg; NaN where the model failed."""
        predicted = self.surrogate_reading(name)
        return None if predicted is None else predicted - self.reading(name)


def _columns(names: Sequence[str], space: ParameterSpace) -> tuple[int, int]:
    free = [name for name, is_free in zip(space.names, space.free, strict=True) if is_free]
    if len(names) != 2 or names[0] == names[1] or not set(names) <= set(free):
        raise ParameterError(
            f"`names` is {tuple(names)!r}; two different of the free parameters are allowed: "
            f"{', '.join(free)}"
        )
    return space.names.index(names[0]), space.names.index(names[1])


def landscape(
    x: ArrayLike,
    names: Sequence[str],
    *,
    space: ParameterSpace | None = None,
    surrogate: KneeSurrogate | None = None,
    n_points: int = 33,
    rest_length: RestLength = "recomputed",
    threads: int | None = None,
) -> Landscape:
    """Simulate a grid of knees that differ from `x` in two parameters only.

    The true model runs its dynamics, which is what a surrogate has learned from.

    Parameters
    ----------
    x : array_like, shape (28,) or (32,)
        The knee around which the slice is laid, SI.
    names : sequence of 2 str
        The two parameters; they must be free in `space`.
    space : ParameterSpace, optional
        Its bounds are the ends of the grid; the packaged baseline's for None.
    surrogate : KneeSurrogate, optional
        To be evaluated on the same grid.
    n_points : int
        Grid points along each parameter, at least 2.
    rest_length, threads
        As for `simulate_batch`.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    space = space or ParameterSpace()
    centre = check_physical(x, "x")
    if centre.ndim != 1:
        raise ParameterError(f"`x` has shape {centre.shape}; (28,) or (32,) is allowed")
    if not centre[len(space.names) :].any():  # else rest lengths are changed, but held
        centre = widened(centre, len(space.names))
    first, second = _columns(names, space)
    if check_count("n_points", n_points) < 2:
        raise ParameterError(f"`n_points` is {n_points}; at least 2 are allowed")
    axes = tuple(np.linspace(space.lower[i], space.upper[i], n_points) for i in (first, second))
    knees = np.tile(centre, (n_points, n_points, 1))
    knees[..., first], knees[..., second] = axes[0][:, None], axes[1][None, :]
    flat = knees.reshape(-1, len(centre))
    batch = simulate_batch(flat, baseline=space.baseline, rest_length=rest_length, threads=threads)
    shape = (n_points, n_points, len(MOMENT))
    predicted = None if surrogate is None else np.degrees(surrogate.predict(flat)).reshape(shape)
    return Landscape(
        space=space,
        rest_length=rest_length,
        names=(names[0], names[1]),
        x=centre,
        axes=(axes[0], axes[1]),
        model_deg=np.degrees(batch.flexion).reshape(shape),
        surrogate_deg=predicted,
    )

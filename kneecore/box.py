"""The box of a model's inputs: bounds, and the unit cube of those that vary."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._arguments import number
from kneecore._arrays import numbers
from kneecore.errors import ParameterError
from kneecore.inputs import Input, all_of

__all__ = ["Box"]

FloatArray = NDArray[np.float64]


class Box:
    """Uncertain inputs, of which some may be held.

    Parameters
    ----------
    inputs : sequence of Input

    Raises
    ------
    ParameterError
        If they are no such list, share a name, or have no width at all.
    """

    def __init__(self, inputs: Sequence[Input]) -> None:
        self.inputs: tuple[Input, ...] = all_of(Input, "inputs", inputs)
        self.nominal = _held([number("nominal", i.nominal) for i in self.inputs])
        self._lay_bounds()
        self.free = self.upper > self.lower
        self.free.setflags(write=False)
        if not self.free.any():
            raise ParameterError("all bounds have zero width; at least one above 0 is needed")

    def _lay_bounds(self) -> None:
        self.lower = _held([i.lower for i in self.inputs])
        self.upper = _held([i.upper for i in self.inputs])

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return tuple(i.name for i in self.inputs)

    @property
    def free_names(self) -> tuple[str, ...]:
        """Names of the inputs that vary."""
        return tuple(n for n, free in zip(self.names, self.free, strict=True) if free)

    @property
    def n_free(self) -> int:
        """Number of inputs that vary."""
        return int(np.count_nonzero(self.free))

    def from_free_unit(self, u: ArrayLike) -> FloatArray:
        """Map points of the free inputs' unit cube, shape (..., n_free), to inputs, (..., d)."""
        unit = numbers("u", u)
        if unit.ndim == 0 or unit.shape[-1] != self.n_free:
            raise ParameterError(f"`u` has shape {unit.shape}; (..., {self.n_free}) is allowed")
        full = np.full((*unit.shape[:-1], len(self.inputs)), 0.5)
        full[..., self.free] = unit
        return np.clip(self.lower + full * (self.upper - self.lower), self.lower, self.upper)

    def to_free_unit(self, x: ArrayLike) -> FloatArray:
        """Map inputs, shape (..., d), to the free inputs' unit cube, (..., n_free)."""
        values = self._points("x", x)
        width = (self.upper - self.lower)[self.free]
        unit: FloatArray = (values - self.lower)[..., self.free] / width
        return unit

    def at_bounds(self, x: ArrayLike, *, tolerance: float = 1e-3) -> NDArray[np.int8]:
        """Tell which inputs lie on a bound: -1 lower, +1 upper, 0 neither (or held).

        `tolerance` is a share of the input's range.
        """
        unit, tolerance = self.to_free_unit(x), number("tolerance", tolerance)
        side = np.where(unit <= tolerance, -1, np.where(unit >= 1.0 - tolerance, 1, 0))
        sides = np.zeros((*unit.shape[:-1], len(self.inputs)), dtype=np.int8)
        sides[..., self.free] = side
        return sides

    def point(self, x: ArrayLike) -> FloatArray:
        """Return one point, shape (d,), checked and copied."""
        values = np.array(self._points("x", x))
        if values.ndim != 1 or not np.isfinite(values).all():
            raise ParameterError(
                f"`x` has shape {values.shape}; one point, ({len(self.inputs)},), of finite "
                "numbers is allowed"
            )
        return values

    def _points(self, argument: str, x: ArrayLike) -> FloatArray:
        allowed = f"(..., {len(self.inputs)}) is allowed"
        values = numbers(argument, x, allowed)
        if np.ma.isMaskedArray(x) or values.ndim == 0 or values.shape[-1] != len(self.inputs):
            raise ParameterError(f"`{argument}` has shape {values.shape}; {allowed}")
        return values


def _held(values: Sequence[float]) -> FloatArray:
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array

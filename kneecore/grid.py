"""The values that an input may have where these are few: whole numbers, or a list."""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._arguments import number, shown
from kneecore.errors import ParameterError

__all__ = ["MOST_VALUES", "Grid", "choices_of", "whole_within"]

FloatArray = NDArray[np.float64]

MOST_VALUES = 100_000
_ROUNDING = 1e-9  # of a bound: 0.1 * 30 is meant to be 3


@dataclass(frozen=True, eq=False)
class Grid:
    """Values in ascending order, on places of equal width between 0 and 1.

    The k-th of n values stands for the k-th of n equal parts of the unit interval, so that each is
    as likely as another, and its own place is k / (n - 1), so that the ends are at 0 and 1.
    """

    values: FloatArray
    """Shape (n,), n above 1."""

    @property
    def places(self) -> FloatArray:
        """Where the values are in the unit interval, shape (n,)."""
        return np.arange(len(self.values)) / (len(self.values) - 1)

    def at(self, u: ArrayLike) -> FloatArray:
        """Return the value whose part of the unit interval each of `u` is in."""
        return self.values[self._indices(u)]

    def snapped(self, u: ArrayLike) -> FloatArray:
        """Return the places of the values that `at` returns."""
        snapped: FloatArray = self._indices(u) / (len(self.values) - 1)
        return snapped

    def place(self, x: ArrayLike) -> FloatArray:
        """Return the places of the values that are nearest to `x`."""
        middles = 0.5 * (self.values[1:] + self.values[:-1])
        place: FloatArray = np.searchsorted(middles, x) / (len(self.values) - 1)
        return place

    def _indices(self, u: ArrayLike) -> NDArray[np.int64]:
        n = len(self.values)
        parts = np.floor(np.asarray(u, dtype=np.float64) * n)
        return np.clip(parts, 0, n - 1).astype(np.int64)


def whole_within(name: str, lower: float, upper: float) -> tuple[float, float]:
    """Return the first and the last whole number between bounds.

    Raises
    ------
    ParameterError
        If there is none, or there are too many.
    """
    slack = _ROUNDING * max(abs(lower), abs(upper))
    first, last = float(np.ceil(lower - slack)), float(np.floor(upper + slack))
    if first > last:
        raise ParameterError(
            f"`integer of {name}` is True, and between its bounds, {lower:g} and {upper:g}, there "
            "is no whole number"
        )
    if last - first >= MOST_VALUES:
        raise ParameterError(
            f"`integer of {name}` is True, and its bounds hold {last - first + 1:.6g} whole "
            f"numbers; at most {MOST_VALUES:,} are allowed (as a number like others it would do)"
        )
    return first + 0.0, last + 0.0


def choices_of(name: str, given: Any) -> tuple[float, ...]:
    """Return choices checked, in ascending order.

    Raises
    ------
    ParameterError
        If they are not different finite numbers, or too many.
    """
    listed = isinstance(given, tuple | list | np.ndarray) and np.ndim(given) == 1
    if not listed or not 1 <= len(given) <= MOST_VALUES:
        raise ParameterError(
            f"`choices of {name}` is {shown(given)}; a row of 1 to {MOST_VALUES:,} numbers is "
            "allowed"
        )
    values = sorted(number(f"choices of {name}", value) for value in given)
    twice = next((a for a, b in itertools.pairwise(values) if a == b), None)
    if twice is not None:
        raise ParameterError(f"`choices of {name}` has {twice:g} twice; once is enough")
    return tuple(values)

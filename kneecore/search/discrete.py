"""Searches where some inputs have few values: whole numbers and choices.

A surrogate is fitted to, and asked at, the places of allowed values only. A climb with gradients
knows nothing of them: where it ends, each such input tries all of its values, one input after the
other, as long as that gains.
"""

import itertools
import math
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from kneecore.box import Box
from kneecore.grid import Grid
from kneecore.numerics.sampling import uniform
from kneecore.numerics.surrogate import Surrogate

__all__ = ["OnGrids", "combinations", "first_points", "polished", "polished_pair"]

FloatArray = NDArray[np.float64]

Outputs = Callable[[FloatArray], FloatArray]
"""Points (n, n_free) to outputs (n, m)."""

_MOST_ROUNDS = 20
_MOST_TRIED = 64  # values of one input


def combinations(box: Box) -> float:
    """Return how many different points there are; infinity where an input varies continuously."""
    if len(box.grids) < box.n_free:
        return math.inf
    return float(math.prod(len(grid.values) for grid in box.grids.values()))


def first_points(box: Box, n: int, seed: int) -> FloatArray:
    """Return n different points of the unit cube to fit a surrogate to.

    They are uniform; where there are no more than n combinations of values, they are all of these.
    """
    if not box.grids:
        return uniform(n, box.n_free, seed)
    if combinations(box) <= n:
        return np.array(list(itertools.product(*(grid.places for grid in box.grids.values()))))
    n_drawn = n
    while True:
        n_drawn *= 2
        u = box.snapped(uniform(n_drawn, box.n_free, seed))
        first = np.unique(u, axis=0, return_index=True)[1]
        if len(first) >= n:
            return u[np.sort(first)[:n]]


class OnGrids:
    """A surrogate that is asked at the places of allowed values only."""

    def __init__(self, surrogate: Surrogate, box: Box) -> None:
        self._surrogate, self._box = surrogate, box

    def __call__(self, u: FloatArray) -> FloatArray:
        """Return outputs of points, shape (n, n_free) -> (n, m)."""
        return self._surrogate(self._box.snapped(u))


def _near(grid: Grid, place: float) -> FloatArray:
    """Return the places to try from one: all, or the nearest and the ends."""
    places = grid.places
    if len(places) <= _MOST_TRIED:
        return places
    k = round(place * (len(places) - 1))
    first = min(max(k - _MOST_TRIED // 2, 0), len(places) - _MOST_TRIED)
    return np.concatenate([places[[0, -1]], places[first : first + _MOST_TRIED]])


def polished(
    surrogate: Outputs, sums: FloatArray, u: FloatArray, grids: Mapping[int, Grid]
) -> FloatArray:
    """Return a point (n_free,) from which no input with few values can raise the sum, (m,), alone.

    `u` is at places of allowed values.
    """
    best, value = u, float(surrogate(u[None])[0] @ sums)
    for _ in range(_MOST_ROUNDS):
        before = value
        for j, grid in grids.items():
            tried = _near(grid, best[j])
            points = np.repeat(best[None], len(tried), axis=0)
            points[:, j] = tried
            values = surrogate(points) @ sums
            if values.max() > value:
                best, value = points[int(np.argmax(values))], float(values.max())
        if value == before:
            break
    return best


def polished_pair(
    surrogate: Surrogate, weights: FloatArray, u: FloatArray, box: Box
) -> tuple[FloatArray, float]:
    """Return a pair (2, n_free) at allowed values, as different as such steps make it, and its f.

    The signs of the outputs' differences say what each of the two is to have large.
    """
    pair, f = box.snapped(u), -np.inf
    for _ in range(_MOST_ROUNDS):
        y = surrogate(pair)
        value = float((np.abs(y[0] - y[1]) * weights).sum())
        if value <= f:
            break
        best, f = pair, value
        signs = np.where(y[0] >= y[1], 1.0, -1.0) * weights
        ends = [polished(surrogate, signs, pair[0], box.grids)]
        ends.append(polished(surrogate, -signs, pair[1], box.grids))
        pair = np.array(ends)
    return best, f

"""How large the largest difference can be, if slopes stay within the range that samples show.

For a pattern of signs s, f is max s.y minus min s.y over the box. By the mean-value theorem neither
is further from its value at a vertex than slopes allow on the way there. With slopes sampled over
the whole box, that is said of all patterns at once, and rules most of them out. On those that are
left one looks closer: an input whose slope keeps its sign over all samples is put on its better
side; on the face that is left slopes are sampled anew, until no more inputs are decided, and the
vertices of the others are enumerated. Of a pattern that is still not ruled out the box is halved in
the input that leaves most open, and slopes are sampled anew in both parts; a widening is a share of
each part's own range. Every range in this is sampled: no proof.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from heapq import heapify, heapreplace
from itertools import product

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from kneecore.errors import ModelError
from kneecore.numerics.box_climb import Slopes
from kneecore.search.half_bound import Half, Range, failing, points, rise, widened
from kneecore.search.settings import MAX_COUNTING

__all__ = ["PairBound", "bound_pair"]

FloatArray = NDArray[np.float64]
Tell = Callable[[float], object]

MAX_LOOKS = 24
"""Patterns that are looked at closer; for the others the bound by slopes over the box stands."""
MAX_SPLITS = 48
"""Times that a box is halved, over all patterns."""
_ENOUGH = 1.005
"""Times the f that is known: a bound this near is not worth another part."""
_BLOCK = 2**20  # numbers of a block of samples with their slopes; patterns take four times that


@dataclass(frozen=True, kw_only=True, eq=False)
class PairBound:
    """The largest f of two models, as far as samples show."""

    widening: float
    """Share of the sampled range of slopes by which it was taken larger, each side."""
    best: float
    """Largest enumerated f, or the known one where that is larger."""
    bound: float
    """Sampled bound of f over all patterns."""
    n_looks: int
    """Patterns that slopes over the box could not rule out, and that were looked at closer."""


def _box_ranges(
    slopes: Slopes, d: int, units: FloatArray, patterns: FloatArray, n_samples: int, seed: int
) -> Range:
    """Return the range of slopes over the box for each pattern, shapes (n, d) and (n, d).

    `units` (k, m) has the weight of one output that counts in each row, `patterns` (n, k) signs.
    """
    rng = np.random.default_rng(seed)
    rows = max(1, _BLOCK // (len(units) * d))
    some = max(1, 4 * _BLOCK // (rows * d))
    low, high = (np.full((len(patterns), d), v) for v in (np.inf, -np.inf))
    for first in range(0, n_samples, rows):
        u = points(rng, min(rows, n_samples - first), d)
        each = []
        for unit in units:
            values, gradient, _ = slopes(u, np.tile(unit, (len(u), 1)))
            if not np.isfinite(values).all():
                raise failing()
            each.append(gradient.ravel())
        by_output = np.stack(each)
        for k in range(0, len(patterns), some):
            part = slice(k, k + some)
            with threadpool_limits(limits=1, user_api="blas"):
                gradients = (patterns[part] @ by_output).reshape(-1, len(u), d)
            low[part] = np.minimum(low[part], gradients.min(axis=1))
            high[part] = np.maximum(high[part], gradients.max(axis=1))
    return low, high


def _by_box(slopes: Slopes, weights: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return a bound for each pattern, shape (n,), by the slopes over the box alone."""
    total = np.zeros(len(weights))
    for side, (least, most) in ((1.0, (low, high)), (-1.0, (-high, -low))):
        at = (least + most > 0.0).astype(np.float64)
        values = slopes(at, side * weights)[0]
        if not np.isfinite(values).all():
            raise failing()
        total += values + rise(least, most, at)
    return total


def bound_pair(
    slopes: Slopes,
    d: int,
    weights: FloatArray,
    *,
    known: float = 0.0,
    n_samples: int = 9000,
    widenings: tuple[float, ...] = (0.0,),
    seed: int = 0,
    tell: Tell | None = None,
) -> tuple[PairBound, ...]:
    """Bound f, the weighted sum of the outputs' differences, over all patterns of signs.

    Parameters
    ----------
    slopes : callable
        See `kneecore.numerics.box_climb.Slopes`.
    d : int
        Dimensions of the unit cube.
    weights : ndarray, shape (m,)
        Weight of each output's difference, none negative.
    known : float
        An f that a search has found: patterns that cannot reach it are not looked at.
    n_samples : int
        Samples of slopes over the box, and over each face.
    widenings : tuple of float
        Shares of the sampled range of slopes by which it is taken larger, rising.
    seed : int
    tell : callable, optional
        Gets the share that is done.

    Returns
    -------
    tuple of PairBound
        One for each widening.

    Raises
    ------
    ModelError
        If more than `MAX_COUNTING` outputs count, or models fail.
    """
    counting = np.flatnonzero(weights)
    if len(counting) > MAX_COUNTING:
        raise ModelError(f"{len(counting)} outputs count; a sampled bound takes {MAX_COUNTING}")
    units = np.diag(weights)[counting]
    signs = np.array([(1.0, *s) for s in product((1.0, -1.0), repeat=len(counting) - 1)])
    low, high = _box_ranges(slopes, d, units, signs, n_samples, seed)
    found: list[PairBound] = []
    for widening in widenings:
        if tell is not None:
            tell((1.0 + len(found)) / (1.0 + len(widenings)))
        first = _by_box(slopes, signs @ units, *widened(low, high, widening))

        def look(k: int, widening: float = widening) -> _Pattern:
            return _Pattern(
                [
                    Half(slopes, side * (signs[k] @ units), n_samples, widening, seed)
                    for side in (1.0, -1.0)
                ],
                low[k],
                high[k],
            )

        one = _over_patterns(first, look, known, widening)
        least = found[-1].bound if found else known  # a wider range cannot say less
        found.append(replace(one, bound=max(one.bound, least)))
    return tuple(found)


class _Pattern:
    """A pattern of signs that is looked at closer: the sum's largest value, less its smallest."""

    def __init__(self, halves: list[Half], low: FloatArray, high: FloatArray) -> None:
        self._halves = halves
        nothing, whole = np.zeros(len(low)), np.ones(len(low))
        for half, box in zip(halves, ((low, high), (-high, -low)), strict=True):
            half.add(nothing, whole, box)

    @property
    def bound(self) -> float:
        return sum(half.bound for half in self._halves)

    @property
    def best(self) -> float:
        """The largest f that was enumerated; minus infinity where a half was not."""
        values = [half.best for half in self._halves]
        return sum(-np.inf if v is None else v for v in values)

    def split(self) -> bool:
        """Halve a part of the half that leaves more open; return whether there was one."""
        half = max(self._halves, key=lambda half: half.left_open)
        if half.left_open <= 0.0:
            return False
        half.split()
        return True


def _over_patterns(
    first: FloatArray, look: Callable[[int], _Pattern], known: float, widening: float
) -> PairBound:
    """Bound f over patterns, given bounds (n,) by the box alone: always work on the largest."""
    waiting = [(-float(bound), k) for k, bound in enumerate(first)]
    heapify(waiting)
    looked: dict[int, _Pattern] = {}
    n_splits = 0
    while -waiting[0][0] > known:
        bound, k = -waiting[0][0], waiting[0][1]
        if k not in looked:
            if len(looked) == MAX_LOOKS:
                break
            looked[k] = look(k)
        elif bound <= _ENOUGH * known or n_splits == MAX_SPLITS or not looked[k].split():
            break
        else:
            n_splits += 1
        heapreplace(waiting, (-min(bound, looked[k].bound), k))
    return PairBound(
        widening=widening,
        best=max([known, *(pattern.best for pattern in looked.values())]),
        bound=max(known, -waiting[0][0]),
        n_looks=len(looked),
    )

"""How large the largest difference can be, if slopes stay within the range that samples show.

For a pattern of signs s, f is max s.y minus min s.y over the box. By the mean-value theorem neither
is further from its value at a vertex than slopes allow on the way there. With slopes sampled over
the whole box, that is said of all patterns at once, and rules most of them out. On those that are
left one looks closer: an input whose slope keeps its sign over all samples is put on its better
side; on the face that is left slopes are sampled anew, until no more inputs are decided, and the
vertices of the others are enumerated. Every range in this is sampled: no proof.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from kneecore.errors import ModelError
from kneecore.numerics.box_climb import Slopes
from kneecore.search.settings import MAX_COUNTING

__all__ = ["MAX_ENUMERATED", "HalfBound", "PairBound", "bound_half", "bound_pair"]

FloatArray = NDArray[np.float64]
Range = tuple[FloatArray, FloatArray]
Tell = Callable[[float], object]

MAX_ENUMERATED = 12
"""Inputs without a sign of their own up to which vertices are enumerated."""
MAX_LOOKS = 24
"""Patterns that are looked at closer; for the others the bound by slopes over the box stands."""
_BLOCK = 2**20  # numbers of a block of samples with their slopes; patterns take four times that


@dataclass(frozen=True, kw_only=True, eq=False)
class HalfBound:
    """The largest weighted sum of outputs over the box, as far as samples show."""

    n_one_signed: int
    """Inputs whose slope kept its sign over the box's samples."""
    best: float | None
    """Largest value over the vertices that are left; None if they are too many to enumerate."""
    bound: float
    """Sampled bound: from the best vertex or from the middle, whichever is lower."""


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


def _fails() -> ModelError:
    return ModelError("models within the bounds fail; there is no sampled bound over them")


def _sampled(slopes: Slopes, u: FloatArray, weights: FloatArray) -> Range:
    values, gradient, _ = slopes(u, np.tile(weights, (len(u), 1)))
    if not np.isfinite(values).all():
        raise _fails()
    return gradient.min(axis=0), gradient.max(axis=0)


def _widened(low: FloatArray, high: FloatArray, widening: float) -> Range:
    pad = widening * (high - low)
    return low - pad, high + pad


def _rise(low: FloatArray, high: FloatArray, at: FloatArray) -> FloatArray:
    """Return by how much a value may rise at most on the way from vertices `at`, by the slopes."""
    most = np.maximum(high * (1.0 - at), -low * at)
    return np.asarray(np.maximum(0.0, most).sum(axis=-1))


def _points(rng: np.random.Generator, n: int, d: int) -> FloatArray:
    """Half of them spread over the box, half on its vertices, where slopes are often extreme."""
    u = rng.random((n, d))
    u[::2] = np.round(u[::2])
    return u


def bound_half(
    slopes: Slopes,
    d: int,
    weights: FloatArray,
    *,
    n_samples: int = 9000,
    widening: float = 0.0,
    seed: int = 0,
    box: Range | None = None,
) -> HalfBound:
    """Bound a weighted sum of outputs over the unit cube, by sampled slopes.

    `widening` is the share of the sampled range of slopes by which it is taken larger, each side;
    `box` the range over the whole cube, where it is known.
    """
    rng = np.random.default_rng(seed)
    at = np.full(d, np.nan)
    n_one_signed: int | None = None
    while True:
        if box is None:
            u = np.where(np.isnan(at), _points(rng, n_samples, d), at)
            box = _sampled(slopes, u, weights)
        low, high = _widened(*box, widening)
        box = None
        free = np.isnan(at)
        at[free & (low >= 0.0)] = 1.0
        at[free & (low < 0.0) & (high <= 0.0)] = 0.0
        left = np.flatnonzero(np.isnan(at))
        if n_one_signed is None:
            n_one_signed = d - len(left)
        if len(left) in (0, np.count_nonzero(free)):
            break
    middle = np.where(np.isnan(at), 0.5, at)[None]
    value = slopes(middle, weights[None])[0]
    if not np.isfinite(value).all():
        raise _fails()
    bound = float(value[0]) + 0.5 * float(np.maximum(-low[left], high[left]).sum())
    if len(left) > MAX_ENUMERATED:
        return HalfBound(n_one_signed=n_one_signed, best=None, bound=bound)
    vertices = np.tile(at, (2 ** len(left), 1))
    vertices[:, left] = np.array(list(product((0.0, 1.0), repeat=len(left))))
    values = slopes(vertices, np.tile(weights, (len(vertices), 1)))[0]
    if not np.isfinite(values).all():
        raise _fails()
    k = int(np.argmax(values))
    best = float(values[k])
    rise = float(_rise(low[left], high[left], vertices[k, left]))
    return HalfBound(n_one_signed=n_one_signed, best=best, bound=min(bound, best + rise))


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
        u = _points(rng, min(rows, n_samples - first), d)
        each = []
        for unit in units:
            values, gradient, _ = slopes(u, np.tile(unit, (len(u), 1)))
            if not np.isfinite(values).all():
                raise _fails()
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
            raise _fails()
        total += values + _rise(least, most, at)
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
    bound = known
    for widening in widenings:
        if tell is not None:
            tell((1.0 + len(found)) / (1.0 + len(widenings)))
        first = _by_box(slopes, signs @ units, *_widened(low, high, widening))
        best, n_looks = known, 0
        for k in np.argsort(-first, kind="stable"):
            if first[k] <= bound:
                break
            if n_looks == MAX_LOOKS:
                bound = float(first[k])
                break
            n_looks += 1
            halves = [
                bound_half(
                    slopes,
                    d,
                    side * (signs[k] @ units),
                    n_samples=n_samples,
                    widening=widening,
                    seed=seed,
                    box=(low[k], high[k]) if side > 0.0 else (-high[k], -low[k]),
                )
                for side in (1.0, -1.0)
            ]
            bound = max(bound, min(float(first[k]), sum(h.bound for h in halves)))
            values = [h.best for h in halves if h.best is not None]
            best = max(best, sum(values)) if len(values) == 2 else best
        found.append(PairBound(widening=widening, best=best, bound=bound, n_looks=n_looks))
    return tuple(found)

"""How large the largest difference can be, if slopes stay within the range that samples show.

For a pattern of signs s, f is max s.y minus min s.y over the box. An input whose slope keeps its
sign over all samples is put on its better side; on the face that is left slopes are sampled anew,
until no more inputs are decided. The vertices of the others are enumerated, and the mean-value
theorem bounds what may lie between them. Every range in this is sampled: no proof.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ModelError

__all__ = ["HalfBound", "PairBound", "bound_half", "bound_pair"]

FloatArray = NDArray[np.float64]
Slopes = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray, FloatArray]]
MAX_ENUMERATED = 12
"""Inputs without a sign of their own up to which vertices are enumerated."""
FEW = 500
"""Samples of slopes for a first look at a pattern."""
NEAR = 0.95
"""Patterns whose bound by few samples is below this share of the known f are left at that."""
MAX_OUTPUTS = 12
"""Outputs that count up to which every pattern of signs is looked at."""


@dataclass(frozen=True, kw_only=True, eq=False)
class HalfBound:
    """The largest weighted sum of outputs over the box, as far as samples show."""

    n_one_signed: int
    """Inputs whose slope kept its sign over the box's samples."""
    best: float | None
    """Largest value over the vertices that are left; None if they are too many to enumerate."""
    bound: float
    """Sampled bound: from the best vertex, or from the middle if not enumerated."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PairBound:
    """The largest f of two models, as far as samples show."""

    best: float
    """Largest enumerated f, or the known one where that is larger."""
    bound: float
    """Sampled bound of f over all patterns."""
    n_patterns: int
    """Patterns that the box's samples alone could not rule out."""
    n_not_enumerated: int
    """Those among them with too many inputs left to enumerate."""


def _sampled(
    slopes: Slopes, u: FloatArray, weights: FloatArray, widening: float
) -> tuple[FloatArray, FloatArray]:
    values, gradient, _ = slopes(u, np.tile(weights, (len(u), 1)))
    if not np.isfinite(values).all():
        raise ModelError("models within the bounds fail; there is no sampled bound over them")
    low, high = gradient.min(axis=0), gradient.max(axis=0)
    pad = widening * (high - low)
    return low - pad, high + pad


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
) -> HalfBound:
    """Bound a weighted sum of outputs over the unit cube, by sampled slopes.

    `widening` is the share of the sampled range of slopes by which it is taken larger, each side.
    """
    rng = np.random.default_rng(seed)
    at = np.full(d, np.nan)
    n_one_signed: int | None = None
    while True:
        u = np.where(np.isnan(at), _points(rng, n_samples, d), at)
        low, high = _sampled(slopes, u, weights, widening)
        free = np.isnan(at)
        at[free & (low >= 0.0)] = 1.0
        at[free & (low < 0.0) & (high <= 0.0)] = 0.0
        left = np.flatnonzero(np.isnan(at))
        if n_one_signed is None:
            n_one_signed = d - len(left)
        if len(left) in (0, np.count_nonzero(free)):
            break
    if len(left) > MAX_ENUMERATED:
        middle = np.where(np.isnan(at), 0.5, at)[None]
        value = float(slopes(middle, weights[None])[0][0])
        reach = 0.5 * float(np.maximum(-low[left], high[left]).sum())
        return HalfBound(n_one_signed=n_one_signed, best=None, bound=value + reach)
    vertices = np.tile(at, (2 ** len(left), 1))
    vertices[:, left] = np.array(list(product((0.0, 1.0), repeat=len(left))))
    values = slopes(vertices, np.tile(weights, (len(vertices), 1)))[0]
    if not np.isfinite(values).all():
        raise ModelError("models within the bounds fail; there is no sampled bound over them")
    k = int(np.argmax(values))
    c = vertices[k, left]
    between = np.maximum(0.0, np.maximum(high[left] * (1.0 - c), -low[left] * c))
    best = float(values[k])
    return HalfBound(n_one_signed=n_one_signed, best=best, bound=best + float(between.sum()))


def _open_patterns(
    slopes: Slopes, d: int, weights: FloatArray, known: float, u: FloatArray, widening: float
) -> list[FloatArray]:
    """Return the weighted patterns whose f may be above the known one, by the box's samples."""
    counting = np.flatnonzero(weights)
    if len(counting) > MAX_OUTPUTS:
        raise ModelError(f"{len(counting)} outputs count; a sampled bound takes {MAX_OUTPUTS}")
    unit = np.diag(weights)[counting]
    each = np.stack([slopes(u, np.tile(w, (len(u), 1)))[1] for w in unit])
    if not np.isfinite(each).all():
        raise ModelError("models within the bounds fail; there is no sampled bound over them")
    patterns = []
    for rest in product((1.0, -1.0), repeat=len(counting) - 1):
        signs = np.array((1.0, *rest))
        gradient = np.tensordot(signs, each, axes=1)
        low, high = gradient.min(axis=0), gradient.max(axis=0)
        pad = widening * (high - low)
        if np.maximum(high + pad, pad - low).sum() >= known:
            patterns.append(signs @ unit)
    return patterns


def bound_pair(
    slopes: Slopes,
    d: int,
    weights: FloatArray,
    *,
    known: float = 0.0,
    n_samples: int = 9000,
    widening: float = 0.0,
    seed: int = 0,
) -> PairBound:
    """Bound f, the weighted sum of the outputs' differences, over all patterns of signs.

    `known` is an f that a search has found: patterns that cannot reach it are left out.
    """
    u = _points(np.random.default_rng(seed), FEW, d)
    patterns = _open_patterns(slopes, d, weights, known, u, widening)
    best, bound, lost = known, known, 0
    for w in patterns:
        for n in (FEW, n_samples):  # few samples rule most patterns out
            halves = [
                bound_half(slopes, d, side * w, n_samples=n, widening=widening, seed=seed)
                for side in (1.0, -1.0)
            ]
            most = sum(h.bound for h in halves)
            if most < NEAR * known:
                break
        bound = max(bound, most)
        values = [h.best for h in halves if h.best is not None]
        if len(values) == 2:
            best = max(best, sum(values))
        else:
            lost += 1
    return PairBound(best=best, bound=bound, n_patterns=len(patterns), n_not_enumerated=lost)

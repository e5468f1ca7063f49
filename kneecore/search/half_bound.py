"""The largest value of one weighted sum of outputs over a box, as far as sampled slopes show."""

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ModelError
from kneecore.numerics.box_climb import Slopes

__all__ = [
    "MAX_ENUMERATED",
    "Half",
    "HalfBound",
    "Range",
    "bound_half",
    "failing",
    "points",
    "rise",
    "widened",
]

FloatArray = NDArray[np.float64]
Range = tuple[FloatArray, FloatArray]

MAX_ENUMERATED = 12
"""Inputs without a sign of their own up to which vertices are enumerated."""


@dataclass(frozen=True, kw_only=True, eq=False)
class HalfBound:
    """The largest weighted sum of outputs over the box, as far as samples show."""

    n_one_signed: int
    """Inputs whose slope kept its sign over the box's samples."""
    best: float | None
    """Largest value over the vertices that are left; None if they are too many to enumerate."""
    bound: float
    """Sampled bound: from the best vertex or from the middle, whichever is lower."""
    open_input: int | None
    """The undecided input that leaves most open; None where all are decided."""
    left_open: float
    """By how much it may raise the sum, from the middle."""


def failing() -> ModelError:
    """Return the error where models fail: nothing can be said then."""
    return ModelError("models within the bounds fail; there is no sampled bound over them")


def _sampled(slopes: Slopes, u: FloatArray, weights: FloatArray) -> Range:
    values, gradient, _ = slopes(u, np.tile(weights, (len(u), 1)))
    if not np.isfinite(values).all():
        raise failing()
    return gradient.min(axis=0), gradient.max(axis=0)


def widened(low: FloatArray, high: FloatArray, widening: float) -> Range:
    """Return a range that is larger by a share of itself, each side."""
    pad = widening * (high - low)
    return low - pad, high + pad


def rise(low: FloatArray, high: FloatArray, at: FloatArray) -> FloatArray:
    """Return by how much a value may rise at most on the way from vertices `at`, by the slopes."""
    most = np.maximum(high * (1.0 - at), -low * at)
    return np.asarray(np.maximum(0.0, most).sum(axis=-1))


def points(rng: np.random.Generator, n: int, d: int) -> FloatArray:
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
            u = np.where(np.isnan(at), points(rng, n_samples, d), at)
            box = _sampled(slopes, u, weights)
        low, high = widened(*box, widening)
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
        raise failing()
    raises = 0.5 * np.maximum(-low[left], high[left])
    best, bound = None, float(value[0]) + float(raises.sum())
    if len(left) <= MAX_ENUMERATED:
        best, more = _best_vertex(slopes, at, (low[left], high[left]), weights)
        bound = min(bound, best + more)
    most = int(raises.argmax()) if len(left) else None
    return HalfBound(
        n_one_signed=n_one_signed,
        best=best,
        bound=bound,
        open_input=None if most is None else int(left[most]),
        left_open=0.0 if most is None else float(raises[most]),
    )


def _best_vertex(
    slopes: Slopes, at: FloatArray, box: Range, weights: FloatArray
) -> tuple[float, float]:
    """Return the largest value over the vertices of what `at` (d,) leaves open, and its rise."""
    left = np.flatnonzero(np.isnan(at))
    vertices = np.tile(at, (2 ** len(left), 1))
    vertices[:, left] = np.array(list(product((0.0, 1.0), repeat=len(left))))
    values = slopes(vertices, np.tile(weights, (len(vertices), 1)))[0]
    if not np.isfinite(values).all():
        raise failing()
    k = int(np.argmax(values))
    return float(values[k]), float(rise(*box, vertices[k, left]))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Part:
    """A part of the box, and what is known of a weighted sum over it."""

    low: FloatArray
    high: FloatArray
    found: HalfBound


class Half:
    """The largest weighted sum over the box, which may be halved again and again."""

    def __init__(
        self, slopes: Slopes, weights: FloatArray, n_samples: int, widening: float, seed: int
    ) -> None:
        self._slopes, self._weights = slopes, weights
        self._n_samples, self._widening, self._seed = n_samples, widening, seed
        self._parts: list[_Part] = []

    def add(self, low: FloatArray, high: FloatArray, box: Range | None = None) -> None:
        """Look at a part of the box, from `low` (d,) to `high` (d,)."""

        def within(u: FloatArray, weights: FloatArray) -> Any:
            values, gradient, y = self._slopes(low + (high - low) * u, weights)
            return values, gradient * (high - low), y

        found = bound_half(
            within,
            len(low),
            self._weights,
            n_samples=self._n_samples,
            widening=self._widening,
            seed=self._seed,
            box=box,
        )
        self._parts.append(_Part(low=low, high=high, found=found))

    @property
    def _worst(self) -> _Part:
        return max(self._parts, key=lambda part: part.found.bound)

    @property
    def bound(self) -> float:
        """The sampled bound over all parts."""
        return self._worst.found.bound

    @property
    def left_open(self) -> float:
        """By how much the input that would be halved next may raise the sum."""
        return self._worst.found.left_open

    @property
    def best(self) -> float | None:
        """The largest value that was enumerated."""
        return max((p.found.best for p in self._parts if p.found.best is not None), default=None)

    def split(self) -> None:
        """Halve the part with the largest bound."""
        part = self._worst
        k = part.found.open_input
        assert k is not None
        self._parts.remove(part)
        for side in (0.0, 1.0):
            low, high = part.low.copy(), part.high.copy()
            middle = 0.5 * (low[k] + high[k])
            low[k], high[k] = (low[k], middle) if side == 0.0 else (middle, high[k])
            self.add(low, high)

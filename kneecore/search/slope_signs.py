"""Which inputs keep the sign of their slope over the whole box, and the vertices of the others.

Slopes are sampled, and those that never changed their sign are attacked: from the samples nearest
to a change, the slope itself is driven towards it, input by input, all that helps together or the
best alone. Where few inputs are left, the largest value lies on one of their vertices if it lies on
any; all of them are computed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from kneecore.numerics.box_climb import Slopes

__all__ = ["SlopeSigns", "slope_signs", "vertices"]

FloatArray = NDArray[np.float64]
Tell = Callable[[float], object]

_N_SAMPLES = 50_000
_N_NEAREST = 3  # samples of each input that are attacked from
_PROBES = (1.0, 0.25, 0.05)  # of the cube's width; the first throws an input to its other bound
_MAX_ROUNDS = 8
_NOISE = 1e-9  # of an input's largest slope
_BATCH = 5_000  # models computed together
_ROOM = 2**22  # numbers of the probes of an attack


@dataclass(frozen=True, kw_only=True, eq=False)
class SlopeSigns:
    """What samples and the search for a change of sign have shown."""

    sides: NDArray[np.int8]
    """Sign that each input's slope kept, shape (d,); 0 for those that have both."""
    n_sampled: int
    """Inputs whose slope kept its sign over the samples."""
    n_models: int
    """Models that were looked at."""
    n_failed: int
    """Those among them that failed."""

    @property
    def n_one_signed(self) -> int:
        """Inputs whose slope kept its sign."""
        return int(np.count_nonzero(self.sides))


class _Counted:
    """The slopes of one weighted sum, in batches, counted; NaN where a model failed."""

    def __init__(self, slopes: Slopes, weights: FloatArray) -> None:
        self._slopes, self._weights = slopes, weights
        self.n_models = self.n_failed = 0

    def __call__(self, u: FloatArray) -> FloatArray:
        parts = []
        for first in range(0, len(u), _BATCH):
            some = u[first : first + _BATCH]
            values, gradient, _ = self._slopes(some, np.tile(self._weights, (len(some), 1)))
            good = np.isfinite(values)
            self.n_failed += int(np.count_nonzero(~good))
            parts.append(np.where(good[:, None], gradient, np.nan))
        self.n_models += len(u)
        return np.concatenate(parts)


@dataclass(eq=False)
class _Seen:
    """Range of each input's slope, and the samples where it is nearest to a change of sign."""

    low: FloatArray
    high: FloatArray
    points: tuple[FloatArray, FloatArray]
    """Of the lowest slopes and of the highest, shape (_N_NEAREST, d, d)."""

    def sides(self) -> NDArray[np.int8]:
        kept = np.where(self.low >= -self.noise, 1, np.where(self.high <= self.noise, -1, 0))
        return np.where(np.isfinite(self.low), kept, 0).astype(np.int8)

    @property
    def noise(self) -> FloatArray:
        """Slopes of what size say nothing of a sign."""
        return _NOISE * np.maximum(np.abs(self.low), np.abs(self.high))


def _seen(slopes: _Counted, d: int, rng: np.random.Generator, tell: Tell | None) -> _Seen:
    lowest = np.full((_N_NEAREST, d), np.inf)
    highest = -lowest
    at = [np.zeros((_N_NEAREST, d, d)) for _ in range(2)]
    for first in range(0, _N_SAMPLES, _BATCH):
        if tell is not None:
            tell(0.8 * first / _N_SAMPLES)
        u = rng.random((_BATCH, d))
        u[::2] = np.round(u[::2])  # slopes are often extreme at vertices
        g = slopes(u)
        for k, (kept, sign) in enumerate(((lowest, 1.0), (highest, -1.0))):
            both = np.concatenate([sign * kept, np.where(np.isnan(g), np.inf, sign * g)])
            rows = np.argsort(both, axis=0, kind="stable")[:_N_NEAREST]
            kept[:] = sign * np.take_along_axis(both, rows, axis=0)
            old = at[k][np.minimum(rows, _N_NEAREST - 1), np.arange(d)]
            at[k] = np.where((rows < _N_NEAREST)[..., None], old, u[rows - _N_NEAREST])
    return _Seen(lowest[0], highest[0], (at[0], at[1]))


def _attacked(
    slopes: _Counted, inputs: NDArray[np.intp], sides: FloatArray, u: FloatArray, noise: FloatArray
) -> NDArray[np.bool_]:
    """Return for which of the points u (n, d) the slope by their input has changed its sign."""
    n, d = u.shape
    rows = np.arange(n)

    def worth(points: FloatArray) -> FloatArray:
        """Return each point's slope, times the sign that it had; infinite for a failure."""
        g = slopes(points.reshape(-1, d)).reshape(n, -1, d)
        signed = sides[:, None] * np.take_along_axis(g, inputs[:, None, None], axis=2)[..., 0]
        return np.where(np.isnan(signed), np.inf, signed)

    now = worth(u)[:, 0]
    for size in _PROBES:
        for _ in range(_MAX_ROUNDS):
            if (now < -noise).all():
                break
            shifts = size * np.concatenate([np.eye(d), -np.eye(d)])
            probes = np.clip(u[:, None] + shifts, 0.0, 1.0)
            reached = worth(probes)
            helps = reached < now[:, None]
            together = np.clip(u + ((probes - u[:, None]) * helps[..., None]).sum(axis=1), 0.0, 1.0)
            best = reached.argmin(axis=1)
            jointly = worth(together[:, None])[:, 0]
            alone = reached[rows, best]
            joint = jointly < alone
            better = np.minimum(alone, jointly) < now
            if not better.any():
                break
            step = np.where(joint[:, None], together, probes[rows, best])
            u = np.where(better[:, None], step, u)
            now = np.where(better, np.minimum(alone, jointly), now)
    return now < -noise


def slope_signs(
    slopes: Slopes, d: int, weights: FloatArray, *, seed: int = 0, tell: Tell | None = None
) -> SlopeSigns:
    """Return which inputs keep the sign of their slope over the unit cube.

    Parameters
    ----------
    slopes : callable
        See `kneecore.numerics.box_climb.Slopes`.
    d : int
        Dimensions of the unit cube.
    weights : ndarray, shape (m,)
        Weights of the sum of outputs whose slopes are looked at.
    seed : int
    tell : callable, optional
        Gets the share that is done.
    """
    counted = _Counted(slopes, weights)
    seen = _seen(counted, d, np.random.default_rng([seed, 3]), tell)
    sides = seen.sides()
    inputs = np.flatnonzero(sides)
    if len(inputs):
        if tell is not None:
            tell(0.8)
        near = [seen.points[0 if sides[i] > 0 else 1][:, i] for i in inputs]
        each, points = np.repeat(inputs, _N_NEAREST), np.concatenate(near)
        signs = sides[each].astype(np.float64)
        some = max(1, _ROOM // (2 * d * d))
        for k in range(0, len(each), some):
            part = slice(k, k + some)
            noise = seen.noise[each[part]]
            changed = _attacked(counted, each[part], signs[part], points[part], noise)
            sides[each[part][changed]] = 0
    return SlopeSigns(
        sides=sides,
        n_sampled=len(inputs),
        n_models=counted.n_models,
        n_failed=counted.n_failed,
    )


def vertices(sides: NDArray[np.int8]) -> FloatArray:
    """Return where the sum may be largest, and where smallest, shape (2, 2^left, d).

    Inputs whose slope keeps its sign are on their better side, the others on all their bounds.
    """
    left = np.flatnonzero(sides == 0)
    best = np.stack([sides > 0, sides < 0]).astype(np.float64)
    all_of_them = np.repeat(best[:, None], 2 ** len(left), axis=1)
    all_of_them[..., left] = np.array(list(product((0.0, 1.0), repeat=len(left))))
    return all_of_them

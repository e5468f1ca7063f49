"""Runs that look for the worst pair where it lies inside the bounds as well as in their corners.

For one pattern s of signs the pair falls apart into two halves that know nothing of each other: the
point with the largest s.y and that with the smallest. So each batch of runs asks, for both halves,
where the surrogate has its largest value (climbs from the best samples and from random points), and
spends the rest on trials near the best sample: some inputs moved, a little or to a bound, chosen by
what the surrogate predicts there and by how far the point is from any sample, weighed in turn
(Regis & Shoemaker 2013, Eng. Optim. 45:529). The trials' width doubles where they succeed and
halves where they do not.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore.box import Box
from kneecore.numerics.box_climb import climb
from kneecore.numerics.surrogate import Surrogate
from kneecore.search.discrete import polished
from kneecore.search.exact_search import slopes_of

__all__ = ["Half", "best_places", "climbed", "is_new", "trial"]

FloatArray = NDArray[np.float64]

SAME = 1e-3  # of the cube's width: points closer than that are one
_N_RANDOM = 12  # random starts of a climb in the surrogate
_N_BEST = 6  # samples that it starts from too
_N_TRIALS = 400  # candidates of a trial
_WEIGHTS = (0.95, 0.5, 0.8, 0.3)  # of the prediction; the rest is the distance's
_AT_BOUND = 0.3  # share of moved inputs that go to a bound
_WIDEST, _NARROWEST = 0.4, 0.01  # standard deviations of a trial's moves
_PATIENCE = 4  # trials without success before their width is halved


@dataclass(eq=False)
class Half:
    """Where one of the two models is looked for."""

    sums: FloatArray
    """Weighted signs: the sum of the outputs that is to be large."""
    error: float = 0.0
    """How far its latest runs were from what was predicted, a running mean."""
    width: float = 0.2
    """Standard deviation of a trial's moves, of the cube's width."""
    n_failures: int = 0
    n_trials: int = 0

    def learn(self, succeeded: bool) -> None:
        """Widen the trials after a success, narrow them after several failures."""
        self.n_failures = 0 if succeeded else self.n_failures + 1
        if succeeded:
            self.width = min(2.0 * self.width, _WIDEST)
        elif self.n_failures >= _PATIENCE:
            self.n_failures = 0
            self.width *= 0.5
            if self.width < _NARROWEST:  # begin again, wide
                self.width = _WIDEST


def best_places(y: FloatArray, weights: FloatArray) -> tuple[int, int, float]:
    """Return the farthest pair of outputs (n, m), and its f; rows that are not finite are out."""
    best = (0, 0, -np.inf)
    for k in range(len(y)):
        f = (np.abs(y[: k + 1] - y[k]) * weights).sum(axis=1)
        f = np.where(np.isfinite(f), f, -np.inf)
        j = int(np.argmax(f))
        if f[j] > best[2]:
            best = (j, k, float(f[j]))
    return best


def is_new(u: FloatArray, known: FloatArray) -> bool:
    """Tell whether a point (d,) is none of the known ones (n, d)."""
    return bool(np.abs(known - u).max(axis=1).min() >= SAME)


def climbed(
    surrogate: Surrogate, half: Half, known: FloatArray, rng: np.random.Generator, box: Box
) -> tuple[FloatArray, FloatArray]:
    """Return the ends of climbs in the surrogate and their values, the best first."""
    values = surrogate(known) @ half.sums
    best = known[np.argsort(-values, kind="stable")[:_N_BEST]]
    starts = np.vstack([best, rng.random((_N_RANDOM, known.shape[1]))])
    ends = climb(slopes_of(surrogate), starts, np.repeat(half.sums[None], len(starts), axis=0))
    u, reached = ends.u, ends.values
    if box.grids:
        u = np.array([polished(surrogate, half.sums, one, box.grids) for one in box.snapped(u)])
        reached = surrogate(u) @ half.sums
    order = np.argsort(-reached, kind="stable")
    return u[order], reached[order]


def trial(
    surrogate: Surrogate,
    half: Half,
    base: FloatArray,
    known: FloatArray,
    rng: np.random.Generator,
    box: Box,
) -> FloatArray | None:
    """Return the candidate near `base` (d,) that is worth the most; None if all are known."""
    d = len(base)
    share = min(1.0, 3.0 / d)
    moved = rng.random((_N_TRIALS, d)) < share
    moved[np.arange(_N_TRIALS), rng.integers(0, d, _N_TRIALS)] = True
    steps = base + half.width * rng.standard_normal((_N_TRIALS, d))
    thrown = np.round(rng.random((_N_TRIALS, d)))
    to_bound = rng.random((_N_TRIALS, d)) < _AT_BOUND
    u = np.where(moved, np.where(to_bound, thrown, np.clip(steps, 0.0, 1.0)), base)
    u = box.snapped(u)
    value = surrogate(u) @ half.sums
    apart = np.sqrt(((u[:, None] - known) ** 2).sum(axis=2)).min(axis=1)
    weight = _WEIGHTS[half.n_trials % len(_WEIGHTS)]
    half.n_trials += 1
    score = weight * _scaled(value) + (1.0 - weight) * _scaled(apart)
    near = _is_near(u, known)
    if near.all():  # no allowed values are left so near: others
        u = box.snapped(rng.random((_N_TRIALS, d)))
        near = _is_near(u, known)
        return None if near.all() else u[int(np.argmin(near))]
    chosen: FloatArray = u[int(np.argmax(np.where(near, -np.inf, score)))]
    return chosen


def _is_near(u: FloatArray, known: FloatArray) -> NDArray[np.bool_]:
    near: NDArray[np.bool_] = np.abs(u[:, None] - known).max(axis=2).min(axis=1) < SAME
    return near


def _scaled(v: FloatArray) -> FloatArray:
    width = np.ptp(v)
    scaled: FloatArray = (v - v.min()) / width if width > 0.0 else np.zeros_like(v)
    return scaled

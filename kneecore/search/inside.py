"""Where to run a model next, if its worst pair may lie inside the bounds as well as in a corner.

For one pattern s of signs the pair falls apart into two halves that know nothing of each other: the
point with the largest s.y and that with the smallest. So one number is fitted, s.y, by a Gaussian
process, and each half asks where its mean, or its mean and some standard deviations more, is the
largest (the upper confidence bound; N. Srinivas et al. 2012, IEEE Trans. Inf. Theory 58:3250), and
tries the best run with one input, two or all at their other bounds, for a process knows little of
far corners. The signs are those of the best pair so far; of several outputs all are fitted too, by
a spline, so that a pair with other signs is found.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from kneecore.box import Box
from kneecore.numerics.box_climb import climb
from kneecore.numerics.kriging import Kriging
from kneecore.search.discrete import polished

__all__ = ["Half", "best_places", "highest", "is_new", "thrown"]

FloatArray = NDArray[np.float64]

SAME = 1e-3  # of the cube's width: points closer than that are one
_N_LOOKS = 400  # points that are looked at before the climbs
_NEAR = 0.25  # share of them near the best
_WIDTH = 0.1  # of the cube: how near
_N_CLIMBS = 10
_N_PAIRED = 30  # inputs of which two go to their other bounds together
_DEVIATIONS = (2.0, 1.0, 3.0, 0.5)  # above the mean, in turn


@dataclass(eq=False)
class Half:
    """Where one of the two models is looked for."""

    sums: FloatArray
    """Weighted signs: the sum of the outputs that is to be large."""
    sign: float
    """Of that sum in what is fitted."""
    n_inputs: int
    error: float = 0.0
    """How far its latest runs were from what was predicted, a running mean."""
    n_trials: int = 0
    thrown: set[tuple[int, ...]] = field(default_factory=set)
    """Inputs that were tried at their other bounds together, none twice; as many as inputs."""

    def deviations(self) -> float | None:
        """Return how many deviations above the mean to look for next; None: throw inputs."""
        turn, throws = divmod(self.n_trials, 2)
        self.n_trials += 1
        if throws and len(self.thrown) < self.n_inputs:
            return None
        return _DEVIATIONS[turn % len(_DEVIATIONS)]


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


def highest(
    process: Kriging,
    half: Half,
    deviations: float,
    best: FloatArray,
    rng: np.random.Generator,
    box: Box,
) -> tuple[FloatArray, FloatArray]:
    """Return points (n, d) where so many deviations above the mean are most, and how much there.

    Climbs begin at the best run (d,), and at the best of random points, some of them near it. The
    best end is the first.
    """

    def slopes(u: FloatArray, _: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        mean, sd, slope, sd_slope = process(u)
        value = half.sign * mean + deviations * sd
        return value, half.sign * slope + deviations * sd_slope, value[:, None]

    def level(u: FloatArray) -> FloatArray:
        return slopes(u, u)[2]

    singles = [(k,) for k in range(len(best))]
    looks = np.vstack([best, _flipped(best, singles), _looks(best, rng)])
    values = slopes(looks, looks)[0]
    starts = looks[np.append(0, np.argsort(-values, kind="stable")[:_N_CLIMBS])]
    ends = climb(slopes, starts, np.ones((len(starts), 1)))
    u, reached = ends.u, ends.values
    if box.grids:
        one = np.ones(1)
        u = np.array([polished(level, one, end, box.grids) for end in box.snapped(u)])
        reached = level(u)[:, 0]
    order = np.argsort(-reached, kind="stable")
    return u[order], reached[order]


def thrown(process: Kriging, half: Half, best: FloatArray, box: Box) -> FloatArray:
    """Return the best run (d,) with the most hopeful inputs at their other bounds, none twice.

    They are one input, two, or all: an input may gain only together with another.
    """
    groups = _groups(process.lengths)
    u = box.snapped(_flipped(best, groups))
    mean, sd = process(u)[:2]
    hope = half.sign * mean + max(_DEVIATIONS) * sd
    hope[[group in half.thrown for group in groups]] = -np.inf
    place = int(np.argmax(hope))
    half.thrown.add(groups[place])
    chosen: FloatArray = u[place]
    return chosen


def _groups(lengths: FloatArray) -> list[tuple[int, ...]]:
    """Return each input, each two of those that count most, and all inputs."""
    d = len(lengths)
    most = np.sort(np.argsort(lengths, kind="stable")[:_N_PAIRED]).tolist()
    return [*((k,) for k in range(d)), *combinations(most, 2), tuple(range(d))]


def _flipped(best: FloatArray, groups: Sequence[tuple[int, ...]]) -> FloatArray:
    """Return the run (d,) with the inputs of each group at their other bounds."""
    u = np.repeat(best[None], len(groups), axis=0)
    for row, group in zip(u, groups, strict=True):
        row[list(group)] = 1.0 - np.round(best[list(group)])
    return u


def _looks(best: FloatArray, rng: np.random.Generator) -> FloatArray:
    d, n_near = len(best), round(_NEAR * _N_LOOKS)
    moved = rng.random((n_near, d)) < max(0.3, 2.0 / d)
    near = best + _WIDTH * rng.standard_normal((n_near, d)) * moved
    return np.vstack([rng.random((_N_LOOKS - n_near, d)), np.clip(near, 0.0, 1.0)])

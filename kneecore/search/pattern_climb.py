"""From the worst case of a proxy to that of the model itself, which has no gradients.

Where a lax knee has not come to rest, its angles in motion are not those of equilibrium, and the
worst case may be another. The proxy's worst pairs, one for each pattern of signs, are computed in
the model; the best of them then climbs by itself: each input of both models is thrown to its other
bound, then moved a little, all improvements are tried together, alone and in part, and the best
trial is kept until no input improves; then several inputs are thrown at once. Whole batches of
models are computed together. Where the proxy has often failed, its search leaves models out that
live here, and the best of a random sample are climbed from too.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore.search.sign_climb import SAME, ExactPair

__all__ = ["BatchedModel", "ClimbedPair", "climb_from_patterns", "pair_signs", "pair_value"]

FloatArray = NDArray[np.float64]
BatchedModel = Callable[[FloatArray], FloatArray]

_PROBES = (1.0, 0.25, 0.02)  # of the cube's width; the first throws an input to its other bound
_REACHES = (1.0, 0.5)  # of the cube's width: trial steps beside the probe's own
_MAX_ROUNDS = 12
_N_KICKS = 48  # models of a round that leave each of the pair's corners
_N_SAMPLES = 512  # random models, where the proxy has failed often
_N_EXTRA = 3  # pairs of them that are climbed from


@dataclass(frozen=True, kw_only=True, eq=False)
class ClimbedPair:
    """The most different pair of the model."""

    u: FloatArray
    """The two models, shape (2, d), unit cube."""
    y: FloatArray
    """Their outputs, shape (2, m)."""
    value: float
    """f; minus infinity if no pair could be computed."""
    first_value: float
    """f before the climb: the best of the pairs that the proxy has proposed."""
    others: tuple[float, ...]
    """f of the other pairs that it has proposed, and that are not in the same basin."""
    n_models: int


def _sums(y: FloatArray, weights: FloatArray) -> FloatArray:
    values = (y * weights).sum(axis=-1)
    return np.where(np.isfinite(values), values, -np.inf)


def _proposals(found: ExactPair) -> tuple[FloatArray, list[tuple[int, int]]]:
    """Return all corners of all patterns' halves, and the pairs to make of them."""
    corners: list[FloatArray] = []
    pairs: list[tuple[int, int]] = []
    for halves in found.halves:
        places = []
        for half in halves:
            own = [half.u, *[c for c in half.corners if not np.array_equal(c, half.u)]]
            places.append(range(len(corners), len(corners) + len(own)))
            corners += own
        pairs += [(i, j) for i in places[0] for j in places[1]]
    return np.stack(corners), pairs


def _probes(u: FloatArray, size: float) -> FloatArray:
    """Return the points that differ from `u` (d,) in one input, by `size` up or down."""
    shifts = np.concatenate([np.eye(len(u)), -np.eye(len(u))]) * size
    moved = np.clip(u + shifts, 0.0, 1.0)
    probes: FloatArray = moved[np.abs(moved - u).max(axis=1) > 0.1 * size]
    return probes


def _trials(u: FloatArray, probes: FloatArray, gains: FloatArray) -> FloatArray:
    """Return where to go from `u`, given what each probe gains: all together, halves, the best."""
    better = gains > 0.0
    together = (probes[better] - u).sum(axis=0)
    alone = probes[int(np.argmax(gains))] - u
    steps = [together, alone]
    steps += [reach * np.sign(step) for reach in _REACHES for step in (together, alone)]
    trials: FloatArray = np.clip(u + np.stack(steps), 0.0, 1.0)
    return trials


class _Climb:
    def __init__(self, model: BatchedModel) -> None:
        self.model, self.n_models = model, 0

    def __call__(self, u: FloatArray) -> FloatArray:
        self.n_models += len(u)
        return self.model(u)

    def improve(
        self, u: FloatArray, y: FloatArray, weights: FloatArray, size: float
    ) -> tuple[FloatArray, FloatArray, bool]:
        """Take one step with both models; return the pair and whether any has improved."""
        values = _sums(y, weights)
        probes = [_probes(u[k], size) for k in (0, 1)]
        split = len(probes[0])
        probed = self(np.concatenate(probes))
        parts = (probed[:split], probed[split:])
        noise = SAME * 1e-2 * float(np.abs(values).sum())
        gains = [_sums(parts[k], weights[k]) - values[k] - noise for k in (0, 1)]
        going = [k for k in (0, 1) if gains[k].max() > 0.0]
        if not going:
            return u, y, False
        trials = [_trials(u[k], probes[k], gains[k]) for k in going]
        reached = self(np.concatenate(trials)).reshape(len(going), -1, y.shape[1])
        u, y = u.copy(), y.copy()
        for k, tried, ends in zip(going, trials, reached, strict=True):
            best = int(np.argmax(_sums(ends, weights[k])))
            u[k], y[k] = tried[best], ends[best]
        return u, y, True

    def ascend(self, u: FloatArray, y: FloatArray, weights: FloatArray) -> tuple[FloatArray, ...]:
        """Climb from a pair; return the pair and its outputs."""
        for size in _PROBES:
            for _ in range(_MAX_ROUNDS):
                u, y, improved = self.improve(u, y, pair_signs(y, weights), size)
                if not improved:
                    break
        return u, y

    def kick(
        self, u: FloatArray, y: FloatArray, weights: FloatArray, rng: np.random.Generator
    ) -> tuple[FloatArray, FloatArray, bool]:
        """Throw two to six inputs of each model, on average, to their other bounds."""
        both = pair_signs(y, weights)
        shares = rng.integers(2, 7, (2, _N_KICKS, 1)) / u.shape[1]
        thrown = rng.random((2, _N_KICKS, u.shape[1])) < shares
        tried = np.where(thrown, 1.0 - np.round(u)[:, None], u[:, None])
        ends = self(tried.reshape(-1, u.shape[1])).reshape(2, _N_KICKS, -1)
        u, y, found = u.copy(), y.copy(), False
        for k in (0, 1):
            values = _sums(ends[k], both[k])
            best, now = int(np.argmax(values)), float(_sums(y[k], both[k]))
            if values[best] > now + SAME * abs(now):
                u[k], y[k], found = tried[k, best], ends[k, best], True
        return u, y, found


def pair_signs(y: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the weighted signs of a pair's differences for the first model and for the second."""
    signed = np.where(y[0] >= y[1], 1.0, -1.0) * weights
    return np.stack([signed, -signed])


def pair_value(y: FloatArray, weights: FloatArray) -> float:
    """Return f of a pair's outputs, shape (2, m); minus infinity if one has failed."""
    return float(_sums(np.abs(y[0] - y[1]), weights))


def _sampled_pairs(
    climb: _Climb, found: ExactPair, weights: FloatArray, rng: np.random.Generator
) -> list[tuple[FloatArray, FloatArray]]:
    """Return the most different pairs of a random sample, for different patterns of signs."""
    u = rng.random((_N_SAMPLES, found.u.shape[1]))
    y = climb(u)
    pairs = []
    for signs, _ in found.evidence.patterns:
        w = np.array(signs) * weights
        values = np.where(np.isfinite(y).all(axis=1), (np.nan_to_num(y) * w).sum(axis=1), np.nan)
        if np.isfinite(values).any():
            pairs.append([int(np.nanargmax(values)), int(np.nanargmin(values))])
    pairs.sort(key=lambda p: -pair_value(y[p], weights))
    return [(u[p], y[p]) for p in pairs[:_N_EXTRA]]


def climb_from_patterns(
    model: BatchedModel,
    found: ExactPair,
    weights: FloatArray,
    *,
    seed: int = 0,
    many_failed: bool = False,
) -> ClimbedPair:
    """Climb from the worst pairs of a proxy to a worst pair of the model.

    Parameters
    ----------
    model : callable
        Maps (n, d) in the unit cube to outputs (n, m); a row of NaN is a failure.
    found : ExactPair
        The worst pairs of the proxy.
    weights : ndarray, shape (m,)
        Weight of each output's difference.
    seed : int
        The same seed gives the same pair.
    many_failed : bool
        Whether the search in the proxy has left many models out.
    """
    climb, rng = _Climb(model), np.random.default_rng([seed, 1])
    corners, pairs = _proposals(found)
    y = climb(corners)
    first, second = (np.array([p[k] for p in pairs]) for k in (0, 1))
    values = _sums(np.abs(y[first] - y[second]), weights)
    best = int(np.argmax(values))
    begun = [(corners[list(pairs[best])], y[list(pairs[best])])]
    if many_failed:
        begun += _sampled_pairs(climb, found, weights, rng)
    ended = [climb.ascend(u, p, weights) for u, p in begun if np.isfinite(p).all()]
    if not ended:
        nothing = np.full((2, len(weights)), np.nan)
        return ClimbedPair(
            u=found.u,
            y=nothing,
            value=-np.inf,
            first_value=-np.inf,
            others=(),
            n_models=climb.n_models,
        )
    u, y_pair = max(ended, key=lambda pair: pair_value(pair[1], weights))
    for _ in range(_MAX_ROUNDS):
        u, y_pair, improved = climb.kick(u, y_pair, weights, rng)
        if not improved:
            break
        u, y_pair = climb.ascend(u, y_pair, weights)
    value = pair_value(y_pair, weights)
    others = np.concatenate([values, [pair_value(p, weights) for _, p in ended]])
    apart = others[np.isfinite(others) & (others < value - SAME * value)]
    return ClimbedPair(
        u=u,
        y=y_pair,
        value=value,
        first_value=float(values[best]),
        others=tuple(float(v) for v in np.sort(apart)[::-1]),
        n_models=climb.n_models,
    )

"""What slopes over the whole bounds say about how good an exact search's result is."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ModelError
from kneecore.model import Model, Slopes
from kneecore.search.half_bound import MAX_ENUMERATED
from kneecore.search.pattern_climb import pair_value
from kneecore.search.result import BoundEvidence, Evidence, SampledBound
from kneecore.search.sampled_bound import bound_pair
from kneecore.search.slope_signs import slope_signs, vertices

__all__ = ["WIDENINGS_PERCENT", "bound_evidence"]

FloatArray = NDArray[np.float64]
Tell = Callable[[float], object]

WIDENINGS_PERCENT = (0.0, 5.0, 10.0, 25.0)
"""Shares of the sampled range of slopes by which it is taken larger."""
_SIGNS = 0.3  # of the work: the signs of slopes, before the bounds


class _Told:
    """A model's slopes, which tell how far the work is before each batch."""

    def __init__(self, model: Model, tell: Tell | None) -> None:
        self._model, self._tell = model, tell
        self._done = 0.0
        self.n_inputs = model.n_free

    def __call__(self, u: FloatArray, weights: FloatArray) -> Slopes:
        self.reach(self._done)
        return self._model.slopes(u, weights)

    def reach(self, done: float) -> None:
        self._done = done
        if self._tell is not None:
            self._tell(done)


def _largest(y: FloatArray, signed: FloatArray, weights: FloatArray) -> float | None:
    """Return f of the ends of outputs (2, n, m): the largest signed sum, and the smallest."""
    sums = y @ signed
    if not np.isfinite(sums).all():
        return None
    ends = np.stack([y[0, int(sums[0].argmax())], y[1, int(sums[1].argmin())]])
    return pair_value(ends, weights)


def bound_evidence(
    model: Model,
    weights: FloatArray,
    evidence: Evidence,
    *,
    seed: int = 0,
    tell: Tell | None = None,
) -> BoundEvidence:
    """Return what slopes say about the f that an exact search has found.

    Parameters
    ----------
    model : Model
        That was searched: with gradients, or with a proxy that has them.
    weights : ndarray, shape (m,)
        Weight of each output's difference.
    evidence : Evidence
        Of the search: its best pattern of signs, and the f of its pair.
    seed : int
        The same seed gives the same numbers, on any number of threads.
    tell : callable, optional
        Gets the share that is done, before each batch of models; what it raises ends the work.
    """
    guide = model if model.has_gradient else model.proxy
    assert guide is not None
    slopes, d = _Told(guide, tell), model.n_free
    signed, known = np.array(evidence.patterns[0][0]) * weights, evidence.objective_proxy
    assert known is not None
    signs = slope_signs(slopes, d, signed, seed=seed, tell=lambda s: slopes.reach(_SIGNS * s))
    n_vertices, at_rest, in_motion = None, None, None
    if d - signs.n_one_signed <= MAX_ENUMERATED:
        u = vertices(signs.sides).reshape(-1, d)
        n_vertices = len(u)
        y = slopes(u, np.tile(signed, (len(u), 1)))[2].reshape(2, -1, len(weights))
        at_rest = _largest(y, signed, weights)
        if guide is not model:
            y = model.examine(model.from_free_unit(u)).y.reshape(y.shape)
            in_motion = _largest(y, signed, weights)
    return BoundEvidence(
        n_inputs=d,
        n_one_signed_sampled=signs.n_sampled,
        n_one_signed=signs.n_one_signed,
        n_models=signs.n_models,
        n_failed=signs.n_failed,
        n_vertices=n_vertices,
        vertices_objective=at_rest,
        vertices_in_motion=in_motion,
        n_patterns=2 ** (int(np.count_nonzero(weights)) - 1),
        bounds=() if signs.n_failed else _bounds(slopes, weights, max(known, at_rest or 0.0), seed),
    )


def _bounds(
    slopes: _Told, weights: FloatArray, known: float, seed: int
) -> tuple[SampledBound, ...]:
    try:
        found = bound_pair(
            slopes,
            slopes.n_inputs,
            weights,
            known=known,
            widenings=tuple(p / 100.0 for p in WIDENINGS_PERCENT),
            seed=seed,
            tell=lambda s: slopes.reach(_SIGNS + (1.0 - _SIGNS) * s),
        )
    except ModelError:  # models fail somewhere within the bounds
        return ()
    return tuple(
        SampledBound(widening_percent=p, objective=one.bound, n_looks=one.n_looks)
        for p, one in zip(WIDENINGS_PERCENT, found, strict=True)
    )

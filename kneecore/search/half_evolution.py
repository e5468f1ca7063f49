"""A worst pair improved by evolution, each of its models by itself.

Where bounds are so wide that models fail within them, many inputs of a worst case end inside of the
bounds, and climbs that throw inputs from bound to bound stop short of it. For the signs of a pair's
own differences its two models have nothing to do with each other: one maximises the signed sum of
the outputs, the other minimises it. Both are evolved abreast, first widely and then near the best,
each time for the signs of the pair so far. The model may let doomed runs fail early
(`Model.screening`): near the best pairs they are many, and cost more than all others.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore.numerics.evolution import evolve_abreast
from kneecore.search.pattern_climb import BatchedModel, ClimbedPair, pair_signs, pair_value
from kneecore.search.sign_climb import Report

__all__ = ["QUICK", "THOROUGH", "evolve_pair"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Stage:
    """One evolution of both models."""

    pop_size: int
    n_generations: int
    step: float
    """First step size, a share of the cube's width."""


QUICK = (Stage(64, 150, 0.3), Stage(64, 100, 0.1))
THOROUGH = (Stage(96, 300, 0.3), Stage(96, 200, 0.1), Stage(64, 100, 0.02))


class _Ended(Exception):
    """The report has asked for the search's end."""


class _Evolution:
    """The best pair so far, and what it took."""

    def __init__(
        self, model: BatchedModel, pair: ClimbedPair, weights: FloatArray, report: Report | None
    ) -> None:
        self._model, self._weights, self._report = model, weights, report
        self.u, self.y, self.value = pair.u, pair.y, pair.value
        self.n_models = pair.n_models
        self._signs = pair_signs(pair.y, weights)

    def evaluate(self, u: FloatArray) -> FloatArray:
        """Return the signed sums of points (2, n, d), and keep the best pair among them."""
        if self._report is not None and self._report(self.value, self.n_models):
            raise _Ended
        y = self._model(u.reshape(-1, u.shape[-1])).reshape(2, u.shape[1], -1)
        self.n_models += 2 * u.shape[1]
        sums = (y * self._signs[:, None]).sum(axis=2)
        values = np.where(np.isfinite(sums), sums, -np.inf)
        for half, k in enumerate(values.argmax(axis=1)):
            self._take(half, u[half, k], y[half, k])
        return values

    def _take(self, half: int, u: FloatArray, y: FloatArray) -> None:
        pair = self.y.copy()
        pair[half] = y
        value = pair_value(pair, self._weights)
        if value > self.value:
            self.u = self.u.copy()
            self.u[half] = u
            self.y, self.value = pair, value

    def run(self, stage: Stage, rng: np.random.Generator) -> None:
        """Evolve from the best pair, for its own signs."""
        self._signs = pair_signs(self.y, self._weights)
        evolve_abreast(
            self.evaluate,
            self.u,
            pop_size=stage.pop_size,
            n_generations=stage.n_generations,
            step=stage.step,
            rng=rng,
        )


def evolve_pair(
    model: BatchedModel,
    pair: ClimbedPair,
    weights: FloatArray,
    *,
    stages: tuple[Stage, ...] = QUICK,
    seed: int = 0,
    report: Report | None = None,
) -> ClimbedPair:
    """Improve a pair by evolution; it is returned as it was where nothing better is found.

    Parameters
    ----------
    model : callable
        Maps (n, d) in the unit cube to outputs (n, m); a row of NaN is a failure.
    pair : ClimbedPair
        Where to begin.
    weights : ndarray, shape (m,)
        Weight of each output's difference.
    stages : tuple of Stage
        `QUICK` or `THOROUGH`.
    seed : int
        The same seed gives the same pair.
    report : callable, optional
        Gets the best f so far and the models run, before each generation; a true result ends the
        evolution with what it has.
    """
    evolution, rng = _Evolution(model, pair, weights, report), np.random.default_rng([seed, 2])
    try:
        for stage in stages:
            evolution.run(stage, rng)
    except _Ended:
        pass
    return ClimbedPair(
        u=evolution.u,
        y=evolution.y,
        value=evolution.value,
        first_value=pair.first_value,
        others=pair.others,
        n_models=evolution.n_models,
    )

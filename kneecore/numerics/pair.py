"""The worst-case objective: how far two models side by side differ.

f(x) = sum over the outputs j of w_j |y_j(x_1) - y_j(x_2)|, x = (x_1, x_2).

The search in a surrogate compares pairs in single precision, which is much faster and moves f by
less than the tests' 1e-5 of itself; what it finds is computed again in double precision.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore.numerics.genetic import Population
from kneecore.numerics.pair_kernels import differences, evolve
from kneecore.numerics.surrogate import Surrogate

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ModelPair:
    """The objective for any batched model."""

    model: Callable[[FloatArray], FloatArray]
    """Maps (n, d) to (n, m); rows of NaN are failures."""
    weights: FloatArray
    """w, shape (m,)."""

    def __call__(self, pairs: FloatArray) -> FloatArray:
        """Return f of `pairs`, shape (n, 2 d) -> (n,); minus infinity where a model failed."""
        y = self.model(pairs.reshape(2 * len(pairs), -1)).reshape(len(pairs), 2, -1)
        with np.errstate(invalid="ignore"):
            f: FloatArray = (np.abs(y[:, 0] - y[:, 1]) * self.weights).sum(axis=1)
        return np.where(np.isfinite(f), f, -np.inf)


class SurrogatePair:
    """The objective for a surrogate, with a fused search (see `kneecore.numerics.genetic.Fused`).

    Parameters
    ----------
    surrogate : Surrogate
    weights : ndarray, shape (m,)
        Weight of each output's difference.
    """

    def __init__(self, surrogate: Surrogate, weights: FloatArray) -> None:
        self._surrogate = surrogate
        self._weights = weights
        wanted = np.zeros(len(surrogate.weights))
        wanted[: len(weights)] = weights
        self._arrays = (
            surrogate.centres.astype(np.float32),
            surrogate.weights.astype(np.float32),
            surrogate.tail.astype(np.float32),
            wanted.astype(np.float32),
        )

    def __call__(self, pairs: FloatArray) -> FloatArray:
        """Return f of `pairs`, shape (n, 2 d) -> (n,), in single precision."""
        totals = np.empty(len(pairs))
        differences(np.ascontiguousarray(pairs), *self._arrays, totals)
        return totals

    def exact(self, pair: FloatArray) -> float:
        """Return f of one `pair`, shape (2 d,), in double precision."""
        y = self._surrogate(pair.reshape(2, -1))
        return float((np.abs(y[0] - y[1]) * self._weights).sum())

    def evolve(self, population: Population, n_generations: int) -> FloatArray:
        """Breed `n_generations` in place and return the best value after each."""
        options = population.options
        n_elite, n_crossover, _ = options.split(len(population.x))
        first = population.generation
        exponents = [population.mutation_exponent(first + 1 + k) for k in range(n_generations)]
        best = np.empty(n_generations)
        evolve(
            population.x,
            population.values,
            population.lower,
            population.upper,
            options.rank_chances(len(population.x)),
            n_elite,
            n_crossover,
            options.blx_alpha,
            np.array(exponents),
            options.gene_mutation_probability,
            population.seed,
            first,
            *self._arrays,
            best,
        )
        population.generation += n_generations
        return best

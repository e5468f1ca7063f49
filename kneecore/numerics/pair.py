"""The worst-case objective: how far two models side by side differ.

f(x) = sum over the outputs j of w_j |y_j(x_1) - y_j(x_2)|, x = (x_1, x_2).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore._jit import kernel
from kneecore.numerics import breeding, thin_plate
from kneecore.numerics.genetic import Population
from kneecore.numerics.surrogate import Surrogate

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


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
        f: FloatArray = (np.abs(y[:, 0] - y[:, 1]) * self.weights).sum(axis=1)
        return np.where(np.isfinite(f), f, -np.inf)


@kernel
def _evolve(
    population: FloatArray,
    values: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    cumulative: FloatArray,
    n_elite: int,
    n_crossover: int,
    alpha: float,
    exponents: FloatArray,
    probability: float,
    seed: int,
    generation: int,
    centres: FloatArray,
    weights: FloatArray,
    tail: FloatArray,
    wanted: FloatArray,
    best: FloatArray,
) -> None:
    """Breed and evaluate ``len(best)`` generations in place."""
    pop_size = population.shape[0]
    children = np.empty_like(population)
    order, spare = np.empty(pop_size, dtype=np.int64), np.empty(pop_size, dtype=np.int64)
    fresh, kept = np.empty(pop_size - n_elite), np.empty(n_elite)
    for step in range(best.shape[0]):
        breeding.rank(values, order, spare)
        breeding.breed(
            population,
            order,
            cumulative,
            lower,
            upper,
            n_elite,
            n_crossover,
            alpha,
            exponents[step],
            probability,
            seed,
            generation + 1 + step,
            children,
        )
        thin_plate.evaluate_differences(children[n_elite:], centres, weights, tail, wanted, fresh)
        for i in range(n_elite):
            kept[i] = values[order[i]]
        top = kept[0]
        for i in range(pop_size):
            values[i] = kept[i] if i < n_elite else fresh[i - n_elite]
            top = max(top, values[i])
            for k in range(population.shape[1]):
                population[i, k] = children[i, k]
        best[step] = top


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
        self._wanted = np.zeros(len(surrogate.weights))
        self._wanted[: len(weights)] = weights

    def __call__(self, pairs: FloatArray) -> FloatArray:
        """Return f of `pairs`, shape (n, 2 d) -> (n,)."""
        s = self._surrogate
        totals = np.empty(len(pairs))
        thin_plate.evaluate_differences(
            np.ascontiguousarray(pairs), s.centres, s.weights, s.tail, self._wanted, totals
        )
        return totals

    def evolve(self, population: Population, n_generations: int) -> FloatArray:
        """Breed `n_generations` in place and return the best value after each."""
        s, options = self._surrogate, population.options
        n_elite, n_crossover, _ = options.split(len(population.x))
        first = population.generation
        exponents = [population.mutation_exponent(first + 1 + k) for k in range(n_generations)]
        best = np.empty(n_generations)
        _evolve(
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
            s.centres,
            s.weights,
            s.tail,
            self._wanted,
            best,
        )
        population.generation += n_generations
        return best

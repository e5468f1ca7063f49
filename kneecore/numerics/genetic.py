"""A real-coded genetic algorithm after Herrera, Lozano & Verdegay 1998 (Artif Intell Rev 12:265).

The operators are those that Ciszkiewicz & Dumas 2024 name: rank-based scaling, roulette wheel,
BLX-alpha crossover, non-uniform mutation, and 70 / 20 / 10 per cent of the next generation from
crossover, mutation and elite. What they leave open is chosen, with the reason, in
`kneecore.numerics.genetic_options`. The algorithm knows no model: it maximises any callable.

Examples
--------
>>> import numpy as np
>>> from kneecore.numerics.genetic import maximize
>>> best = maximize(lambda x: -((x - 0.3) ** 2).sum(axis=1), np.zeros(4), np.ones(4), seed=0)
>>> bool(np.allclose(best.x, 0.3, atol=0.01))
True
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore.errors import ModelError, ParameterError
from kneecore.numerics import breeding
from kneecore.numerics.genetic_options import GeneticOptions
from kneecore.numerics.sampling_options import check_count, check_seed

__all__ = ["Fused", "GeneticOptions", "GeneticResult", "Kept", "Population", "maximize"]

FloatArray = NDArray[np.float64]
Objective = Callable[[FloatArray], FloatArray]

GENERATIONS_PER_CALL = 50
"""Generations that a fused objective breeds between two looks at the callback: about 2 ms."""


@dataclass(kw_only=True, eq=False)
class Population:
    """The state of a search between two generations. Fused objectives change it in place."""

    x: FloatArray
    """Individuals, shape (pop_size, d)."""
    values: FloatArray
    """Their objective values, shape (pop_size,); minus infinity for failures."""
    lower: FloatArray
    upper: FloatArray
    options: GeneticOptions
    seed: int
    generation: int
    """Generations bred so far."""
    n_generations: int
    """Generations in all."""

    def mutation_exponent(self, generation: int) -> float:
        """Return (1 - g / G)^b for the breeding of `generation` (from 1)."""
        left = 1.0 - (generation - 1) / self.n_generations
        return float(left**self.options.mutation_b)


@runtime_checkable
class Fused(Protocol):
    """An objective that breeds and evaluates whole generations in one compiled call."""

    def __call__(self, x: FloatArray, /) -> FloatArray:
        """Return the values of individuals, shape (n, d) -> (n,)."""
        ...

    def evolve(self, population: Population, n_generations: int) -> FloatArray:
        """Breed in place and return the best value after each generation."""
        ...


class Kept(Protocol):
    """Where the state of a search is kept, so that it can go on after it was stopped."""

    def load(self) -> Mapping[str, NDArray[Any]] | None:
        """Return the state that was kept last, or None."""
        ...

    def save(self, state: Callable[[], dict[str, NDArray[Any]]], *, now: bool = False) -> None:
        """Keep a state, unless one was kept a moment ago and it need not be now."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class GeneticResult:
    """The outcome of a search."""

    x: FloatArray
    """Best individual, shape (d,)."""
    value: float
    """Its objective value."""
    history: FloatArray
    """Best value after each generation, the first population's first; never falls."""
    n_evaluations: int
    """Individuals evaluated; the elite is not evaluated again."""
    stop_reason: str
    """`max_generations` or `cancelled`."""


def _call(objective: Objective, x: FloatArray) -> FloatArray:
    values = np.array(objective(x), dtype=np.float64)
    if values.shape != (len(x),):
        raise ParameterError(
            f"`objective` returned shape {values.shape} for {len(x)} individuals; "
            f"({len(x)},) is allowed"
        )
    values[np.isnan(values)] = -np.inf
    return values


def _evolve_one(objective: Objective, population: Population) -> FloatArray:
    """Breed and evaluate one generation in place; return its best value."""
    pop_size = len(population.x)
    n_elite, n_crossover, _ = population.options.split(pop_size)
    order, spare = np.empty(pop_size, dtype=np.int64), np.empty(pop_size, dtype=np.int64)
    breeding.rank(population.values, order, spare)
    chances = breeding.rank_chances(population.options, pop_size)
    generation = population.generation + 1
    children = np.empty_like(population.x)
    breeding.breed(
        population.x,
        order,
        chances,
        breeding.wheel_starts(chances),
        population.lower,
        population.upper,
        n_elite,
        n_crossover,
        population.options.blx_alpha,
        population.mutation_exponent(generation),
        population.options.gene_mutation_probability,
        population.seed,
        generation,
        0,
        pop_size,
        children,
    )
    population.values = np.concatenate(
        [population.values[order[:n_elite]], _call(objective, children[n_elite:])]
    )
    population.x = children
    population.generation = generation
    best: FloatArray = population.values.max(keepdims=True)
    return best


def _bounds(lower: ArrayLike, upper: ArrayLike) -> tuple[FloatArray, FloatArray]:
    low = np.array(lower, dtype=np.float64)
    high = np.array(upper, dtype=np.float64)
    if low.ndim != 1 or low.shape != high.shape or len(low) == 0:
        raise ParameterError(
            f"`lower` and `upper` have shapes {low.shape} and {high.shape}; one (d,) is allowed"
        )
    if not (np.isfinite(low).all() and np.isfinite(high).all() and (low <= high).all()):
        raise ParameterError("`lower` and `upper` must be finite, and no lower above its upper")
    return low, high


def _begun(
    objective: Objective, population: Population, before: Mapping[str, NDArray[Any]] | None
) -> tuple[Population, list[FloatArray]]:
    """Return the first population, or the one that was kept, and the best values until then."""
    if before is None:
        breeding.first_population(population.seed, population.lower, population.upper, population.x)
        population.values = _call(objective, population.x)
        return population, [population.values.max(keepdims=True)]
    population.x, population.values = before["x"], before["values"]
    population.generation = int(before["generation"])
    return population, [before["history"]]


def maximize(
    objective: Objective | Fused,
    lower: ArrayLike,
    upper: ArrayLike,
    *,
    pop_size: int = 200,
    n_generations: int = 800,
    options: GeneticOptions | None = None,
    seed: int = 0,
    callback: Callable[[int, float], object] | None = None,
    kept: Kept | None = None,
) -> GeneticResult:
    """Maximise `objective` within bounds.

    Parameters
    ----------
    objective : callable
        Maps individuals (n, d) to values (n,); NaN counts as minus infinity. A `Fused` objective
        breeds whole generations in one compiled call, with the same numbers.
    lower, upper : array_like, shape (d,)
        Bounds.
    pop_size : int
        Individuals in a generation.
    n_generations : int
        Generations bred after the first, random one.
    options : GeneticOptions, optional
        Constants of the operators.
    seed : int
        The same seed gives the same bytes.
    callback : callable, optional
        Called with (generations so far, best value so far); a true result cancels the search.
    kept : Kept, optional
        Where its state is kept, and from which it goes on: with the same arguments.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    ModelError
        If no individual of the whole search could be evaluated.
    """
    options = options or GeneticOptions()
    low, high = _bounds(lower, upper)
    n_elite = options.split(check_count("pop_size", pop_size))[0]
    population, history = _begun(
        objective,
        Population(
            x=np.empty((pop_size, len(low))),
            values=np.empty(pop_size),
            lower=low,
            upper=high,
            options=options,
            seed=check_seed(seed),
            generation=0,
            n_generations=check_count("n_generations", n_generations),
        ),
        None if kept is None else kept.load(),
    )

    def state() -> dict[str, NDArray[Any]]:
        return {
            "x": population.x,
            "values": population.values,
            "generation": np.array(population.generation),
            "history": np.concatenate(history),
        }

    step = GENERATIONS_PER_CALL if isinstance(objective, Fused) else 1
    cancelled = False
    while population.generation < n_generations:
        if callback is not None and callback(population.generation, float(history[-1][-1])):
            cancelled = True
            break
        if isinstance(objective, Fused):
            left = n_generations - population.generation
            history.append(objective.evolve(population, min(step, left)))
        else:
            history.append(_evolve_one(objective, population))
        if kept is not None:
            kept.save(state)
    else:
        if callback is not None:
            callback(population.generation, float(history[-1][-1]))
    if kept is not None:
        kept.save(state, now=True)
    best = int(np.argmax(population.values))
    if not np.isfinite(population.values[best]):
        raise ModelError("no individual could be evaluated: every model of the search failed")
    return GeneticResult(
        x=population.x[best].copy(),
        value=float(population.values[best]),
        history=np.concatenate(history),
        n_evaluations=pop_size + population.generation * (pop_size - n_elite),
        stop_reason="cancelled" if cancelled else "max_generations",
    )

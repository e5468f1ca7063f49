"""The worst-case objective: how far two models side by side differ.

f(x) = sum over the outputs j of w_j |y_j(x_1) - y_j(x_2)|, x = (x_1, x_2).

The search in a surrogate compares pairs in single precision, which is much faster and moves f by
less than the tests' 1e-5 of itself; what it finds is computed again in double precision.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore._threads import run_together, thread_count
from kneecore.numerics.breeding import rank_chances, wheel_starts
from kneecore.numerics.genetic import Population
from kneecore.numerics.pair_kernels import LEAVE, N_COUNTERS, evolve
from kneecore.numerics.surrogate import Surrogate
from kneecore.numerics.thin_plate import LANES

FloatArray = NDArray[np.float64]

SHORTEST_PAUSE, LONGEST_PAUSE = 8, 64
"""Calls without helpers, of a millisecond or two each, after helpers have come in vain."""

_EMPTY = np.empty(0)
_NO_BREEDING = (_EMPTY, _EMPTY, _EMPTY, np.empty(0, np.int64), 0, 0, 0.0, _EMPTY, 0.0, 0, 0, _EMPTY)


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
    threads : int, optional
        Threads that share a search; all available cores for None. They change no bit.
    """

    def __init__(
        self, surrogate: Surrogate, weights: FloatArray, threads: int | None = None
    ) -> None:
        self._surrogate = surrogate
        self._weights = weights
        self._threads = thread_count(threads)
        self._alone, self._pause = 0, 0
        n_rows = -len(surrogate.weights) % 4
        wanted = np.zeros(len(surrogate.weights) + n_rows)
        wanted[: len(weights)] = weights
        shift = surrogate.centres.mean(axis=0)
        centres = surrogate.centres - shift
        # q log(q) = log(2) q log2(q), and the kernel has the binary logarithm.
        kernel_weights = np.log(2.0) * surrogate.weights
        self._arrays = (
            np.ascontiguousarray(shift[: surrogate.n_dimensions]),
            (-2.0 * centres).astype(np.float32),
            (centres**2).sum(axis=1).astype(np.float32),
            np.pad(kernel_weights, ((0, n_rows), (0, 0))).astype(np.float32),
            np.pad(surrogate.tail, ((0, n_rows), (0, 0))).astype(np.float32),
            wanted.astype(np.float32),
        )

    def __call__(self, pairs: FloatArray) -> FloatArray:
        """Return f of `pairs`, shape (n, 2 d) -> (n,), in single precision."""
        totals = np.empty(len(pairs))
        self._share_out(np.array([pairs]), totals[None], _NO_BREEDING, len(pairs))
        return totals

    def exact(self, pair: FloatArray) -> float:
        """Return f of one `pair`, shape (2 d,), in double precision."""
        y = self._surrogate(pair.reshape(2, -1))
        return float((np.abs(y[0] - y[1]) * self._weights).sum())

    def evolve(self, population: Population, n_generations: int) -> FloatArray:
        """Breed `n_generations` in place and return the best value after each."""
        pop_size, options = len(population.x), population.options
        n_elite, n_crossover, _ = options.split(pop_size)
        chances = rank_chances(options, pop_size)
        first = population.generation
        exponents = [population.mutation_exponent(first + 1 + k) for k in range(n_generations)]
        populations, values = np.array([population.x] * 2), np.array([population.values] * 2)
        best = np.empty(n_generations)
        breeding = (
            population.lower,
            population.upper,
            chances,
            wheel_starts(chances),
            n_elite,
            n_crossover,
            options.blx_alpha,
            np.array(exponents),
            options.gene_mutation_probability,
            population.seed,
            first,
            best,
        )
        self._share_out(populations, values, breeding, pop_size - n_elite)
        last = n_generations % 2
        population.x, population.values = populations[last], values[last]
        population.generation += n_generations
        return np.append(best[1:], values[last].max())

    def _share_out(
        self, populations: FloatArray, values: FloatArray, breeding: tuple[Any, ...], n_fresh: int
    ) -> None:
        """Evaluate, or breed and evaluate, on as many threads as come (see `evolve`)."""
        counters = np.zeros(N_COUNTERS, dtype=np.int64)
        arguments = (populations, values, *breeding, *self._arrays, counters)
        call: Callable[..., None] = evolve

        def work(leads: bool) -> None:
            call(*arguments, leads)

        n_blocks = -(-n_fresh // LANES)
        helped = self._alone == 0
        run_together(work, min(self._threads, n_blocks) if helped else 1)
        self._next_help(helped, counters[LEAVE] > 0)

    def _next_help(self, helped: bool, in_vain: bool) -> None:
        """On a busy machine helpers only stop each other: try again after ever longer pauses."""
        if not helped:
            self._alone -= 1
        elif in_vain:
            self._pause = min(max(2 * self._pause, SHORTEST_PAUSE), LONGEST_PAUSE)
            self._alone = self._pause
        else:
            self._pause //= 2

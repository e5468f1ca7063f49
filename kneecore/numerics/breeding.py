"""Compiled operators of the genetic algorithm, and its random numbers.

Random numbers come from a counter: number `j` of child `c` of generation `g` is a hash of
(seed, g, c, j), so no order of evaluation and no number of threads can change it. The hash is the
output function of SplitMix64 (Steele, Lea & Flood 2014, OOPSLA).
"""

import numpy as np
from numpy.typing import NDArray

from kneecore._jit import inline, kernel
from kneecore.numerics.genetic_options import GeneticOptions

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_30, _27, _31, _11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_TO_UNIT = 1.0 / 9007199254740992.0  # 2^-53

# Not literals: numba would compile the functions that they are given to for each anew.
_FIRST, _SECOND = np.int64(0), np.int64(1)
_RUN = np.int64(32)
"""Individuals whose ranks are counted; longer runs are merged."""
GENES = np.int64(32)
"""Genes handled at once: the compiler leaves no remainder of a loop of this length unvectorised."""


@inline
def _mix(z):  # type: ignore[no-untyped-def]
    z = (z ^ (z >> _30)) * _MIX_1
    z = (z ^ (z >> _27)) * _MIX_2
    return z ^ (z >> _31)


@inline
def stream(seed, generation, child):  # type: ignore[no-untyped-def]
    """Return the key of a child's random numbers."""
    key = _mix(np.uint64(seed) + _GOLDEN)
    key = _mix(key ^ (np.uint64(generation) * _GOLDEN))
    return _mix(key + np.uint64(child) * _GOLDEN)


@inline
def uniform(key, index):  # type: ignore[no-untyped-def]
    """Return number `index` of a stream, uniform in [0, 1)."""
    bits = _mix(key + np.uint64(index + 1) * _GOLDEN)
    return np.float64(bits >> _11) * _TO_UNIT


@kernel
def first_population(
    seed: int, lower: FloatArray, upper: FloatArray, population: FloatArray
) -> None:
    """Fill `population` (pop_size, d) uniformly within the bounds."""
    for i in range(population.shape[0]):
        key = stream(seed, _FIRST, i)
        for k in range(population.shape[1]):
            population[i, k] = lower[k] + uniform(key, k) * (upper[k] - lower[k])


@inline
def _rank_run(values, begin, count, order):  # type: ignore[no-untyped-def]
    """Rank a short run by counting what comes before each: there is no branch to be guessed."""
    run = values[begin:]
    for i in range(count):
        value, place = run[i], begin
        for j in range(count):
            place += (run[j] > value) | ((run[j] == value) & (j < i))
        order[place] = begin + i


@kernel
def rank(values: FloatArray, order: IntArray, spare: IntArray) -> None:
    """Fill `order` with indices by falling value; ties keep their order (merge sort)."""
    n = values.shape[0]
    for i in range(n):
        order[i] = i
    for begin in range(0, n - _RUN + 1, _RUN):
        _rank_run(values, begin, _RUN, order)
    rest = n % _RUN
    _rank_run(values, n - rest, rest, order)
    width = _RUN
    while width < n:
        for begin in range(0, n, 2 * width):
            middle, end = min(begin + width, n), min(begin + 2 * width, n)
            left, right = begin, middle
            for out in range(begin, end):
                if right >= end or (left < middle and values[order[left]] >= values[order[right]]):
                    spare[out] = order[left]
                    left += 1
                else:
                    spare[out] = order[right]
                    right += 1
        for i in range(n):
            order[i] = spare[i]
        width *= 2


def wheel_starts(cumulative: FloatArray) -> IntArray:
    """Return for each of n equal parts of [0, 1) the first rank on which a wheel can stop there."""
    n = len(cumulative)
    return np.minimum(np.searchsorted(cumulative, np.arange(n) / n, side="right"), n - 1)


@inline
def _spin(cumulative, starts, u):  # type: ignore[no-untyped-def]
    """Return the rank on which a roulette wheel stops: the first with u < cumulative."""
    rank = starts[int(u * cumulative.shape[0])]
    while u >= cumulative[rank]:
        rank += 1
    return rank


@inline
def _cross_genes(key, first, count, mother, father, lower, upper, widening, child):  # type: ignore[no-untyped-def]
    a, b, low, high = mother[first:], father[first:], lower[first:], upper[first:]
    genes = child[first:]
    for k in range(count):
        gene = 0.5 * (a[k] + b[k]) + (uniform(key, 2 + first + k) - 0.5) * widening * abs(
            a[k] - b[k]
        )
        gene = gene if gene > low[k] else low[k]
        genes[k] = gene if gene < high[k] else high[k]


@inline
def _cross(key, mother, father, lower, upper, alpha, child):  # type: ignore[no-untyped-def]
    """BLX-alpha: each gene uniform on the parents' interval, widened by alpha on both sides."""
    d, widening = child.shape[0], 1.0 + 2.0 * alpha
    if d < GENES:
        _cross_genes(key, _FIRST, d, mother, father, lower, upper, widening, child)
        return
    for first in range(0, d, GENES):
        # The last block reaches back over genes that are there already: they come out the same.
        begin = min(first, d - GENES)
        _cross_genes(key, begin, GENES, mother, father, lower, upper, widening, child)


@inline
def _mutate_gene(key, k, d, gene, low, high, exponent):  # type: ignore[no-untyped-def]
    """Non-uniform mutation: a step y (1 - r^exponent) towards either bound, y the way to it."""
    shrink = 1.0 - uniform(key, 3 + d + 2 * k) ** exponent
    bound = high if uniform(key, 4 + d + 2 * k) < 0.5 else low
    return min(max(gene + shrink * (bound - gene), low), high)


@inline
def _mutate(key, parent, lower, upper, exponent, probability, draws, child):  # type: ignore[no-untyped-def]
    """Mutate each gene with the given probability, and one at random if none was drawn."""
    d = child.shape[0]
    for first in range(0, draws.shape[0], GENES):
        for k in range(GENES):
            draws[first + k] = uniform(key, 2 + first + k)
    drawn = min(int(uniform(key, 2 + d) * d), d - 1)
    for k in range(d):
        child[k] = parent[k]
    for k in range(d):
        if draws[k] < probability:
            drawn = -1
            child[k] = _mutate_gene(key, k, d, parent[k], lower[k], upper[k], exponent)
    if drawn >= 0:
        child[drawn] = _mutate_gene(
            key, drawn, d, parent[drawn], lower[drawn], upper[drawn], exponent
        )


@kernel
def breed(
    population: FloatArray,
    order: IntArray,
    cumulative: FloatArray,
    starts: IntArray,
    lower: FloatArray,
    upper: FloatArray,
    n_elite: int,
    n_crossover: int,
    alpha: float,
    exponent: float,
    probability: float,
    seed: int,
    generation: int,
    first: int,
    stop: int,
    children: FloatArray,
) -> None:
    """Fill rows `first` to `stop` of `children` (pop_size, d): elite, crossover, mutation.

    A child's numbers are its own, so that any split of the rows gives the same children.

    Parameters
    ----------
    order : ndarray of int
        Indices of `population` by falling value.
    cumulative, starts : ndarray
        Cumulative chance of each rank, and where to begin the look into it (`wheel_starts`).
    exponent : float
        (1 - g / G)^b, the shrinking of the non-uniform mutation.
    generation : int
        Number of this generation for the random numbers, from 1.
    """
    d = population.shape[1]
    draws = np.empty((d + GENES - 1) // GENES * GENES)
    keys = np.empty(stop - first, dtype=np.uint64)
    spins = np.empty((2, stop - first))
    for i in range(stop - first):
        keys[i] = stream(seed, generation, first + i)
        spins[0, i], spins[1, i] = uniform(keys[i], _FIRST), uniform(keys[i], _SECOND)
    for i in range(first, stop):
        child, key = children[i], keys[i - first]
        if i < n_elite:
            for k in range(d):
                child[k] = population[order[i], k]
            continue
        parent = population[order[_spin(cumulative, starts, spins[0, i - first])]]
        if i < n_elite + n_crossover:
            other = population[order[_spin(cumulative, starts, spins[1, i - first])]]
            _cross(key, parent, other, lower, upper, alpha, child)
        else:
            _mutate(key, parent, lower, upper, exponent, probability, draws, child)


def rank_chances(options: GeneticOptions, pop_size: int) -> FloatArray:
    """Return the cumulative chance of each rank, best first, shape (pop_size,)."""
    ranks = np.arange(pop_size) / (pop_size - 1)
    best = 2.0 - options.rank_eta_min
    cumulative = np.cumsum((best - (best - options.rank_eta_min) * ranks) / pop_size)
    cumulative[-1] = 1.0
    return cumulative

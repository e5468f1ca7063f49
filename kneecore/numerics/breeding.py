"""Compiled operators of the genetic algorithm, and its random numbers.

Random numbers come from a counter: number `j` of child `c` of generation `g` is a hash of
(seed, g, c, j), so no order of evaluation and no number of threads can change it. The hash is the
output function of SplitMix64 (Steele, Lea & Flood 2014, OOPSLA).
"""

import numpy as np
from numpy.typing import NDArray

from kneecore._jit import inline, kernel

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_30, _27, _31, _11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_TO_UNIT = 1.0 / 9007199254740992.0  # 2^-53


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
        key = stream(seed, 0, i)
        for k in range(population.shape[1]):
            population[i, k] = lower[k] + uniform(key, k) * (upper[k] - lower[k])


@kernel
def rank(values: FloatArray, order: IntArray, spare: IntArray) -> None:
    """Fill `order` with indices by falling value; ties keep their order (merge sort)."""
    n = values.shape[0]
    for i in range(n):
        order[i] = i
    width = 1
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


@inline
def _spin(cumulative, u):  # type: ignore[no-untyped-def]
    """Return the rank on which a roulette wheel stops: the first with u < cumulative."""
    low, high = 0, cumulative.shape[0] - 1
    while low < high:
        middle = (low + high) // 2
        if u < cumulative[middle]:
            high = middle
        else:
            low = middle + 1
    return low


@inline
def _cross(key, population, mother, father, lower, upper, alpha, children, i):  # type: ignore[no-untyped-def]
    """BLX-alpha: each gene uniform on the parents' interval, widened by alpha on both sides."""
    for k in range(population.shape[1]):
        a, b = population[mother, k], population[father, k]
        low, high = min(a, b), max(a, b)
        width = high - low
        gene = low - alpha * width + uniform(key, 2 + k) * (1.0 + 2.0 * alpha) * width
        children[i, k] = min(max(gene, lower[k]), upper[k])


@inline
def _mutate_gene(key, k, gene, low, high, exponent):  # type: ignore[no-untyped-def]
    """Non-uniform mutation: a step y (1 - r^exponent) towards either bound, y the way to it."""
    shrink = 1.0 - uniform(key, 3 + 3 * k) ** exponent
    bound = high if uniform(key, 2 + 3 * k) < 0.5 else low
    return min(max(gene + shrink * (bound - gene), low), high)


@inline
def _mutate(key, population, parent, lower, upper, exponent, probability, children, i):  # type: ignore[no-untyped-def]
    """Mutate each gene with the given probability, and one at random if none was drawn."""
    d = population.shape[1]
    drawn = min(int(uniform(key, 1 + 3 * d) * d), d - 1)
    for k in range(d):
        children[i, k] = population[parent, k]
        if uniform(key, 1 + 3 * k) < probability:
            drawn = -1
            children[i, k] = _mutate_gene(
                key, k, population[parent, k], lower[k], upper[k], exponent
            )
    if drawn >= 0:
        children[i, drawn] = _mutate_gene(
            key, drawn, population[parent, drawn], lower[drawn], upper[drawn], exponent
        )


@kernel
def breed(
    population: FloatArray,
    order: IntArray,
    cumulative: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    n_elite: int,
    n_crossover: int,
    alpha: float,
    exponent: float,
    probability: float,
    seed: int,
    generation: int,
    children: FloatArray,
) -> None:
    """Fill `children` (pop_size, d): the elite as it is, then crossover, then mutation.

    Parameters
    ----------
    order : ndarray of int
        Indices of `population` by falling value.
    cumulative : ndarray
        Cumulative chance of each rank.
    exponent : float
        (1 - g / G)^b, the shrinking of the non-uniform mutation.
    generation : int
        Number of this generation for the random numbers, from 1.
    """
    for i in range(children.shape[0]):
        if i < n_elite:
            for k in range(children.shape[1]):
                children[i, k] = population[order[i], k]
            continue
        key = stream(seed, generation, i)
        parent = order[_spin(cumulative, uniform(key, 0))]
        if i < n_elite + n_crossover:
            other = order[_spin(cumulative, uniform(key, 1))]
            _cross(key, population, parent, other, lower, upper, alpha, children, i)
        else:
            _mutate(key, population, parent, lower, upper, exponent, probability, children, i)

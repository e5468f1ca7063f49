"""The fused search: pairs of models compared in single precision, and whole generations bred."""

import numpy as np
from numpy.typing import NDArray

from kneecore._jit import inline, kernel
from kneecore.numerics import breeding
from kneecore.numerics.thin_plate import LANES, add_product, load, squared_distances

FloatArray = NDArray[np.float64]
SingleArray = NDArray[np.float32]

# log(1 + f) = f + f^2 P(f) as in `thin_plate`, in single precision; error 2e-8.
_L0, _L1, _L2 = np.float32(-0.499999971), np.float32(0.333336706), np.float32(-0.250011477)
_L3, _L4, _L5 = np.float32(0.199720497), np.float32(-0.165884885), np.float32(0.148347868)
_L6, _L7 = np.float32(-0.14159647), np.float32(0.0878726549)
_LOG_2, _ONE = np.float32(0.693147181), np.float32(1.0)
_SQRT_HALF_BITS, _MANTISSA = np.int32(1060439283), np.int32(23)
_MAGIC_BITS, _MAGIC = np.int32(1262485504), np.float32(12582912.0)  # 2^23 + 2^22


@inline
def _log_single(q, parts, log_q):  # type: ignore[no-untyped-def]
    """Fill the flat `log_q` with log(q) for positive q; 0 gives about -88, so 0 log(0) is 0."""
    n = q.shape[0]
    q_bits, parts_bits = q.view(np.int32), parts.view(np.int32)
    for i in range(n):
        exponent = np.int32((q_bits[i] - _SQRT_HALF_BITS) >> _MANTISSA)
        parts_bits[0, i] = q_bits[i] - np.int32(exponent << _MANTISSA)
        parts_bits[1, i] = exponent + _MAGIC_BITS
    for i in range(n):
        f = parts[0, i] - _ONE
        p = _L3 + f * (_L4 + f * (_L5 + f * (_L6 + f * _L7)))
        p = _L0 + f * (_L1 + f * (_L2 + f * p))
        log_q[i] = (parts[1, i] - _MAGIC) * _LOG_2 + (f + f * f * p)


@kernel
def differences(
    pairs: FloatArray,
    centres: SingleArray,
    weights: SingleArray,
    tail: SingleArray,
    wanted: SingleArray,
    totals: FloatArray,
) -> None:
    """Fill `totals` with sum_j wanted_j |y_j(x_1) - y_j(x_2)| for `pairs` (n_pairs, 2 d).

    Only the difference is needed, so the spline is contracted once a pair and the constants drop
    out. The other arrays are those of `evaluate`.
    """
    n, d = centres.shape[0], pairs.shape[1] // 2
    x1 = np.zeros((centres.shape[1], LANES), dtype=np.float32)
    x2 = np.zeros((centres.shape[1], LANES), dtype=np.float32)
    y = np.empty((weights.shape[0], LANES), dtype=np.float32)
    total = np.empty(LANES, dtype=np.float32)
    q = np.empty((n, LANES), dtype=np.float32)
    phi = np.empty((n, LANES), dtype=np.float32)
    log_q = np.empty((n, LANES), dtype=np.float32)
    parts = np.empty((2, n * LANES), dtype=np.float32)
    flat_q, flat_log = q.reshape(n * LANES), log_q.reshape(n * LANES)
    flat_phi = phi.reshape(n * LANES)
    for first in range(0, pairs.shape[0], LANES):
        load(pairs, first, 0, d, x1)
        load(pairs, first, d, d, x2)
        squared_distances(x1, centres, q)
        _log_single(flat_q, parts, flat_log)
        for i in range(n * LANES):
            flat_phi[i] = flat_q[i] * flat_log[i]
        squared_distances(x2, centres, q)
        _log_single(flat_q, parts, flat_log)
        for i in range(n * LANES):
            flat_phi[i] -= flat_q[i] * flat_log[i]
        for k in range(x1.shape[0]):
            for j in range(LANES):
                x1[k, j] -= x2[k, j]
        for row in range(y.shape[0]):
            for j in range(LANES):
                y[row, j] = 0.0
        add_product(weights, phi, y)
        add_product(tail, x1, y)
        for j in range(LANES):
            total[j] = 0.0
        for row in range(y.shape[0]):
            for j in range(LANES):
                total[j] += wanted[row] * abs(y[row, j])
        for j in range(min(LANES, pairs.shape[0] - first)):
            totals[first + j] = total[j]


@kernel
def evolve(
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
    centres: SingleArray,
    weights: SingleArray,
    tail: SingleArray,
    wanted: SingleArray,
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
        differences(children[n_elite:], centres, weights, tail, wanted, fresh)
        for i in range(n_elite):
            kept[i] = values[order[i]]
        top = kept[0]
        for i in range(pop_size):
            values[i] = kept[i] if i < n_elite else fresh[i - n_elite]
            top = max(top, values[i])
            for k in range(population.shape[1]):
                population[i, k] = children[i, k]
        best[step] = top

"""The fused search: pairs of models compared in single precision, and whole generations bred."""

import numpy as np
from numpy.typing import NDArray

from kneecore._jit import inline, kernel, written_in
from kneecore.numerics import breeding
from kneecore.numerics.atomic import fetch, fetch_add
from kneecore.numerics.thin_plate import LANES

FloatArray = NDArray[np.float64]
SingleArray = NDArray[np.float32]
IntArray = NDArray[np.int64]

# log2(1 + f) = f P(f) for sqrt(1/2) <= 1 + f < sqrt(2), near minimax; error 7e-9 before rounding.
_P0, _P1, _P2 = np.float32(1.44269490), np.float32(-0.721347153), np.float32(0.480922520)
_P3, _P4, _P5 = np.float32(-0.360721201), np.float32(0.287656665), np.float32(-0.238519445)
_P6, _P7, _P8 = np.float32(0.217379406), np.float32(-0.210303321), np.float32(0.125412360)
_ZERO, _ONE = np.float32(0.0), np.float32(1.0)
_SQRT_HALF_BITS, _MANTISSA = np.int32(1060439283), np.int32(23)
_NOTHING = np.int32(0)

TICKET, DONE, LEAVE, N_COUNTERS = 0, 16, 32, 48
"""Places of the counters of `evolve`, on cache lines of their own."""

PATIENCE = 1000
"""Looks in vain at another thread (0.3 ns each) per centre and dimension: twenty times what a
block takes. A thread that needs longer has lost its core to somebody else."""


@inline
def _from(points, row, stop, begin):  # type: ignore[no-untyped-def]
    return points[min(row, stop - 1), begin:]


@inline
def _load(points, first, stop, begin, shift, x, squares):  # type: ignore[no-untyped-def]
    """Load ``len(shift)`` columns of rows `first` on into the lanes of `x`, and |x|^2.

    Lanes from `stop` on repeat the last row. Eight rows at once, so that eight lanes are one store.
    """
    for j in range(0, LANES, 8):
        a, b = _from(points, first + j, stop, begin), _from(points, first + j + 1, stop, begin)
        c, d = _from(points, first + j + 2, stop, begin), _from(points, first + j + 3, stop, begin)
        e, f = _from(points, first + j + 4, stop, begin), _from(points, first + j + 5, stop, begin)
        g, h = _from(points, first + j + 6, stop, begin), _from(points, first + j + 7, stop, begin)
        for k in range(shift.shape[0]):
            lanes, s = x[k, j:], shift[k]
            lanes[0], lanes[1], lanes[2], lanes[3] = a[k] - s, b[k] - s, c[k] - s, d[k] - s
            lanes[4], lanes[5], lanes[6], lanes[7] = e[k] - s, f[k] - s, g[k] - s, h[k] - s
    for j in range(LANES):
        squares[j] = _ZERO
    for k in range(x.shape[0]):
        for j in range(LANES):
            squares[j] += x[k, j] * x[k, j]


@inline
def _add_product(matrix, first, v, y):  # type: ignore[no-untyped-def]
    """Add rows `first` to `first` + 4 of `matrix` times `v` (n, LANES) to `y` (4, LANES)."""
    r, s, t = first + 1, first + 2, first + 3
    for i in range(0, v.shape[0], 4):
        k, m, n = i + 1, i + 2, i + 3
        a0, a1, a2, a3 = matrix[first, i], matrix[first, k], matrix[first, m], matrix[first, n]
        b0, b1, b2, b3 = matrix[r, i], matrix[r, k], matrix[r, m], matrix[r, n]
        c0, c1, c2, c3 = matrix[s, i], matrix[s, k], matrix[s, m], matrix[s, n]
        d0, d1, d2, d3 = matrix[t, i], matrix[t, k], matrix[t, m], matrix[t, n]
        for j in range(LANES):
            v0, v1, v2, v3 = v[i, j], v[k, j], v[m, j], v[n, j]
            y[0, j] += a0 * v0 + a1 * v1 + a2 * v2 + a3 * v3
            y[1, j] += b0 * v0 + b1 * v1 + b2 * v2 + b3 * v3
            y[2, j] += c0 * v0 + c1 * v1 + c2 * v2 + c3 * v3
            y[3, j] += d0 * v0 + d1 * v1 + d2 * v2 + d3 * v3


@written_in
def _four_kernels(  # type: ignore[no-untyped-def]
    x, squares, centres, centre_squares, first, q, flat, bits, mantissas, mantissa_bits, exponents
):
    """Fill `q` (4, LANES) with q log2(q) of the squared distances from four centres on.

    q = |x|^2 + |c|^2 - 2 x.c, and `centres` holds -2 c. Exponent and mantissa of q are taken apart
    as integers: `flat` and `bits` are views of `q`, and `mantissa_bits` is one of `mantissas`. All
    of shape (4 LANES,), and made by the caller: views made here would be counted for each call.
    """
    for i in range(4):
        for j in range(LANES):
            q[i, j] = squares[j] + centre_squares[first + i]
    _add_product(centres, first, x, q)
    for i in range(4 * LANES):
        bits[i] = max(bits[i], _NOTHING)  # rounding may leave q a little below 0
        # Back to 32 bits at each step: in Python's arithmetic they would be 64.
        above = np.int32(bits[i] - _SQRT_HALF_BITS)
        exponent = np.int32(above >> _MANTISSA)
        mantissa_bits[i] = np.int32(bits[i] - np.int32(exponent << _MANTISSA))
        exponents[i] = np.float32(exponent)
    for i in range(4 * LANES):
        f = mantissas[i] - _ONE
        p = _P4 + f * (_P5 + f * (_P6 + f * (_P7 + f * _P8)))
        p = _P0 + f * (_P1 + f * (_P2 + f * (_P3 + f * p)))
        flat[i] *= exponents[i] + f * p


@written_in
def _compare(  # type: ignore[no-untyped-def]
    pairs, first, stop, shift, centres, centre_squares, weights, tail, wanted, totals
):
    """Fill `totals` from `first` to `stop`, at most LANES further; see `evolve`."""
    n, d, d_pad = centres.shape[0], shift.shape[0], centres.shape[1]
    # All of one kind, and filled here: numba compiles room and zeros for each kind anew.
    x, phi = np.empty((2 * d_pad, LANES), np.float32), np.empty((n, LANES), np.float32)
    q, y = np.empty((4, LANES), np.float32), np.empty((4, LANES), np.float32)
    parts, sums = np.empty((2, 4 * LANES), np.float32), np.empty((2, LANES), np.float32)
    squares, total = sums[0], sums[1]
    flat, mantissas, exponents = q.reshape(4 * LANES), parts[0], parts[1]
    bits, mantissa_bits = flat.view(np.int32), mantissas.view(np.int32)
    for k in range(2 * d_pad):
        for j in range(LANES):
            x[k, j] = _ZERO
    for j in range(LANES):
        total[j] = _ZERO
    for half in range(2):
        own = x[half * d_pad : (half + 1) * d_pad]
        _load(pairs, first, stop, half * d, shift, own, squares)
        for i in range(0, n, 4):
            _four_kernels(
                own,
                squares,
                centres,
                centre_squares,
                i,
                q,
                flat,
                bits,
                mantissas,
                mantissa_bits,
                exponents,
            )
            for k in range(4):
                for j in range(LANES):
                    phi[i + k, j] = q[k, j] if half == 0 else phi[i + k, j] - q[k, j]
    for k in range(d_pad):
        for j in range(LANES):
            x[k, j] -= x[d_pad + k, j]
    for row in range(0, weights.shape[0], 4):
        for k in range(4):
            for j in range(LANES):
                y[k, j] = _ZERO
        _add_product(weights, row, phi, y)
        _add_product(tail, row, x[:d_pad], y)
        for k in range(4):
            for j in range(LANES):
                total[j] += wanted[row + k] * abs(y[k, j])
    for j in range(stop - first):
        totals[first + j] = total[j]


@inline
def _wait(counters, n_done, patience):  # type: ignore[no-untyped-def]
    """Wait until `n_done` blocks are done; send the helpers away after `patience` looks."""
    looks = 0
    while fetch(counters, DONE) < n_done:
        looks += 1
        if looks == patience:
            fetch_add(counters, LEAVE)


@kernel
def evolve(
    populations: FloatArray,
    values: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    cumulative: FloatArray,
    starts: IntArray,
    n_elite: int,
    n_crossover: int,
    alpha: float,
    exponents: FloatArray,
    probability: float,
    seed: int,
    generation: int,
    best: FloatArray,
    shift: FloatArray,
    centres: SingleArray,
    centre_squares: SingleArray,
    weights: SingleArray,
    tail: SingleArray,
    wanted: SingleArray,
    counters: IntArray,
    leads: bool,
) -> None:
    """Breed and evaluate ``len(exponents)`` generations, alone or with other threads that call too.

    The value of a pair is sum_j wanted_j |y_j(x_1) - y_j(x_2)|. Only the difference is needed, so
    the spline is contracted once a pair and the constants drop out.

    The children of a generation are split into blocks of LANES. A thread draws a ticket for each
    block that it takes on, in order; a generation begins when all blocks of the one before are
    done. So nobody waits for a thread that has not come, only for one that is at work; and if one
    is so slow that it must have lost its core, the others than the leader leave.

    Parameters
    ----------
    populations, values : ndarray, shapes (2, pop_size, 2 d) and (2, pop_size)
        Generations in turn; the first is ``populations[0]``. With no `exponents`, shapes
        (1, pop_size, 2 d) and (1, pop_size): it is evaluated, and that is all.
    shift : ndarray, shape (d,)
        A point amid the centres: distances are taken from there, so that few digits cancel.
    centres, centre_squares : ndarray, shapes (n, d') and (n,)
        -2 (c - shift) and |c - shift|^2.
    weights, tail, wanted : ndarray, shapes (m, n), (m, d') and (m,)
        The spline's weights of q log2(q), its linear tail, and the outputs' weights. Rows and
        columns of all are padded to multiples of 4.
    best : ndarray, shape (n_generations,)
        Filled with the best value of each generation but the last.
    counters : ndarray of int, shape (N_COUNTERS,)
        Zeros, shared by the threads.
    leads : bool
        Whether this thread stays to the end.
    """
    pop_size, n_generations = populations.shape[1], exponents.shape[0]
    n_kept = n_elite if n_generations > 0 else 0
    order, spare = np.empty(pop_size, dtype=np.int64), np.empty(pop_size, dtype=np.int64)
    n_blocks = (pop_size - n_kept + LANES - 1) // LANES
    n_tickets = n_blocks * max(n_generations, 1)
    ranked, patience = -1, PATIENCE * centres.size
    ticket = fetch_add(counters, TICKET)
    while ticket < n_tickets:
        step, block = ticket // n_blocks, ticket % n_blocks
        first = n_kept + block * LANES
        stop = min(first + LANES, pop_size)
        old, new = step % 2, (step + 1) % 2 if n_generations > 0 else 0
        if n_generations > 0:
            if step != ranked:
                _wait(counters, step * n_blocks, patience)
                breeding.rank(values[old], order, spare)
                ranked = step
            if block == 0:
                best[step] = values[old, order[0]]
                for i in range(n_elite):
                    values[new, i] = values[old, order[i]]
            breeding.breed(
                populations[old],
                order,
                cumulative,
                starts,
                lower,
                upper,
                n_elite,
                n_crossover,
                alpha,
                exponents[step],
                probability,
                seed,
                generation + 1 + step,
                first if block > 0 else 0,
                stop,
                populations[new],
            )
        _compare(
            populations[new],
            first,
            stop,
            shift,
            centres,
            centre_squares,
            weights,
            tail,
            wanted,
            values[new],
        )
        fetch_add(counters, DONE)
        if not leads and fetch(counters, LEAVE) > 0:
            return
        ticket = fetch_add(counters, TICKET)
    if leads:
        _wait(counters, n_tickets, patience)

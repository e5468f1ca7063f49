"""Compiled evaluation of a thin-plate spline with a linear tail, many points abreast.

A spline with centres c_i maps a point x in d dimensions to m values::

    y_j(x) = sum_i w_ij q_i log(q_i) + sum_k b_kj x_k + a_j,    q_i = |x - c_i|^2

(the half of r^2 log r = q log(q) / 2 is folded into w). Inner loops run over a block of points of
compile-time length; each handles two centres (or two values) and four terms at once, so centres and
dimensions are padded to a multiple of 4 and values to a multiple of 2, all with weight 0. No BLAS
takes part and no lane looks at another, so a point's value does not depend on the batch it is
computed in.
"""

import numpy as np
from numpy.typing import NDArray

from kneecore._jit import inline, kernel

FloatArray = NDArray[np.float64]

# log(1 + f) = f + f^2 P(f) for sqrt(1/2) <= 1 + f < sqrt(2), Chebyshev nodes; error 3e-16.
_L0, _L1, _L2 = -0.49999999999999833, 0.3333333333333285, -0.2500000000022147
_L3, _L4, _L5 = 0.20000000000466495, -0.16666666618490816, 0.14285714172623884
_L6, _L7, _L8 = -0.12500003956286007, 0.111111220155228, -0.09999843911504927
_L9, _L10, _L11 = 0.09090397053862845, -0.08336500776029371, 0.0770509701696896
_L12, _L13, _L14 = -0.07112464720648483, 0.06495252735766224, -0.0630658816887405
_L15, _L16, _L17 = 0.07000691047584312, -0.06618773009678613, 0.03081756372437806
_LOG_2 = 0.6931471805599453
_SQRT_HALF_BITS = 4604544271217802189  # of the float sqrt(1/2)
_MAGIC_BITS, _MAGIC = 4843621399236968448, 6755399441055744.0  # 2^52 + 2^51: int -> float


@inline
def _log_polynomial(f):  # type: ignore[no-untyped-def]
    p = _L13 + f * (_L14 + f * (_L15 + f * (_L16 + f * _L17)))
    p = _L9 + f * (_L10 + f * (_L11 + f * (_L12 + f * p)))
    p = _L4 + f * (_L5 + f * (_L6 + f * (_L7 + f * (_L8 + f * p))))
    p = _L0 + f * (_L1 + f * (_L2 + f * (_L3 + f * p)))
    return f + f * f * p


LANES = 96
"""Points in a block: short enough for the cache, long enough that the loops cost little."""


@inline
def _clear(x):  # type: ignore[no-untyped-def]
    """Fill the lanes of padded dimensions with zeros, for good; the others are loaded over."""
    for k in range(x.shape[0]):
        for j in range(LANES):
            x[k, j] = 0.0


@inline
def load(points, first, begin, d, x):  # type: ignore[no-untyped-def]
    """Load `d` columns from `begin` of rows `first` on into the lanes of `x` (d padded, LANES)."""
    for j in range(LANES):
        row = min(first + j, points.shape[0] - 1)
        for k in range(d):
            x[k, j] = points[row, begin + k]


@inline
def _four_squares(x0, x1, x2, x3, c0, c1, c2, c3):  # type: ignore[no-untyped-def]
    d0, d1, d2, d3 = x0 - c0, x1 - c1, x2 - c2, x3 - c3
    return (d0 * d0 + d1 * d1) + (d2 * d2 + d3 * d3)


@inline
def squared_distances(x, centres, q):  # type: ignore[no-untyped-def]
    """Fill `q` (n, LANES) with the squared distances of `x` (d, LANES) from `centres` (n, d)."""
    for i in range(0, q.shape[0], 2):
        for j in range(LANES):
            q[i, j] = 0.0
            q[i + 1, j] = 0.0
        for k in range(0, x.shape[0], 4):
            a0, a1, a2, a3 = centres[i, k], centres[i, k + 1], centres[i, k + 2], centres[i, k + 3]
            m = i + 1
            b0, b1, b2, b3 = centres[m, k], centres[m, k + 1], centres[m, k + 2], centres[m, k + 3]
            for j in range(LANES):
                x0, x1, x2, x3 = x[k, j], x[k + 1, j], x[k + 2, j], x[k + 3, j]
                q[i, j] += _four_squares(x0, x1, x2, x3, a0, a1, a2, a3)
                q[i + 1, j] += _four_squares(x0, x1, x2, x3, b0, b1, b2, b3)


@inline
def _log(q, parts, log_q):  # type: ignore[no-untyped-def]
    """Fill the flat `log_q` with log(q) for positive q; 0 gives about -709.8, so 0 log(0) is 0.

    Exponent and mantissa are taken apart as integers in `parts` (2, n).
    """
    n = q.shape[0]
    q_bits, parts_bits = q.view(np.int64), parts.view(np.int64)
    for i in range(n):
        exponent = (q_bits[i] - _SQRT_HALF_BITS) >> 52
        parts_bits[0, i] = q_bits[i] - (exponent << 52)
        parts_bits[1, i] = exponent + _MAGIC_BITS
    for i in range(n):
        log_q[i] = (parts[1, i] - _MAGIC) * _LOG_2 + _log_polynomial(parts[0, i] - 1.0)


@inline
def add_product(matrix, v, y):  # type: ignore[no-untyped-def]
    """Add `matrix` (m, n) times `v` (n, LANES) to `y` (m, LANES)."""
    for r in range(0, y.shape[0], 2):
        for i in range(0, v.shape[0], 4):
            a0, a1, a2, a3 = matrix[r, i], matrix[r, i + 1], matrix[r, i + 2], matrix[r, i + 3]
            s = r + 1
            b0, b1, b2, b3 = matrix[s, i], matrix[s, i + 1], matrix[s, i + 2], matrix[s, i + 3]
            for j in range(LANES):
                v0, v1, v2, v3 = v[i, j], v[i + 1, j], v[i + 2, j], v[i + 3, j]
                y[r, j] += (a0 * v0 + a1 * v1) + (a2 * v2 + a3 * v3)
                y[r + 1, j] += (b0 * v0 + b1 * v1) + (b2 * v2 + b3 * v3)


@kernel
def evaluate(
    points: FloatArray,
    centres: FloatArray,
    weights: FloatArray,
    tail: FloatArray,
    constant: FloatArray,
    values: FloatArray,
) -> None:
    """Fill `values` (n_points, m) with the spline at `points` (n_points, d).

    Parameters
    ----------
    centres, weights, tail, constant : ndarray
        Shapes (n, d), (m, n), (m, d) and (m,), padded as the module says.
    """
    n = centres.shape[0]
    x, y = np.empty((centres.shape[1], LANES)), np.empty((weights.shape[0], LANES))
    q, log_q, parts = np.empty((n, LANES)), np.empty((n, LANES)), np.empty((2, n * LANES))
    _clear(x)
    flat_q, flat_log = q.reshape(n * LANES), log_q.reshape(n * LANES)
    for first in range(0, points.shape[0], LANES):
        load(points, first, 0, points.shape[1], x)
        squared_distances(x, centres, q)
        _log(flat_q, parts, flat_log)
        for i in range(n * LANES):
            flat_q[i] *= flat_log[i]
        for row in range(y.shape[0]):
            for j in range(LANES):
                y[row, j] = constant[row]
        add_product(weights, q, y)
        add_product(tail, x, y)
        for j in range(min(LANES, points.shape[0] - first)):
            for row in range(values.shape[1]):
                values[first + j, row] = y[row, j]


@kernel
def weighted_gradient(
    points: FloatArray,
    sums: FloatArray,
    centres: FloatArray,
    weights: FloatArray,
    tail: FloatArray,
    slopes: FloatArray,
) -> None:
    """Fill `slopes` (n_points, d) with the gradients of sum_j s_j y_j, s each point's own `sums`.

    That of y_j is sum_i 2 w_ij (log q_i + 1)(x - c_i) + b_j. The other arrays are those of
    `evaluate`.
    """
    n, d, m = centres.shape[0], centres.shape[1], sums.shape[1]
    x, g, s = np.empty((d, LANES)), np.empty((d, LANES)), np.empty((m, LANES))
    q, log_q, parts = np.empty((n, LANES)), np.empty((n, LANES)), np.empty((2, n * LANES))
    pull = np.empty(LANES)
    _clear(x)
    for first in range(0, points.shape[0], LANES):
        load(points, first, 0, points.shape[1], x)
        load(sums, first, 0, m, s)
        squared_distances(x, centres, q)
        _log(q.reshape(n * LANES), parts, log_q.reshape(n * LANES))
        for k in range(d):
            for j in range(LANES):
                g[k, j] = 0.0
            for row in range(m):
                for j in range(LANES):
                    g[k, j] += s[row, j] * tail[row, k]
        for i in range(n):
            for j in range(LANES):
                pull[j] = 0.0
            for row in range(m):
                for j in range(LANES):
                    pull[j] += s[row, j] * weights[row, i]
            for j in range(LANES):
                pull[j] *= 2.0 * (log_q[i, j] + 1.0)
            for k in range(d):
                for j in range(LANES):
                    g[k, j] += pull[j] * (x[k, j] - centres[i, k])
        for j in range(min(LANES, points.shape[0] - first)):
            for k in range(slopes.shape[1]):
                slopes[first + j, k] = g[k, j]

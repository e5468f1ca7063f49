"""A radial-basis-function surrogate: fitted by SciPy, evaluated by our own compiled kernel.

The interpolant is that of `scipy.interpolate.RBFInterpolator` with ``kernel="thin_plate_spline"``
and ``degree=1``, which Ciszkiewicz & Dumas 2024 use. With the n training points as rows, K the
matrix of r^2 log r between them and P the rows (1, x), it solves::

    [ K  P ] [ w ]   [ Y ]
    [ P' 0 ] [ a ] = [ 0 ]

Examples
--------
>>> import numpy as np
>>> from kneecore.numerics.surrogate import Surrogate
>>> points = np.random.default_rng(0).random((40, 3))
>>> surrogate = Surrogate.fit(points, points @ [[1.0], [2.0], [3.0]])
>>> bool(np.allclose(surrogate([[0.2, 0.4, 0.1]]), 1.3))  # linear functions are met exactly
True
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy  # its subpackages are loaded when they are used: the first picture needs none
from numpy.typing import ArrayLike, NDArray
from threadpoolctl import threadpool_limits

from kneecore.errors import ModelError, ParameterError
from kneecore.numerics import thin_plate

FloatArray = NDArray[np.float64]

_BLOCK = 200_000
"""Differences that are held at once: they stay in the processor's cache."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Surrogate:
    """A thin-plate spline through training points. Make one with `Surrogate.fit`."""

    points: FloatArray
    """Training points, shape (n, d)."""
    values: FloatArray
    """Training values, shape (n, m)."""
    loo_errors: FloatArray
    """Leave-one-out errors at the training points (prediction less value), shape (n, m): what the
    spline through the other points misses by. NaN where the others do not determine a spline."""
    centres: FloatArray
    weights: FloatArray
    tail: FloatArray
    constant: FloatArray
    """These four: the padded arrays of `kneecore.numerics.thin_plate`."""

    @property
    def n_dimensions(self) -> int:
        """Number of inputs d."""
        return int(self.points.shape[1])

    @property
    def n_values(self) -> int:
        """Number of outputs m."""
        return int(self.values.shape[1])

    @classmethod
    def fit(cls, points: ArrayLike, values: ArrayLike) -> Self:
        """Fit to training data.

        Parameters
        ----------
        points : array_like, shape (n, d)
            Training points, best scaled to the unit cube.
        values : array_like, shape (n, m)
            Their values.

        Raises
        ------
        ParameterError
            If there are fewer than d + 1 points (the linear tail needs that many), or if shapes or
            numbers do not fit.
        ModelError
            If the points do not determine a spline, for instance because two are the same.
        """
        x = np.ascontiguousarray(points, dtype=np.float64)
        y = np.ascontiguousarray(values, dtype=np.float64)
        if x.ndim != 2 or y.ndim != 2 or len(x) != len(y):
            raise ParameterError(
                f"`points` and `values` have shapes {x.shape} and {y.shape}; (n, d) and (n, m) "
                "are allowed"
            )
        if len(x) < x.shape[1] + 1:
            raise ParameterError(
                f"`points` has {len(x)} rows; a linear tail in {x.shape[1]} dimensions needs at "
                f"least {x.shape[1] + 1}"
            )
        if not (np.isfinite(x).all() and np.isfinite(y).all()):
            raise ParameterError("`points` or `values` has a number that is not finite")
        # One BLAS thread: with more, the last bits depend on how many there are.
        with threadpool_limits(limits=1, user_api="blas"):
            weights, tail, constant = _fit_scipy(x, y)
            loo = _leave_one_out(x, weights)
        n_pad, d_pad, m_pad = (
            -(-size // k) * k for size, k in ((len(x), 4), (x.shape[1], 4), (y.shape[1], 2))
        )
        return cls(
            points=x,
            values=y,
            loo_errors=loo,
            centres=_padded(x, n_pad, d_pad),
            weights=_padded(0.5 * weights.T, m_pad, n_pad),
            tail=_padded(tail.T, m_pad, d_pad),
            constant=_padded(constant[None], 1, m_pad)[0],
        )

    def __call__(self, points: ArrayLike) -> FloatArray:
        """Return the values at `points`, shape (n, d) -> (n, m)."""
        x = self._checked(points)
        values = np.empty((len(x), self.n_values))
        thin_plate.evaluate(x, self.centres, self.weights, self.tail, self.constant, values)
        return values

    def gradient(self, points: ArrayLike) -> FloatArray:
        """Return the derivatives dy_j/dx_k at `points`, shape (n, d) -> (n, m, d)."""
        x = self._checked(points)
        slopes = np.empty((len(x), self.n_values, self.n_dimensions))
        for j in range(self.n_values):
            one = np.zeros((len(x), self.n_values))
            one[:, j] = 1.0
            slopes[:, j] = self.weighted_gradient(x, one)
        return slopes

    def weighted_gradient(self, points: ArrayLike, sums: ArrayLike) -> FloatArray:
        """Return the gradients of sum_j s_j y_j at `points`, shape (n, d) -> (n, d).

        `sums`, shape (n, m), has each point's own s.
        """
        x = self._checked(points)
        s = np.ascontiguousarray(sums, dtype=np.float64)
        if s.shape != (len(x), self.n_values):
            raise ParameterError(
                f"`sums` has shape {s.shape}; ({len(x)}, {self.n_values}) is allowed"
            )
        slopes = np.empty(x.shape)
        thin_plate.weighted_gradient(x, s, self.centres, self.weights, self.tail, slopes)
        return slopes

    def _checked(self, points: ArrayLike) -> FloatArray:
        x = np.ascontiguousarray(points, dtype=np.float64)
        if x.ndim != 2 or x.shape[1] != self.n_dimensions:
            raise ParameterError(
                f"`points` has shape {x.shape}; (n, {self.n_dimensions}) is allowed"
            )
        return x


def _padded(matrix: FloatArray, n_rows: int, n_columns: int) -> FloatArray:
    full = np.zeros((n_rows, n_columns))
    full[: matrix.shape[0], : matrix.shape[1]] = matrix
    return full


def _fit_scipy(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return weights (n, m), tail (d, m) and constant (m,) of SciPy's interpolant.

    SciPy keeps the coefficients, and the shift and scale of its monomials, under private names
    only. That our kernel then gives SciPy's values is checked in the tests.
    """
    try:
        fitted = scipy.interpolate.RBFInterpolator(x, y, kernel="thin_plate_spline", degree=1)
    except np.linalg.LinAlgError as error:
        raise ModelError(f"the training points do not determine a surrogate: {error}") from None
    n = len(x)
    shift, scale = np.asarray(fitted._shift), np.asarray(fitted._scale)
    tail = np.zeros((x.shape[1], y.shape[1]))
    constant = np.zeros(y.shape[1])
    for powers, row in zip(np.asarray(fitted.powers), fitted._coeffs[n:], strict=True):
        if powers.any():
            k = int(np.argmax(powers))
            tail[k] = row / scale[k]
            constant -= tail[k] * shift[k]
        else:
            constant += row
    return np.array(fitted._coeffs[:n]), tail, constant


def _squared_distances(x: FloatArray) -> FloatArray:
    """Return the squared distances between points (n, d), shape (n, n).

    A few rows at a time: all differences at once, (n, n, d), would be gigabytes for a thousand
    points of hundreds of inputs. The rows do not know of each other, so the bits stay the same.
    """
    n, d = x.shape
    rows = max(1, _BLOCK // (n * d))
    q = np.empty((n, n))
    for first in range(0, n, rows):
        q[first : first + rows] = ((x[first : first + rows, None] - x) ** 2).sum(axis=2)
    return q


def _leave_one_out(x: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the leave-one-out errors without refitting: minus w_i over the inverse's diagonal.

    Rippa 1999 (Adv. Comput. Math. 11:193-210), with the tail's rows in the matrix.
    """
    n, d = x.shape
    q = _squared_distances(x)
    matrix = np.zeros((n + d + 1, n + d + 1))
    matrix[:n, :n] = 0.5 * q * np.log(np.where(q > 0.0, q, 1.0))
    matrix[:n, n] = matrix[n, :n] = 1.0
    matrix[:n, n + 1 :] = x - x.mean(axis=0)
    matrix[n + 1 :, :n] = matrix[:n, n + 1 :].T
    if n <= d + 1:
        return np.full(weights.shape, np.nan)
    diagonal = np.diagonal(np.linalg.inv(matrix))[:n]
    errors: FloatArray = -weights / diagonal[:, None]
    return errors

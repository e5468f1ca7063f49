"""A surrogate of one number that knows how unsure it is, and which inputs count.

A Gaussian process with Matern's covariance for nu = 5/2 and a length for each input (Rasmussen &
Williams 2006, Gaussian Processes for Machine Learning, sections 4.2 and 5.4)::

    k(x, x') = s^2 (1 + a r + a^2 r^2 / 3) exp(-a r),   r^2 = sum_k ((x_k - x'_k) / l_k)^2,  a^2 = 5

with a nugget on its diagonal. `likely` finds the lengths and the nugget; mean and s follow from
them. An input without effect gets a long length, so that the few which count are found among many.

Examples
--------
>>> import numpy as np
>>> from kneecore.numerics.kriging import Kriging, likely
>>> points = np.random.default_rng(0).random((40, 3))
>>> values = np.sin(6.0 * points[:, 0])
>>> process = Kriging(points, values, likely(points, values))
>>> bool(process.lengths[0] < 0.1 * process.lengths[1])  # the others have no effect
True
"""

import math

import numpy as np
import scipy  # its subpackages are loaded when they are used
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

__all__ = ["Kriging", "likely"]

FloatArray = NDArray[np.float64]

_ROOT_5 = math.sqrt(5.0)
_LENGTHS = (0.02, 50.0)  # of the cube's width
_NUGGETS = (1e-8, 0.5)  # of the process's variance
_USUAL_LENGTH, _SPREAD = 1.5, 1.5  # the prior's median, and the sd of its logarithm
_NUGGET_COST = 0.3  # of the likelihood's logarithm, for a factor e in the nugget
_STEPS = 60  # of the optimiser
_MOST = 300  # points that the likelihood looks at: its cost rises with their cube


def likely(points: FloatArray, values: FloatArray, start: FloatArray | None = None) -> FloatArray:
    """Return the logarithms of the most likely lengths and nugget, shape (d + 1,).

    That is for the likelihood with a weak prior for long lengths and a small nugget.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        In the unit cube; of more than some hundreds, evenly picked ones are looked at.
    values : ndarray, shape (n,)
        Not all the same.
    start : ndarray, shape (d + 1,), optional
        Where to begin to look, such as what was found for fewer points.
    """
    n, d = points.shape
    picked = np.linspace(0, n - 1, min(n, _MOST)).round().astype(int)
    points, z = points[picked], _scaled(values[picked])[0]
    if start is None:
        start = np.append(np.full(d, math.log(0.4 * math.sqrt(d))), math.log(1e-4))
    with threadpool_limits(limits=1, user_api="blas"):
        found = scipy.optimize.minimize(
            _loss,
            start,
            args=(points, z),
            jac=True,
            method="L-BFGS-B",
            bounds=[tuple(np.log(_LENGTHS))] * d + [tuple(np.log(_NUGGETS))],
            options={"maxiter": _STEPS},
        )
    theta: FloatArray = found.x
    return theta


class Kriging:
    """A Gaussian process through points.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        In the unit cube.
    values : ndarray, shape (n,)
        Not all the same.
    theta : ndarray, shape (d + 1,)
        From `likely`.
    """

    def __init__(self, points: FloatArray, values: FloatArray, theta: FloatArray) -> None:
        self.lengths, self.nugget = np.exp(theta[:-1]), math.exp(theta[-1])
        z, self._shift, self._scale = _scaled(values)
        self._scaled_points = points / self.lengths
        with threadpool_limits(limits=1, user_api="blas"):
            r = _distances(self._scaled_points)
            while True:  # close points ask for more of a nugget than others
                try:
                    self._solved = _Solved(_matern(r)[0], z, self.nugget)
                    break
                except np.linalg.LinAlgError:
                    self.nugget *= 10.0

    def __call__(self, u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return means and standard deviations at points (n, d), (n,), and their gradients (n, d).

        The deviation is that of the model itself, without the nugget.
        """
        solved, scaled = self._solved, u / self.lengths
        k, bend = _matern(scipy.spatial.distance.cdist(scaled, self._scaled_points))
        with threadpool_limits(limits=1, user_api="blas"):
            pulled = solved.by(k.T).T
            slope = self._uphill(bend * solved.pulls, scaled)
            sd_slope = -self._uphill(bend * pulled, scaled)
            mean = solved.mean + k @ solved.pulls
        rest = np.maximum(1.0 - (k * pulled).sum(axis=1), 1e-12)
        sd = np.sqrt(solved.variance * rest)
        sd_slope *= (solved.variance / sd)[:, None]
        size = self._scale
        return self._shift + size * mean, size * sd, size * slope, size * sd_slope

    def _uphill(self, weights: FloatArray, scaled: FloatArray) -> FloatArray:
        """Return the sums over the points of weights (n, n_points) times the way to them."""
        ways = weights @ self._scaled_points - weights.sum(axis=1)[:, None] * scaled
        return ways / self.lengths  # type: ignore[no-any-return]

    @property
    def loo_errors(self) -> FloatArray:
        """Leave-one-out errors at the points, prediction less value, shape (n,)."""
        solved = self._solved
        errors: FloatArray = -self._scale * solved.pulls / np.diagonal(solved.inverse())
        return errors


class _Solved:
    """Mean, variance and weights for given correlations."""

    def __init__(self, k: FloatArray, z: FloatArray, nugget: float) -> None:
        k = k + nugget * np.eye(len(z))
        self.factor = scipy.linalg.cholesky(k, lower=True)
        ones = self.by(np.ones(len(z)))
        self.mean = float(z @ ones) / float(ones.sum())
        self.pulls = self.by(z - self.mean)
        self.variance = max(float((z - self.mean) @ self.pulls) / len(z), 1e-12)

    def by(self, right: FloatArray) -> FloatArray:
        """Return the inverse correlations times `right`."""
        product: FloatArray = scipy.linalg.cho_solve((self.factor, True), right)
        return product

    def inverse(self) -> FloatArray:
        return self.by(np.eye(len(self.factor)))


def _scaled(values: FloatArray) -> tuple[FloatArray, float, float]:
    """Return values within 0 and 1, and what takes them back: even huge ones have squares."""
    shift = float(values.min())
    scale = float(values.max() - shift)
    return (values - shift) / scale, shift, scale


def _distances(points: FloatArray) -> FloatArray:
    distances: FloatArray = scipy.spatial.distance.squareform(scipy.spatial.distance.pdist(points))
    return distances


def _matern(r: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the correlations at distances r, and minus their derivatives by r, over r."""
    decay = np.exp(-_ROOT_5 * r)
    bend = 5.0 / 3.0 * (1.0 + _ROOT_5 * r) * decay
    return (1.0 + _ROOT_5 * r + 5.0 / 3.0 * r * r) * decay, bend


def _loss(theta: FloatArray, points: FloatArray, z: FloatArray) -> tuple[float, FloatArray]:
    """Return minus the logarithm of the posterior of lengths and nugget, and its gradient."""
    scaled, nugget = points / np.exp(theta[:-1]), math.exp(theta[-1])
    k, bend = _matern(_distances(scaled))
    try:
        solved = _Solved(k, z, nugget)
    except np.linalg.LinAlgError:
        return 1e10, np.zeros(len(theta))
    variance, factor = solved.variance, solved.factor
    inner = solved.inverse() - np.outer(solved.pulls, solved.pulls) / variance
    weighed = inner * bend  # the loss changes by half the trace of inner dk
    by_length = weighed.sum(axis=1) @ scaled**2 - (scaled * (weighed @ scaled)).sum(axis=0)
    by_nugget = 0.5 * nugget * float(np.trace(inner))
    off = (theta[:-1] - math.log(_USUAL_LENGTH)) / _SPREAD
    loss = 0.5 * len(z) * math.log(variance) + float(np.log(np.diagonal(factor)).sum())
    loss += 0.5 * float((off**2).sum()) + _NUGGET_COST * theta[-1]
    return loss, np.append(by_length + off / _SPREAD, by_nugget + _NUGGET_COST)

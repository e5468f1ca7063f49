"""Weighted sums of the angles at rest with their exact gradients, for many knees at once."""

import numpy as np
from numpy.typing import NDArray

from kneecore._threads import run_all, thread_count
from kneecore.knee.gradient import weighted_gradients
from kneecore.knee.physics.dynamics import flexion_of
from kneecore.knee.physics.equilibrium import equilibria
from kneecore.knee.response import RestLength, prepare
from kneecore.knee.space import ParameterSpace

__all__ = ["settled_slopes"]

FloatArray = NDArray[np.float64]


def settled_slopes(
    space: ParameterSpace,
    rest_length: RestLength,
    threads: int | None,
    u: FloatArray,
    weights: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return sum w y, its gradient and y of knees in equilibrium, in deg.

    Parameters
    ----------
    space, rest_length, threads
        As for `kneecore.Knee`.
    u : ndarray, shape (n, n_free)
        Points of the free parameters' unit cube.
    weights : ndarray, shape (n, 12)

    Returns
    -------
    tuple of ndarray
        Shapes (n,), (n, n_free), (n, 12); minus infinity where a knee has lost its equilibrium.
    """
    x = space.from_free_unit(u)
    rows = prepare(x, space.baseline, rest_length)
    poses, _ = equilibria(rows, threads)
    gradients = np.empty((len(x), 1, x.shape[1]))
    fixed = rest_length == "fixed"
    baseline = space.baseline.copy()  # a read-only array would be compiled for once more
    each = np.ascontiguousarray(weights[:, None, :])
    size = max(64, -(-len(x) // (2 * thread_count(threads))))

    def work(first: int) -> None:
        k = slice(first, first + size)
        weighted_gradients(x[k], rows[k], poses[k], baseline, fixed, each[k], gradients[k])

    run_all(work, range(0, len(x), size), threads)
    y = np.degrees(flexion_of(poses))
    values = (weights * y).sum(axis=1)
    width = np.degrees(space.upper - space.lower)[space.free]
    slopes = np.where(np.isnan(gradients[:, 0]), 0.0, gradients[:, 0])[:, space.free] * width
    return np.where(np.isnan(values), -np.inf, values), slopes, y

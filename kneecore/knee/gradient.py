"""Exact derivatives of the 12 equilibrium angles with respect to the 28 parameters.

In equilibrium the potential's gradient g(z; p) in the pose z = (x, y, psi) vanishes, so by the
implicit function theorem dz/dp = -H^-1 dg/dp with the Hessian H. Only psi is wanted: with w the
solution of H w = (0, 0, 1), dpsi/dp = -w . dg/dp, and w . g is the change of the potential along w,
a sum over the ligaments and the contact that is derived once by the constants of the kernels. The
derivatives of those constants, with the load-free pose and the rest lengths that move with the
parameters, are in `physics.pose.pull_back`. The flexion angle is THETA_0 - psi.

Examples
--------
>>> import numpy as np
>>> from kneecore import NAMES, ParameterSpace, flexion_gradient
>>> by_parameter = flexion_gradient(ParameterSpace().baseline)
>>> by_parameter.shape
(12, 28)
>>> slope = by_parameter[5, NAMES.index("plateau_slope")]  # deg per deg, at 5 N m of extension
>>> np.round(slope, 2)
np.float64(1.01)
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._jit import inline, inner, kernel
from kneecore._threads import run_all, thread_count
from kneecore.knee.file import packaged_knee
from kneecore.knee.parameters import check_physical
from kneecore.knee.physics.equilibrium import equilibria
from kneecore.knee.physics.forces import sin_cos
from kneecore.knee.physics.pose import N_CONSTANTS, baseline_origin, pull_back
from kneecore.knee.physics.potential import all_terms
from kneecore.knee.response import RestLength, prepare

__all__ = ["flexion_gradient"]

FloatArray = NDArray[np.float64]


@inner
def _answer(row: FloatArray, pose: FloatArray, h: FloatArray) -> tuple[float, float, float]:
    """Return dx/dM, dy/dM and dpsi/dM in an equilibrium: the solution of H w = (0, 0, 1).

    `h` (10,) is room for the Hessian.
    """
    all_terms(row, pose[0], pose[1], pose[2], h)
    l21, l31 = h[5] / h[4], h[7] / h[4]
    d2 = h[6] - l21 * h[5]
    m32 = h[8] - l31 * h[5]
    l32 = m32 / d2
    wp = 1.0 / (h[9] - l31 * h[7] - l32 * m32)
    wy = -l32 * wp
    return -l21 * wy - l31 * wp, wy, wp


@inline
def _ligament(row, i, x, y, s, c, wx, wy, wp, weight, b):  # type: ignore[no-untyped-def]
    """Add `weight` times the derivatives of k e^2 (dl along w) by the ligament's constants."""
    k = row[i + 4]
    ax = c * row[i + 2] - s * row[i + 3]
    ay = s * row[i + 2] + c * row[i + 3]
    dx, dy = row[i] - x - ax, row[i + 1] - y - ay
    length = math.sqrt(dx * dx + dy * dy)
    e = length - row[i + 5]
    if e <= 0.0:
        return
    ux, uy = dx / length, dy / length
    vx, vy = ay * wp - wx, -ax * wp - wy  # how the vector between the attachments changes along w
    stretch = ux * vx + uy * vy
    pull, stiff = weight * k * e * e, weight * 2.0 * k * e * stretch
    px = stiff * ux + pull * (vx - stretch * ux) / length
    py = stiff * uy + pull * (vy - stretch * uy) / length
    arm_x, arm_y = -px - pull * wp * uy, -py + pull * wp * ux
    b[i] += px
    b[i + 1] += py
    b[i + 2] += c * arm_x + s * arm_y
    b[i + 3] += c * arm_y - s * arm_x
    b[i + 4] += weight * e * e * stretch
    b[i + 5] -= stiff


@inline
def _contact(row, x, y, s, c, wx, wy, wp, weight, b):  # type: ignore[no-untyped-def]
    """Add `weight` times the derivatives of K delta^1.5 (d delta along w) by the constants."""
    ex, ey = row[24] - x, row[25] - y
    nx, ny = c * row[28] - s * row[29], s * row[28] + c * row[29]
    delta = row[26] - (nx * ex + ny * ey - row[27])
    if delta <= 0.0:
        return
    vx, vy = wx - ey * wp, wy + ex * wp
    sink = nx * vx + ny * vy
    root = math.sqrt(delta)
    push = weight * row[30] * delta * root
    stiff = weight * 1.5 * row[30] * root * sink
    by_nx, by_ny = push * vx - stiff * ex, push * vy - stiff * ey
    b[24] += push * wp * ny - stiff * nx
    b[25] -= push * wp * nx + stiff * ny
    b[26] += stiff
    b[27] += stiff
    b[28] += c * by_nx + s * by_ny
    b[29] += c * by_ny - s * by_nx
    b[30] += weight * delta * root * sink


@inner
def _add(
    row: FloatArray, pose: FloatArray, weight: float, h: FloatArray, by_constant: FloatArray
) -> None:
    """Add `weight` times the derivatives of a flexion angle by the knee's constants."""
    wx, wy, wp = _answer(row, pose, h)
    x, y = pose[0], pose[1]
    s, c = sin_cos(pose[2])
    for i in range(0, 24, 6):
        _ligament(row, i, x, y, s, c, wx, wy, wp, weight, by_constant)
    _contact(row, x, y, s, c, wx, wy, wp, weight, by_constant)


@kernel
def weighted_gradients(
    X: FloatArray,
    rows: FloatArray,
    poses: FloatArray,
    baseline: FloatArray,
    fixed: bool,
    weights: FloatArray,
    gradients: FloatArray,
) -> None:
    """Fill `gradients` (n, q, 28) with the derivatives of q weighted sums of the angles.

    Parameters
    ----------
    X : ndarray, shape (n, 28)
    rows : ndarray, shape (n, 36)
        Their constants.
    poses : ndarray, shape (n, 12, 3)
        Their equilibria; NaN gives NaN.
    baseline : ndarray, shape (28,)
    fixed : bool
        Whether the rest lengths are the baseline's.
    weights : ndarray, shape (n or 1, q, 12)
        One row for all knees, or one for each.
    gradients : ndarray, shape (n, q, 28)
        rad per SI unit.
    """
    origin_x, origin_y = baseline_origin(baseline)
    by_constant, h = np.empty(N_CONSTANTS), np.empty(10)
    for m in range(X.shape[0]):
        w = weights[m % weights.shape[0]]
        for q in range(w.shape[0]):
            by_constant[:] = 0.0
            for k in range(w.shape[1]):
                if w[q, k] != 0.0:
                    _add(rows[m], poses[m, k], w[q, k], h, by_constant)
            pull_back(X[m], rows[m], origin_x, origin_y, fixed, by_constant, gradients[m, q])
            if not np.isfinite(poses[m, 0, 2]):
                gradients[m, q] = np.nan


def flexion_gradient(
    x: ArrayLike,
    *,
    baseline: ArrayLike | None = None,
    rest_length: RestLength = "recomputed",
    threads: int | None = None,
) -> FloatArray:
    """Return the derivatives of a knee's 12 angles at rest with respect to its 28 parameters.

    Parameters
    ----------
    x : array_like, shape (28,) or (n, 28)
        Parameter values, SI; 32 with the changes of the rest lengths.
    baseline, rest_length, threads
        As for `simulate_batch`.

    Returns
    -------
    ndarray, shape (12, 28) or (n, 12, 28)
        rad per SI unit (32 columns for knees of 32 entries); NaN for a knee that has lost its
        equilibrium at some load.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    models = check_physical(x, "x")
    many = np.atleast_2d(models)
    rows = prepare(many, baseline, rest_length, "x")
    centre = check_physical(packaged_knee().baseline if baseline is None else baseline, "baseline")
    poses, _ = equilibria(rows, threads)
    n_loads = poses.shape[1]
    gradients = np.empty((len(many), n_loads, many.shape[1]))
    each = np.eye(n_loads)[None]
    size = max(16, -(-len(many) // (4 * thread_count(threads))))

    def work(first: int) -> None:
        part = slice(first, first + size)
        weighted_gradients(
            many[part],
            rows[part],
            poses[part],
            centre,
            rest_length == "fixed",
            each,
            gradients[part],
        )

    run_all(work, range(0, len(many), size), threads)
    return gradients[0] if models.ndim == 1 else gradients

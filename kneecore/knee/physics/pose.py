"""The load-free pose and the rest lengths of a knee, and its row of constants for the kernels.

Load-free pose (the reconstruction's rule): the flexion is 54.79 deg, and the *baseline* knee's
circle touches its line 8.1 mm behind the plateau point. A perturbed knee keeps that angle and that
tibia, which then moves along its own plateau's normal until its own circle just touches its own
line. Rest lengths are the distances between the attachments in that pose (``recomputed``) or those
of the baseline (``fixed``), and what a knee of 32 entries adds to them.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore._jit import inline, inner, kernel
from kneecore.errors import ParameterError
from kneecore.knee.parameters import REST_LENGTH_NAMES
from kneecore.knee.physics.forces import MASS_CENTRE_Y, THETA_0, contact_stiffness

STATION = -0.0081
"""Where the baseline's circle touches its line in the load-free pose, along the line, m."""
CHANGES = 28
"""First entry of a knee that changes a rest length, if it has 32."""
_COS, _SIN = math.cos(THETA_0), -math.sin(THETA_0)  # of the tibia's turn phi = -THETA_0

# Columns of a row of constants. Ligament i holds columns 6 i to 6 i + 5: femoral attachment (x, y),
# arm from the mass centre to the tibial attachment (x, y), stiffness, rest length.
REST = 5
# Where each ligament's begin. Not literals: numba would compile its callees for each anew.
ACL, PCL, MCL, LCL = np.int64(0), np.int64(6), np.int64(12), np.int64(18)
CENTRE_X, CENTRE_Y, RADIUS, LINE_OFFSET, NORMAL_X, NORMAL_Y, CONTACT_K, POINT_OFFSET = range(24, 32)
START_X, START_Y, ORIGIN_X, ORIGIN_Y = range(32, 36)
N_CONSTANTS = 36

FloatArray = NDArray[np.float64]


@inline
def _turned(x, y):  # type: ignore[no-untyped-def]
    """Return a tibia vector as it lies in the load-free pose."""
    return _COS * x - _SIN * y, _SIN * x + _COS * y


@kernel
def baseline_origin(baseline: FloatArray) -> tuple[float, float]:
    """Return the tibia's origin in the femur frame for the baseline's load-free pose, m."""
    slope = baseline[21]
    tx, ty = math.cos(slope), math.sin(slope)
    centre_x = baseline[19] + STATION * tx - baseline[18] * ty
    centre_y = baseline[20] + STATION * ty + baseline[18] * tx
    wx, wy = _turned(centre_x, centre_y)
    return baseline[16] - wx, baseline[17] - wy


@inner
def _load_free_row(x: FloatArray, origin_x: float, origin_y: float, row: FloatArray) -> None:
    """Fill `row` for the knee `x` (28 or 32), with its own rest lengths, not yet changed."""
    slope = x[21]
    nx, ny = _turned(-math.sin(slope), math.cos(slope))
    px, py = _turned(x[19], x[20])
    # The tibia moves along its plateau's normal by what the circle is away from touching.
    gap = nx * (x[16] - origin_x - px) + ny * (x[17] - origin_y - py) - x[18]
    ox, oy = origin_x + gap * nx, origin_y + gap * ny
    gx, gy = _turned(0.0, MASS_CENTRE_Y)
    mass_x, mass_y = ox + gx, oy + gy
    for i in range(4):
        arm_x, arm_y = _turned(x[4 * i + 2], x[4 * i + 3] - MASS_CENTRE_Y)
        row[6 * i] = x[4 * i]
        row[6 * i + 1] = x[4 * i + 1]
        row[6 * i + 2] = arm_x
        row[6 * i + 3] = arm_y
        row[6 * i + 4] = x[22 + i]
        dx = x[4 * i] - mass_x - arm_x
        dy = x[4 * i + 1] - mass_y - arm_y
        row[6 * i + REST] = math.sqrt(dx * dx + dy * dy)
    row[CENTRE_X] = x[16]
    row[CENTRE_Y] = x[17]
    row[RADIUS] = x[18]
    row[LINE_OFFSET] = nx * (px - gx) + ny * (py - gy)
    row[NORMAL_X] = nx
    row[NORMAL_Y] = ny
    row[CONTACT_K] = contact_stiffness(x[18], x[26], x[27])
    row[POINT_OFFSET] = ny * (px - gx) - nx * (py - gy)  # along t = (n_y, -n_x)
    row[START_X] = mass_x
    row[START_Y] = mass_y
    row[ORIGIN_X] = ox
    row[ORIGIN_Y] = oy


@kernel
def _fill(models: FloatArray, baseline: FloatArray, fixed: bool, rows: FloatArray) -> None:
    origin_x, origin_y = baseline_origin(baseline)
    own = np.empty(N_CONSTANTS)
    _load_free_row(baseline, origin_x, origin_y, own)
    for m in range(models.shape[0]):
        _load_free_row(models[m], origin_x, origin_y, rows[m])
        for i in range(4):
            if fixed:
                rows[m, 6 * i + REST] = own[6 * i + REST]
            if models.shape[1] > CHANGES:
                rows[m, 6 * i + REST] += models[m, CHANGES + i]


def constants(models: FloatArray, baseline: FloatArray, fixed: bool) -> FloatArray:
    """Return the kernels' constants of each model.

    Parameters
    ----------
    models : ndarray, shape (n, 28) or (n, 32)
        Checked parameter values, SI.
    baseline : ndarray, shape (28,) or (32,)
        The knee that fixes the load-free pose; changes of its rest lengths are not looked at.
    fixed : bool
        Whether all models have the baseline's rest lengths.

    Returns
    -------
    ndarray, shape (n, 36)

    Raises
    ------
    ParameterError
        If a change leaves a rest length that is not above 0.
    """
    rows = np.empty((len(models), N_CONSTANTS))
    _fill(models, baseline, fixed, rows)
    if models.shape[1] > CHANGES and (lengths := rest_lengths(rows)).min(initial=1.0) <= 0.0:
        model, ligament = np.unravel_index(int(np.argmin(lengths)), lengths.shape)
        change = models[model, CHANGES + ligament]
        raise ParameterError(
            f"`{REST_LENGTH_NAMES[ligament]}` is {1e3 * change:.6g} mm; more than "
            f"{1e3 * (change - lengths[model, ligament]):.6g} mm is allowed"
        )
    return rows


@inline
def _turned_back(x, y):  # type: ignore[no-untyped-def]
    """Return the transpose of `_turned` times a vector."""
    return _COS * x + _SIN * y, _COS * y - _SIN * x


@kernel
def pull_back(
    x: FloatArray,
    row: FloatArray,
    origin_x: float,
    origin_y: float,
    fixed: bool,
    by_constant: FloatArray,
    by_parameter: FloatArray,
) -> None:
    """Turn derivatives by a knee's constants into derivatives by its parameters.

    The transpose of the derivative of `_load_free_row`, line by line from its end.

    Parameters
    ----------
    x : ndarray, shape (28,) or (32,)
    row : ndarray, shape (36,)
        The knee's constants.
    origin_x, origin_y : float
        What `baseline_origin` returns.
    fixed : bool
        Whether the rest lengths are the baseline's, and so do not move with the pose.
    by_constant : ndarray, shape (36,)
        Derivatives by columns 0 to 30 of the row; the others are taken for zero.
    by_parameter : ndarray, shape (28,) or (32,)
        Gets the derivatives by the parameters.
    """
    slope, b, g = x[21], by_constant, by_parameter
    nx, ny = row[NORMAL_X], row[NORMAL_Y]
    px, py = _turned(x[19], x[20])
    gx, gy = _turned(0.0, MASS_CENTRE_Y)
    mass_x = mass_y = 0.0
    for i in range(4):
        vx = vy = 0.0
        if not fixed:
            away_x = row[6 * i] - row[START_X] - row[6 * i + 2]
            away_y = row[6 * i + 1] - row[START_Y] - row[6 * i + 3]
            share = b[6 * i + REST] / math.sqrt(away_x * away_x + away_y * away_y)
            vx, vy = share * away_x, share * away_y
        if x.shape[0] > CHANGES:
            g[CHANGES + i] = b[6 * i + REST]
        g[4 * i] = b[6 * i] + vx
        g[4 * i + 1] = b[6 * i + 1] + vy
        g[4 * i + 2], g[4 * i + 3] = _turned_back(b[6 * i + 2] - vx, b[6 * i + 3] - vy)
        g[22 + i] = b[6 * i + 4]
        mass_x -= vx
        mass_y -= vy
    away_x, away_y = x[16] - origin_x - px, x[17] - origin_y - py
    gap = nx * away_x + ny * away_y - x[18]
    by_gap = nx * mass_x + ny * mass_y
    by_nx = b[NORMAL_X] + b[LINE_OFFSET] * (px - gx) + by_gap * away_x + gap * mass_x
    by_ny = b[NORMAL_Y] + b[LINE_OFFSET] * (py - gy) + by_gap * away_y + gap * mass_y
    along = b[LINE_OFFSET] - by_gap
    by_k = b[CONTACT_K] * row[CONTACT_K]
    g[16] = b[CENTRE_X] + by_gap * nx
    g[17] = b[CENTRE_Y] + by_gap * ny
    g[18] = b[RADIUS] - by_gap + 0.5 * by_k / x[18]
    g[19], g[20] = _turned_back(along * nx, along * ny)
    tx, ty = _turned(-math.cos(slope), -math.sin(slope))
    g[21] = by_nx * tx + by_ny * ty
    g[26] = by_k / x[26]
    g[27] = by_k * 2.0 * x[27] / (1.0 - x[27] * x[27])


def rest_lengths(rows: FloatArray) -> FloatArray:
    """Return the rest lengths (m) in rows of constants, shape (..., 4)."""
    chosen: NDArray[Any] = rows[..., [6 * i + REST for i in range(4)]]
    return chosen

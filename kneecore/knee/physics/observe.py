"""What can be read off a pose: tensions, contact, the tibia's place. Shared by all solvers."""

import math

import numpy as np
from numpy.typing import NDArray

from kneecore._jit import kernel
from kneecore.knee.physics.forces import (
    MASS_CENTRE_Y,
    THETA_0,
    contact_push,
    ligament_tension,
    sin_cos,
)
from kneecore.knee.physics.pose import POINT_OFFSET

N_OBSERVED = 9

FloatArray = NDArray[np.float64]


@kernel
def _observe(rows: FloatArray, poses: FloatArray, seen: FloatArray) -> None:
    for m in range(poses.shape[0]):
        r = rows[m]
        for k in range(poses.shape[1]):
            x, y, psi = poses[m, k, 0], poses[m, k, 1], poses[m, k, 2]
            s, c = sin_cos(psi)
            for i in range(4):
                a = 6 * i
                seen[m, k, i] = ligament_tension(
                    r[a], r[a + 1], r[a + 2], r[a + 3], r[a + 4], r[a + 5], x, y, s, c
                )
            _fx, _fy, _m, force, delta = contact_push(
                r[24], r[25], r[26], r[28], r[29], r[27], r[30], x, y, s, c
            )
            nx = c * r[28] - s * r[29]
            ny = s * r[28] + c * r[29]
            seen[m, k, 4] = force
            seen[m, k, 5] = delta
            seen[m, k, 6] = ny * (r[24] - x) - nx * (r[25] - y) - r[POINT_OFFSET]
            # The tibia's origin lies above its mass centre: o = r - R(phi) g.
            phi = psi - THETA_0
            seen[m, k, 7] = x + math.sin(phi) * MASS_CENTRE_Y
            seen[m, k, 8] = y - math.cos(phi) * MASS_CENTRE_Y


def observe(rows: FloatArray, poses: FloatArray) -> dict[str, FloatArray]:
    """Return what the kernels' constants and poses imply.

    Parameters
    ----------
    rows : ndarray, shape (n, 36)
    poses : ndarray, shape (n, k, 3)
        x, y (m), psi (rad).

    Returns
    -------
    dict
        `tension` (n, k, 4) in N, `contact_force` (n, k) in N, `indentation` (n, k) in m,
        `ap_position` (n, k) in m: the circle's centre along the plateau line from the plateau
        point, anterior positive; `tibia_position` (n, k, 2) in m: the tibia's origin.
    """
    seen = np.empty((*poses.shape[:2], N_OBSERVED))
    _observe(rows, np.ascontiguousarray(poses), seen)
    return {
        "tension": seen[..., :4],
        "contact_force": seen[..., 4],
        "indentation": seen[..., 5],
        "ap_position": seen[..., 6],
        "tibia_position": seen[..., 7:9],
    }

"""The knee's potential with its exact gradient and Hessian, for kernels that look for equilibria.

At rest the damping is gone and all forces come from a potential:

    V(x, y, psi) = sum k e^3 / 3  +  2/5 K delta^2.5  -  M psi

with the elongations e and the indentation delta of `physics.forces`, none below zero. Both
powers leave V twice continuously differentiable where a ligament goes slack or the contact opens.

The translation may be that of any point of the tibia: arms and offsets count from it. Solvers move
the tibia's origin, close to the joint, and not its mass centre far below, so that turn and
translation are less coupled (`about_origin`, `move_to_mass_centre`).

The functions are inlined into loops over lanes and stay free of branches.
"""

import math

import numpy as np
from numpy.typing import NDArray

from kneecore._jit import inline, kernel
from kneecore.knee.physics.forces import MASS_CENTRE_Y, THETA_0, sin_cos
from kneecore.knee.physics.pose import LINE_OFFSET, NORMAL_X, NORMAL_Y

FloatArray = NDArray[np.float64]

# From the tibia's origin to its mass centre, as it lies in the load-free pose, m.
_TO_MASS_X, _TO_MASS_Y = MASS_CENTRE_Y * math.sin(THETA_0), MASS_CENTRE_Y * math.cos(THETA_0)


@kernel
def about_origin(rows: FloatArray) -> FloatArray:
    """Return rows of constants, shape (n, 36), with arms and offset from the tibia's origin."""
    moved = rows.copy()
    for m in range(rows.shape[0]):
        for i in range(4):
            moved[m, 6 * i + 2] += _TO_MASS_X
            moved[m, 6 * i + 3] += _TO_MASS_Y
        moved[m, LINE_OFFSET] += rows[m, NORMAL_X] * _TO_MASS_X + rows[m, NORMAL_Y] * _TO_MASS_Y
    return moved


@kernel
def move_to_mass_centre(poses: FloatArray) -> None:
    """Turn poses (n, k, 3) of the tibia's origin into those of its mass centre, in place."""
    for m in range(poses.shape[0]):
        for k in range(poses.shape[1]):
            s, c = sin_cos(poses[m, k, 2])
            poses[m, k, 0] += c * _TO_MASS_X - s * _TO_MASS_Y
            poses[m, k, 1] += s * _TO_MASS_X + c * _TO_MASS_Y


@inline
def ligament_terms(px, py, bx, by, k, rest, x, y, s, c):  # type: ignore[no-untyped-def]
    """Return the energy of a ligament (J), its gradient and the upper triangle of its Hessian.

    With the length l and its direction u: V_i = k e^2 l_i and V_ij = 2 k e l_i l_j + k e^2 l_ij.

    Returns
    -------
    tuple of 10
        V, V_x, V_y, V_psi, V_xx, V_xy, V_yy, V_xpsi, V_ypsi, V_psipsi.
    """
    arm_x = c * bx - s * by
    arm_y = s * bx + c * by
    dx = px - x - arm_x
    dy = py - y - arm_y
    length = math.sqrt(dx * dx + dy * dy)
    per_length = 1.0 / length
    ux = dx * per_length
    uy = dy * per_length
    turn = ux * arm_y - uy * arm_x  # dl / dpsi
    e = max(length - rest, 0.0)
    ke = k * e
    tension = ke * e
    across = tension * per_length
    along = 2.0 * ke - across
    return (
        tension * e * (1.0 / 3.0),
        -tension * ux,
        -tension * uy,
        tension * turn,
        along * ux * ux + across,
        along * ux * uy,
        along * uy * uy + across,
        -along * ux * turn - across * arm_y,
        -along * uy * turn + across * arm_x,
        along * turn * turn
        + across * (arm_x * arm_x + arm_y * arm_y)
        + tension * (ux * arm_x + uy * arm_y),
    )


@inline
def contact_terms(cx, cy, radius, nx0, ny0, offset, stiffness, x, y, s, c):  # type: ignore[no-untyped-def]
    """Return the energy of the contact (J), its gradient and the upper triangle of its Hessian.

    With delta = radius - n.(centre - point) + offset: V_i = K delta^1.5 delta_i and
    V_ij = 1.5 K delta^0.5 delta_i delta_j + K delta^1.5 delta_ij. Ten numbers, in the order of
    `ligament_terms`.
    """
    ex = cx - x
    ey = cy - y
    nx = c * nx0 - s * ny0
    ny = s * nx0 + c * ny0
    reach = nx * ex + ny * ey
    turn = ny * ex - nx * ey  # d delta / dpsi
    delta = max(radius - (reach - offset), 0.0)
    root = math.sqrt(delta)
    force = stiffness * delta * root
    slope = 1.5 * stiffness * root
    return (
        0.4 * force * delta,
        force * nx,
        force * ny,
        force * turn,
        slope * nx * nx,
        slope * nx * ny,
        slope * ny * ny,
        slope * nx * turn - force * ny,
        slope * ny * turn + force * nx,
        slope * turn * turn + force * reach,
    )


@kernel
def all_terms(row: FloatArray, x: float, y: float, psi: float, h: FloatArray) -> None:
    """Fill `h` (10,) with the whole knee's terms, in the order of `ligament_terms`, without M."""
    s, c = sin_cos(psi)
    e = contact_terms(row[24], row[25], row[26], row[28], row[29], row[27], row[30], x, y, s, c)
    for t in range(10):
        h[t] = e[t]
    for i in range(0, 24, 6):
        e = ligament_terms(
            row[i], row[i + 1], row[i + 2], row[i + 3], row[i + 4], row[i + 5], x, y, s, c
        )
        for t in range(10):
            h[t] += e[t]

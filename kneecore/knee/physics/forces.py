"""The equations of the knee's forces, once, for every kernel.

The model is that of Machado et al. 2010 (Nonlinear Dyn. 60:459-478) as Ciszkiewicz & Dumas 2024
(Front. Mech. Eng. 10:1392616) use it: the femur is fixed, the tibia moves in the sagittal plane (x
anterior, y proximal), four ligaments pull with the square of their elongation, and the circle of
the condyle presses with Hertz's law on the line of the plateau.

A pose is (x, y, psi): the tibia's mass centre in the femur frame and the counter-clockwise turn
since the load-free pose, so the flexion angle is ``THETA_0 - psi``. Vectors of the tibia are held
as they lie in the load-free pose, so that one rotation by psi brings them to the femur frame.

The functions are inlined into loops over lanes that the compiler turns into vector instructions:
they must stay free of branches and of calls to the C library.
"""

import math

from kneecore._jit import inline

MASS = 3.75
"""Tibia and foot, kg."""
INERTIA = 0.165
"""About the mass centre, kg m^2."""
LINEAR_DAMPING = 1.0
"""N s/m, on the velocity of the mass centre."""
ANGULAR_DAMPING = 1.5
"""N m s/rad."""
THETA_0 = math.radians(54.79)
"""Flexion angle of the load-free pose, rad."""
MASS_CENTRE_Y = -0.213
"""Height of the mass centre in the tibia frame, m (its x is 0)."""

# Taylor coefficients; |psi / 2| stays below 1.31, the error below 6e-15 (1e-15 up to 120 deg).
_S3, _S5, _S7 = -1.0 / 6, 1.0 / 120, -1.0 / 5040
_S9, _S11, _S13 = 1.0 / 362880, -1.0 / 39916800, 1.0 / 6227020800
_S15, _S17 = -1.0 / 1307674368000, 1.0 / 355687428096000
_C2, _C4, _C6, _C8 = -0.5, 1.0 / 24, -1.0 / 720, 1.0 / 40320
_C10, _C12, _C14 = -1.0 / 3628800, 1.0 / 479001600, -1.0 / 87178291200
_C16, _C18 = 1.0 / 20922789888000, -1.0 / 6402373705728000


@inline
def sin_cos(psi):  # type: ignore[no-untyped-def]
    """Return sine and cosine by polynomials of the half angle; |psi| < 150 deg."""
    h = 0.5 * psi
    z = h * h
    odd = _S3 + z * (_S5 + z * (_S7 + z * (_S9 + z * (_S11 + z * (_S13 + z * (_S15 + z * _S17))))))
    s = h * (1.0 + z * odd)
    even = _C6 + z * (_C8 + z * (_C10 + z * (_C12 + z * (_C14 + z * (_C16 + z * _C18)))))
    c = 1.0 + z * (_C2 + z * (_C4 + z * even))
    return 2.0 * s * c, 1.0 - 2.0 * s * s


@inline
def ligament_pull(px, py, bx, by, k, rest, x, y, s, c):  # type: ignore[no-untyped-def]
    """Return the force (N) of a ligament on the tibia and its moment (N m) about the mass centre.

    `p` is the femoral attachment, `b` the arm from the mass centre to the tibial one. The tension
    is k e^2 for an elongation e > 0; the force per length q turns it into a vector.
    """
    arm_x = c * bx - s * by
    arm_y = s * bx + c * by
    dx = px - x - arm_x
    dy = py - y - arm_y
    length = math.sqrt(dx * dx + dy * dy)
    e = max(length - rest, 0.0)
    q = k * e * e / length
    return q * dx, q * dy, q * (arm_x * dy - arm_y * dx)


@inline
def ligament_tension(px, py, bx, by, k, rest, x, y, s, c):  # type: ignore[no-untyped-def]
    """Return the tension k e^2 (N) of a ligament; the arguments are those of `ligament_pull`."""
    dx = px - x - (c * bx - s * by)
    dy = py - y - (s * bx + c * by)
    e = max(math.sqrt(dx * dx + dy * dy) - rest, 0.0)
    return k * e * e


@inline
def contact_stiffness(radius, youngs_modulus, poissons_ratio):  # type: ignore[no-untyped-def]
    """Return Hertz's K (N/m^1.5) of two equal bodies, one a sphere and one flat."""
    compliance = 2.0 * (1.0 - poissons_ratio * poissons_ratio) / youngs_modulus
    return 4.0 / 3.0 * math.sqrt(radius) / compliance


@inline
def contact_push(cx, cy, radius, nx0, ny0, offset, stiffness, x, y, s, c):  # type: ignore[no-untyped-def]
    """Return contact force vector (N), moment (N m), its size (N) and the indentation (m).

    The distance of the circle's centre from the line is n.(centre - mass centre) - offset; the
    force K delta^1.5 acts along -n through the circle's centre.
    """
    ex = cx - x
    ey = cy - y
    nx = c * nx0 - s * ny0
    ny = s * nx0 + c * ny0
    delta = max(radius - (nx * ex + ny * ey - offset), 0.0)
    force = stiffness * delta * math.sqrt(delta)
    fx = -force * nx
    fy = -force * ny
    return fx, fy, ex * fy - ey * fx, force, delta

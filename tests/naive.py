"""A slow, plain model of the loaded knee, to hold the fast one against.

One scalar line per equation, no compilation, no vectorisation, and nothing shared with the
package under test. The method is that of Ciszkiewicz & Dumas 2024 (Front. Mech. Eng. 10:1392616,
doi 10.3389/fmech.2024.1392616), with the mechanics of Machado et al. 2010 (Nonlinear Dyn.
60:459-478). The baseline is a reconstruction, since the paper's parameter table is not available.

Conventions
-----------
The sagittal plane: X anterior, Y proximal. The femur stands still; its axes are those of the
extended, standing leg. ``phi`` is the counter-clockwise turn of the tibia, flexion is
``theta = -phi``. A tibia point ``a`` stands at ``origin + R(phi) a`` in the femur frame. Units are
SI and radians throughout: lengths in m, ligament stiffness in N/m^2, Young's modulus in Pa.

The tibia carries four ligaments that only pull, one frictionless contact of the condylar circle
with the plateau line, an external moment and viscous damping. No gravity, patella or muscle.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
RestLength = Literal["recomputed", "fixed"]
Four = tuple[float, float, float, float]

MASS = 3.75  # kg, tibia
INERTIA = 0.165  # kg m^2, tibia, about its mass centre
MASS_CENTRE = -0.213  # m, height of the mass centre in the tibia frame (it lies on the y axis)
DAMPING = 1.0  # N s/m, against the velocity of the mass centre
ANGULAR_DAMPING = 1.5  # N m s/rad
THETA_0 = math.radians(54.79)  # load-free flexion
STATION = -8.1e-3  # m, baseline contact at the load-free pose, along the plateau line

STEPS_PER_SECOND = 250  # dt = 0.004 s, before any halving
MAX_REFINEMENTS = 3  # halvings of the step before a model counts as failed
MOMENTS = (0.1, 0.2, 0.4, 0.8, 2.0, 5.0)  # N m, sizes of the load plateaus
STARTS = (0, 7, 11, 14, 17, 20)  # s, when each plateau begins
ENDS = (7, 11, 14, 17, 20, 23)  # s, when each plateau is read

MAX_EXCURSION = math.radians(150.0)  # a run that turns further than this from THETA_0 is lost
MAX_KINETIC_ENERGY = 5e-3  # J, at a plateau's end; above it the run is hot
SAME_ANGLE = math.radians(0.2)  # two runs agree if their angles differ by less at every load
SETTLED_CHANGE = math.radians(0.2)  # a plateau has settled if theta moves less than this ...
SETTLED_WINDOW = 0.5  # ... over this many seconds before its end


class Knee(NamedTuple):
    """The 28 parameters in SI units, in the order of every parameter vector."""

    acl_femur_x: float
    acl_femur_y: float
    acl_tibia_x: float
    acl_tibia_y: float
    pcl_femur_x: float
    pcl_femur_y: float
    pcl_tibia_x: float
    pcl_tibia_y: float
    mcl_femur_x: float
    mcl_femur_y: float
    mcl_tibia_x: float
    mcl_tibia_y: float
    lcl_femur_x: float
    lcl_femur_y: float
    lcl_tibia_x: float
    lcl_tibia_y: float
    condyle_x: float
    condyle_y: float
    condyle_radius: float
    plateau_x: float
    plateau_y: float
    plateau_slope: float
    acl_stiffness: float
    pcl_stiffness: float
    mcl_stiffness: float
    lcl_stiffness: float
    youngs_modulus: float
    poissons_ratio: float


NAMES: tuple[str, ...] = Knee._fields

BASELINE: FloatArray = np.array(
    [
        *(-14.0e-3, -0.3e-3, 10.2e-3, 5.1e-3),  # ACL: femur x, y, tibia x, y
        *(-9.7e-3, -9.3e-3, -17.1e-3, -8.1e-3),  # PCL
        *(3.2e-3, -4.9e-3, 6.4e-3, -63.5e-3),  # MCL
        *(-4.3e-3, 0.4e-3, -17.3e-3, -19.0e-3),  # LCL
        *(0.0, 0.0, 32.1e-3),  # condylar circle: centre x, y, radius
        *(0.0, 0.0, math.radians(9.0)),  # plateau line: point x, y, slope
        *(35e6, 30e6, 15e6, 15e6),  # ligament stiffness, N/m^2
        *(24e6, 0.46),  # cartilage: Young's modulus in Pa, Poisson's ratio
    ]
)


class Ligament(NamedTuple):
    """A ligament's attachment on the femur, on the tibia (each in its own frame), its stiffness."""

    femur_x: float
    femur_y: float
    tibia_x: float
    tibia_y: float
    stiffness: float


class Contact(NamedTuple):
    """The contact of the condylar circle with the plateau line."""

    indentation: float  # m, negative where there is a gap
    force: float  # N, 0 where there is a gap
    position: float  # m, circle centre along the line from the plateau point, positive anterior
    normal_x: float  # the line's unit normal, towards the femur, in the femur frame
    normal_y: float


class State(NamedTuple):
    """Position of the tibia's mass centre, turn of the tibia, and their rates."""

    x: float
    y: float
    phi: float
    vx: float
    vy: float
    omega: float


class Plateau(NamedTuple):
    """What is read after the last step of one load plateau."""

    moment: float  # N m, signed
    flexion: float  # rad
    tension: Four  # N, ACL, PCL, MCL, LCL
    contact_force: float  # N
    indentation: float  # m, 0 where there is a gap
    ap_position: float  # m
    settled: bool
    tibia_position: tuple[float, float]  # m, tibia origin in the femur frame
    kinetic_energy: float  # J


class WildRunError(ArithmeticError):
    """The run turned non-finite or left the range of flexion."""


def as_knee(x: ArrayLike) -> Knee:
    """Name the first 28 entries, as plain floats (they are faster than NumPy's)."""
    return Knee(*(float(value) for value in np.asarray(x, dtype=float)[:28]))


def ligaments(knee: Knee) -> tuple[Ligament, Ligament, Ligament, Ligament]:
    """Return ACL, PCL, MCL and LCL."""
    k = knee
    return (
        Ligament(k.acl_femur_x, k.acl_femur_y, k.acl_tibia_x, k.acl_tibia_y, k.acl_stiffness),
        Ligament(k.pcl_femur_x, k.pcl_femur_y, k.pcl_tibia_x, k.pcl_tibia_y, k.pcl_stiffness),
        Ligament(k.mcl_femur_x, k.mcl_femur_y, k.mcl_tibia_x, k.mcl_tibia_y, k.mcl_stiffness),
        Ligament(k.lcl_femur_x, k.lcl_femur_y, k.lcl_tibia_x, k.lcl_tibia_y, k.lcl_stiffness),
    )


def to_femur(x: float, y: float, phi: float, ax: float, ay: float) -> tuple[float, float]:
    """Place the tibia point (ax, ay) in the femur frame: origin + R(phi) a."""
    c, s = math.cos(phi), math.sin(phi)
    return x + c * ax - s * ay, y + s * ax + c * ay


def ligament_length(ligament: Ligament, x: float, y: float, phi: float) -> float:
    """Distance between the attachments, for the tibia origin (x, y) and turn phi."""
    px, py = to_femur(x, y, phi, ligament.tibia_x, ligament.tibia_y)
    return math.hypot(ligament.femur_x - px, ligament.femur_y - py)


def ligament_force(stiffness: float, length: float, rest: float) -> float:
    """Tension: stiffness times the elongation squared; a slack ligament carries nothing."""
    elongation = length - rest
    # Asked this way round, a NaN is passed on and fails the run instead of passing for slack.
    return 0.0 if elongation <= 0.0 else stiffness * elongation * elongation


def hertz_stiffness(radius: float, youngs_modulus: float, poissons_ratio: float) -> float:
    """Hertz's constant in N/m^1.5 of a sphere on a plane, both of the same material.

    4/3 sqrt(R) E*, where 1/E* = 2 (1 - nu^2) / E is the sum of both bodies' compliances.
    """
    compliance = 2.0 * (1.0 - poissons_ratio * poissons_ratio) / youngs_modulus
    return 4.0 / 3.0 * math.sqrt(radius) / compliance


def contact(knee: Knee, x: float, y: float, phi: float) -> Contact:
    """Contact of the circle with the line, for the tibia origin (x, y) and turn phi."""
    # The line's direction and normal: (cos, sin) and (-sin, cos) of its slope, turned by phi.
    angle = phi + knee.plateau_slope
    tx, ty = math.cos(angle), math.sin(angle)
    nx, ny = -ty, tx
    qx, qy = to_femur(x, y, phi, knee.plateau_x, knee.plateau_y)
    dx, dy = knee.condyle_x - qx, knee.condyle_y - qy
    distance = dx * nx + dy * ny
    indentation = knee.condyle_radius - distance
    if indentation <= 0.0:
        force = 0.0
    else:
        k = hertz_stiffness(knee.condyle_radius, knee.youngs_modulus, knee.poissons_ratio)
        force = k * indentation * math.sqrt(indentation)
    return Contact(indentation, force, dx * tx + dy * ty, nx, ny)


def load_free_pose(x: ArrayLike, baseline: ArrayLike = BASELINE) -> tuple[FloatArray, float]:
    """Pose in which the knee's own circle just touches its own line, at 54.79 deg.

    Parameters
    ----------
    x, baseline
        28-vectors: the knee, and the one about which it is perturbed.

    Returns
    -------
    origin, phi
        Tibia origin in the femur frame (2,), and the turn of the tibia.
    """
    own, base = as_knee(x), as_knee(baseline)
    phi = -THETA_0

    # The baseline circle touches the baseline line at the station, so in the tibia frame its
    # centre is at plateau point + station t + radius n.
    tx, ty = math.cos(base.plateau_slope), math.sin(base.plateau_slope)
    nx, ny = -ty, tx
    ax = base.plateau_x + STATION * tx + base.condyle_radius * nx
    ay = base.plateau_y + STATION * ty + base.condyle_radius * ny
    # The tibia origin that brings this point onto the circle's centre: centre - R(phi) a.
    rx, ry = to_femur(0.0, 0.0, phi, ax, ay)
    ox, oy = base.condyle_x - rx, base.condyle_y - ry

    # Shift the tibia along its own normal by the gap between its own line and its own circle.
    touch = contact(own, ox, oy, phi)
    gap = -touch.indentation
    return np.array([ox + gap * touch.normal_x, oy + gap * touch.normal_y]), phi


def rest_lengths(
    x: ArrayLike, baseline: ArrayLike = BASELINE, mode: RestLength = "recomputed"
) -> FloatArray:
    """Rest lengths (4,) of ACL, PCL, MCL and LCL: their lengths in the load-free pose.

    With mode "recomputed" it is the knee's own pose, which is then strain-free; with "fixed" the
    knee keeps the baseline's rest lengths. Entries 28 to 31 of the knee, if there, are added.
    """
    if mode not in ("recomputed", "fixed"):
        raise ValueError(f"unknown rest-length mode {mode!r}")
    source = x if mode == "recomputed" else baseline
    (ox, oy), phi = load_free_pose(source, baseline)
    lengths = np.array([ligament_length(lig, ox, oy, phi) for lig in ligaments(as_knee(source))])
    changes = np.asarray(x, dtype=float)[28:]
    return lengths + changes if len(changes) else lengths


def tibia_origin(state: State) -> tuple[float, float]:
    """Tibia origin in the femur frame: mass centre - R(phi) (0, MASS_CENTRE)."""
    return to_femur(state.x, state.y, state.phi, 0.0, -MASS_CENTRE)


def acceleration(knee: Knee, rest: Four, state: State, moment: float) -> tuple[float, float, float]:
    """Newton and Euler for the tibia, about its mass centre.

    Parameters
    ----------
    knee, rest
        The parameters, and the ligaments' rest lengths.
    state
        Pose and velocities; the damping sees the velocities given here.
    moment
        External moment on the tibia, counter-clockwise (extension) positive.

    Returns
    -------
    ax, ay, alpha
        Acceleration of the mass centre and angular acceleration.
    """
    ox, oy = tibia_origin(state)
    fx = -DAMPING * state.vx
    fy = -DAMPING * state.vy
    mz = moment - ANGULAR_DAMPING * state.omega

    for lig, l0 in zip(ligaments(knee), rest, strict=True):
        px, py = to_femur(ox, oy, state.phi, lig.tibia_x, lig.tibia_y)
        dx, dy = lig.femur_x - px, lig.femur_y - py
        length = math.hypot(dx, dy)
        tension = ligament_force(lig.stiffness, length, l0)
        if tension != 0.0:  # a slack ligament may have no length, hence no direction
            # The tibia is pulled towards the attachment on the femur.
            gx, gy = tension * dx / length, tension * dy / length
            fx += gx
            fy += gy
            mz += (px - state.x) * gy - (py - state.y) * gx

    touch = contact(knee, ox, oy, state.phi)
    # The femur presses the tibia down its normal; the line of action runs through the circle's
    # centre, since there is no friction.
    gx, gy = -touch.force * touch.normal_x, -touch.force * touch.normal_y
    fx += gx
    fy += gy
    mz += (knee.condyle_x - state.x) * gy - (knee.condyle_y - state.y) * gx

    return fx / MASS, fy / MASS, mz / INERTIA


def kinetic_energy(state: State) -> float:
    """Kinetic energy of the tibia, of its translation and its turning."""
    v2 = state.vx * state.vx + state.vy * state.vy
    return 0.5 * MASS * v2 + 0.5 * INERTIA * state.omega * state.omega


def step(knee: Knee, rest: Four, state: State, moment: float, dt: float) -> State:
    """One step of semi-implicit Euler: new velocities first, then the pose from them."""
    ax, ay, alpha = acceleration(knee, rest, state, moment)
    vx = state.vx + dt * ax
    vy = state.vy + dt * ay
    omega = state.omega + dt * alpha
    return State(state.x + dt * vx, state.y + dt * vy, state.phi + dt * omega, vx, vy, omega)


def in_range(state: State) -> bool:
    """Whether all is finite and flexion within 150 deg of the load-free pose (NaN is not)."""
    return all(map(math.isfinite, state)) and abs(-state.phi - THETA_0) < MAX_EXCURSION


def observe(knee: Knee, rest: Four, state: State, moment: float, settled: bool) -> Plateau:
    """Read the forces and the contact at the given state."""
    ox, oy = tibia_origin(state)
    acl, pcl, mcl, lcl = (
        ligament_force(lig.stiffness, ligament_length(lig, ox, oy, state.phi), l0)
        for lig, l0 in zip(ligaments(knee), rest, strict=True)
    )
    touch = contact(knee, ox, oy, state.phi)
    return Plateau(
        moment=moment,
        flexion=-state.phi,
        tension=(acl, pcl, mcl, lcl),
        contact_force=touch.force,
        indentation=max(touch.indentation, 0.0),
        ap_position=touch.position,
        settled=settled,
        tibia_position=(ox, oy),
        kinetic_energy=kinetic_energy(state),
    )


def run(
    x: ArrayLike,
    direction: int,
    baseline: ArrayLike = BASELINE,
    rest_length: RestLength = "recomputed",
    refine: int = 0,
) -> list[Plateau]:
    """Load the knee from rest at its load-free pose, in one direction, for 23 s.

    Parameters
    ----------
    x, baseline
        28-vectors: the knee, and the one about which it is perturbed.
    direction
        +1 for extension, -1 for flexion.
    rest_length
        Whether the rest lengths are the knee's own ("recomputed") or the baseline's ("fixed").
    refine
        How often the step of 4 ms is halved.

    Returns
    -------
    list of Plateau
        One record for each of the six loads, by rising size.

    Raises
    ------
    WildRunError
        If the run turns non-finite or leaves the range of flexion.
    """
    if direction not in (1, -1):
        raise ValueError("direction is +1 (extension) or -1 (flexion)")
    knee = as_knee(x)
    acl, pcl, mcl, lcl = (float(length) for length in rest_lengths(x, baseline, rest_length))
    rest = (acl, pcl, mcl, lcl)

    origin, phi = load_free_pose(x, baseline)
    cx, cy = to_femur(float(origin[0]), float(origin[1]), phi, 0.0, MASS_CENTRE)
    state = State(cx, cy, phi, 0.0, 0.0, 0.0)

    # Whole numbers of steps, so that no rounding of k dt decides which load is in force.
    rate = STEPS_PER_SECOND * 2**refine
    dt = 1.0 / rate
    records = []
    for size, start, end in zip(MOMENTS, STARTS, ENDS, strict=True):
        moment = direction * size
        window_start = end * rate - round(SETTLED_WINDOW * rate)
        phi_window = math.nan
        for k in range(start * rate, end * rate):
            if k == window_start:
                phi_window = state.phi  # k steps have been taken: this is the pose at t = k dt
            state = step(knee, rest, state, moment, dt)
            if not in_range(state):
                raise WildRunError(f"left the range at step {k} of {moment} N m")
        settled = abs(state.phi - phi_window) < SETTLED_CHANGE
        records.append(observe(knee, rest, state, moment, settled))
    return records


def is_hot(plateau: Plateau) -> bool:
    """Whether the knee still moves, with too much energy to be at rest, at a plateau's end."""
    return not plateau.kinetic_energy <= MAX_KINETIC_ENERGY


def rings(records: list[Plateau], before: list[Plateau]) -> bool:
    """Whether a hot run is the knee's own ringing: halving the step has changed no angle much."""
    agree = all(
        abs(now.flexion - then.flexion) < SAME_ANGLE
        for now, then in zip(records, before, strict=True)
    )
    return agree and all(record.settled for record in records if is_hot(record))


def run_refined(
    x: ArrayLike,
    direction: int,
    baseline: ArrayLike = BASELINE,
    rest_length: RestLength = "recomputed",
) -> tuple[list[Plateau] | None, int]:
    """Repeat a wild or hot run with the step halved, up to three times.

    A run is accepted if it is calm, or hot but rings; it is given up if it is wild twice in a row.

    Returns
    -------
    records, n_refinements
        None and the number of halvings that were tried if the run fails.
    """
    before: list[Plateau] | None = None  # the run with twice the step; None if it was wild
    for refine in range(MAX_REFINEMENTS + 1):
        try:
            records = run(x, direction, baseline, rest_length, refine)
        except WildRunError:
            if refine > 0 and before is None:
                return None, refine
            before = None
            continue
        if not any(map(is_hot, records)) or (before is not None and rings(records, before)):
            return records, refine
        before = records
    return None, MAX_REFINEMENTS


def simulate(
    x: ArrayLike, baseline: ArrayLike = BASELINE, rest_length: RestLength = "recomputed"
) -> dict[str, FloatArray | NDArray[np.bool_] | str | int]:
    """Run the knee into extension and into flexion.

    Returns
    -------
    dict
        ``flexion``, ``moment``, ``contact_force``, ``indentation``, ``ap_position`` (12,),
        ``tension`` (12, 4), ``tibia_position`` (12, 2), ``settled`` (12,); six loads in extension
        by rising size, then six in flexion. ``status`` is "ok", "refined" or "failed", and
        ``n_refinements`` the larger number of halvings of the two runs. A failed model has NaN in
        every float array and has settled nowhere.
    """
    extension, n_extension = run_refined(x, 1, baseline, rest_length)
    flexion, n_flexion = run_refined(x, -1, baseline, rest_length)
    n_refinements = max(n_extension, n_flexion)

    if extension is None or flexion is None:
        nan = np.full(12, math.nan)
        return {
            "flexion": nan,
            "moment": nan.copy(),
            "tension": np.full((12, 4), math.nan),
            "contact_force": nan.copy(),
            "indentation": nan.copy(),
            "ap_position": nan.copy(),
            "settled": np.zeros(12, dtype=bool),
            "tibia_position": np.full((12, 2), math.nan),
            "status": "failed",
            "n_refinements": n_refinements,
        }

    records = extension + flexion
    return {
        "flexion": np.array([record.flexion for record in records]),
        "moment": np.array([record.moment for record in records]),
        "tension": np.array([record.tension for record in records]),
        "contact_force": np.array([record.contact_force for record in records]),
        "indentation": np.array([record.indentation for record in records]),
        "ap_position": np.array([record.ap_position for record in records]),
        "settled": np.array([record.settled for record in records]),
        "tibia_position": np.array([record.tibia_position for record in records]),
        "status": "refined" if n_refinements else "ok",
        "n_refinements": n_refinements,
    }


def potential(x: ArrayLike, pose: ArrayLike, moment: float, rest: ArrayLike) -> float:
    """Potential energy of the knee under a constant moment; stationary at equilibrium.

    Parameters
    ----------
    x
        28-vector of the knee.
    pose
        Tibia origin x, y in the femur frame, and phi.
    moment
        External moment, extension positive.
    rest
        Rest lengths (4,).

    Returns
    -------
    float
        Energy in J. A tension k e^2 stores k e^3 / 3, Hertz's force K d^1.5 stores 2/5 K d^2.5,
        and the moment's work, M phi, is taken off.
    """
    knee = as_knee(x)
    ox, oy, phi = (float(value) for value in np.asarray(pose, dtype=float))
    energy = -moment * phi
    for lig, l0 in zip(ligaments(knee), np.asarray(rest, dtype=float), strict=True):
        elongation = ligament_length(lig, ox, oy, phi) - float(l0)
        if elongation > 0.0:
            energy += lig.stiffness * elongation**3 / 3.0
    indentation = contact(knee, ox, oy, phi).indentation
    if indentation > 0.0:
        k = hertz_stiffness(knee.condyle_radius, knee.youngs_modulus, knee.poissons_ratio)
        energy += 2.0 / 5.0 * k * indentation**2.5
    return energy

"""Where the mechanism's points are for a knee in a pose: what the scene draws, in the femur frame.

All lengths are in m, forces in N, angles in rad. Nothing here is a force law: tensions and contact
forces come from kneecore, and this module only places them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore import NAMES

FloatArray = NDArray[np.float64]

_AT = {name: index for index, name in enumerate(NAMES)}
TAUT_TENSION = 1.0
"""N; below it a ligament is drawn slack."""
ARROW_PER_NEWTON = 6e-5
"""m of the contact arrow for each newton."""
LIGAMENT_DEPTH = (0.0, 0.0, -0.034, 0.034)
"""Illustrative place across the knee in 3D, m: the MCL inside, the LCL outside."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Pose:
    """A knee at one moment of a motion."""

    flexion: float
    """rad"""
    moment: float
    """N m, extension positive."""
    tibia_position: FloatArray
    """Origin of the tibia in the femur frame, shape (2,), m."""
    tension: FloatArray
    """ACL, PCL, MCL, LCL, shape (4,), N."""
    contact_force: float
    """N"""
    time: float | None = None
    """s since the start of the run, for a motion in time."""


def rotation(flexion: float) -> FloatArray:
    """Return the matrix that takes vectors of the tibia to the femur frame."""
    s, c = np.sin(-flexion), np.cos(-flexion)
    return np.array([[c, -s], [s, c]])


def quaternion(flexion: float) -> tuple[float, float, float, float]:
    """Return the tibia's turn about z as (w, x, y, z)."""
    return float(np.cos(-0.5 * flexion)), 0.0, 0.0, float(np.sin(-0.5 * flexion))


def to_femur(points: FloatArray, flexion: float, origin: FloatArray) -> FloatArray:
    """Return points of the tibia, shape (n, 2), in the femur frame."""
    placed: FloatArray = points @ rotation(flexion).T + origin
    return placed


def ligament_ends(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the four attachments on the femur and on the tibia, each in its frame, (4, 2)."""
    ends = np.asarray(x)[:16].reshape(4, 2, 2)
    return ends[:, 0], ends[:, 1]


def ligament_segments(x: FloatArray, pose: Pose) -> FloatArray:
    """Return the four ligaments as segments in the femur frame, shape (4, 2, 2)."""
    femoral, tibial = ligament_ends(x)
    return np.stack([femoral, to_femur(tibial, pose.flexion, pose.tibia_position)], axis=1)


def plateau_frame(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the plateau's point, direction and normal in the tibia frame."""
    point = np.array([x[_AT["plateau_x"]], x[_AT["plateau_y"]]])
    slope = x[_AT["plateau_slope"]]
    along = np.array([np.cos(slope), np.sin(slope)])
    return point, along, np.array([-along[1], along[0]])


def plateau_line(x: FloatArray, reach: tuple[float, float] = (-0.034, 0.036)) -> FloatArray:
    """Return the plateau line's drawn part in the tibia frame, shape (2, 2)."""
    point, along, _ = plateau_frame(x)
    return point + np.outer(reach, along)


def condyle(x: FloatArray) -> tuple[FloatArray, float]:
    """Return centre and radius of the condylar circle in the femur frame."""
    centre = np.array([x[_AT["condyle_x"]], x[_AT["condyle_y"]]])
    return centre, float(x[_AT["condyle_radius"]])


def circle(x: FloatArray, n: int = 72) -> FloatArray:
    """Return the condylar circle as a closed chain of segments in the femur frame, (n, 2, 2)."""
    centre, radius = condyle(x)
    angle = np.linspace(0.0, 2.0 * np.pi, n + 1)
    rim = centre + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    return np.stack([rim[:-1], rim[1:]], axis=1)


def contact_coordinates(x: FloatArray, flexion: float, origin: FloatArray) -> tuple[float, float]:
    """Return where circle and plateau meet: (along the plateau, indentation), m.

    A negative indentation is a gap.
    """
    centre, radius = condyle(x)
    point, along, normal = plateau_frame(x)
    from_point = rotation(flexion).T @ (centre - origin) - point
    return float(from_point @ along), float(radius - from_point @ normal)


def tibia_at_contact(x: FloatArray, flexion: float, along: float, depth: float) -> FloatArray:
    """Return the tibia's origin for contact coordinates: `contact_coordinates` turned round."""
    centre, radius = condyle(x)
    point, direction, normal = plateau_frame(x)
    local = point + along * direction + (radius - depth) * normal
    placed: FloatArray = centre - rotation(flexion) @ local
    return placed


def contact_point(x: FloatArray, pose: Pose) -> FloatArray:
    """Return the contact point on the plateau line in the femur frame, shape (2,)."""
    along, _ = contact_coordinates(x, pose.flexion, pose.tibia_position)
    point, direction, _ = plateau_frame(x)
    local = (point + along * direction)[None]
    placed: FloatArray = to_femur(local, pose.flexion, pose.tibia_position)[0]
    return placed


def contact_arrow(x: FloatArray, pose: Pose) -> FloatArray:
    """Return the contact force on the tibia as an arrow's tail and head, shape (2, 2).

    The head is at the contact point; the length grows with the force.
    """
    head = contact_point(x, pose)
    _, _, normal = plateau_frame(x)
    push = -(rotation(pose.flexion) @ normal)
    return np.stack([head - max(pose.contact_force, 0.0) * ARROW_PER_NEWTON * push, head])

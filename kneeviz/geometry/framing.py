"""How a camera must stand so that points fill its picture. Pure functions of numbers, in m."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from kneeviz.geometry.bones import bones
from kneeviz.geometry.mechanism import Pose, to_femur

FloatArray = NDArray[np.float64]

FIELD_OF_VIEW = np.deg2rad(10.0)
"""Narrow, so that perspective hardly shows: there is no orthographic camera."""
_ROOM, _LEAST_ROOM = 1.08, 1.03
"""What a new frame is larger than what it holds, and what an old one must be."""
_LOOSE = 0.80
"""Share of a frame below which what it holds counts as small in it."""
_OUTLINE_STEP = 4
_BETWEEN = 0.005
"""m between knees that stand side by side."""
_HALF_DEPTH = 0.036
"""Of the bones in the 3D view, m."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Frame:
    """What a camera shows: a point in the middle, and what is above it."""

    centre: FloatArray
    """Shape (3,), m."""
    half_height: float
    """m, in the plane of the centre."""


def knee_points(poses: Iterable[Pose], *, spatial: bool = False) -> FloatArray:
    """Return points around the bones in all `poses` of the tibia, shape (n, 3).

    In the flat view the bones have no depth.
    """
    parts = [bone.outline for bone in bones() if bone.frame == "femur"]
    tibial = [bone.outline[::_OUTLINE_STEP] for bone in bones() if bone.frame == "tibia"]
    parts += [to_femur(o, p.flexion, p.tibia_position) for p in poses for o in tibial]
    plane = np.concatenate(parts)
    depths = (-_HALF_DEPTH, _HALF_DEPTH) if spatial else (0.0,)
    return np.concatenate([np.column_stack([plane, np.full(len(plane), z)]) for z in depths])


def spacing(moments: Iterable[Sequence[Pose]]) -> float:
    """Return how far apart knees must stand, m, so that neighbours never touch; whole cm.

    Parameters
    ----------
    moments : iterable of sequence of Pose
        For each moment of the motion the poses of all knees, from left to right.
    """
    widest = 0.0
    for poses in moments:
        ends = [knee_points([pose])[:, 0] for pose in poses]
        needed = (left.max() - right.min() for left, right in pairwise(ends))
        widest = max([widest, *needed])
    return float(np.ceil(100.0 * (widest + _BETWEEN)) / 100.0)


def axes_of(direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return right and up of a camera that stands in `direction` from its centre, y up."""
    towards = direction / np.linalg.norm(direction)
    right = np.cross([0.0, 1.0, 0.0], towards)
    right /= np.linalg.norm(right)
    return right, np.cross(towards, right)


def frame_around(points: FloatArray, direction: FloatArray, aspect: float) -> Frame:
    """Return the smallest frame, with a little room, that shows all points.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    direction : ndarray, shape (3,)
        From the centre to the camera.
    aspect : float
        Width of the picture over its height.
    """
    right, up = axes_of(direction)
    across, above = points @ right, points @ up
    middle = points.mean(axis=0)
    centre = (
        middle
        + (0.5 * (across.min() + across.max()) - middle @ right) * right
        + (0.5 * (above.min() + above.max()) - middle @ up) * up
    )
    return Frame(centre=centre, half_height=_ROOM * _needed(points, centre, direction, aspect))


def _needed(points: FloatArray, centre: FloatArray, direction: FloatArray, aspect: float) -> float:
    """Return the half height of the smallest frame around `centre` that shows all points."""
    right, up = axes_of(direction)
    away = points - centre
    # What is nearer to the camera looks larger.
    nearer = away @ direction / np.linalg.norm(direction) * np.tan(0.5 * FIELD_OF_VIEW)
    from_middle = np.maximum(np.abs(away @ up), np.abs(away @ right) / aspect)
    return float((from_middle + nearer).max())


def holds(frame: Frame, points: FloatArray, direction: FloatArray, aspect: float) -> bool:
    """Tell whether a frame shows all points with a little room, and not too small."""
    used = _needed(points, frame.centre, direction, aspect)
    return _LOOSE * frame.half_height <= used <= frame.half_height / _LEAST_ROOM


def between(one: Frame, two: Frame, share: float) -> Frame:
    """Return the frame at a share of the way from one to another."""
    return Frame(
        centre=one.centre + share * (two.centre - one.centre),
        half_height=one.half_height + share * (two.half_height - one.half_height),
    )

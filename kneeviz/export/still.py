"""One knee at one moment as SVG in mm, with the names of its parts."""

import numpy as np
from numpy.typing import NDArray

from kneeviz.geometry.bones import bones
from kneeviz.geometry.mechanism import Pose, condyle, ligament_segments, plateau_line, to_femur
from kneeviz.views import theme
from kneeviz.views.scene.labels import label_box, label_spots, leaders

FloatArray = NDArray[np.float64]

_MARGIN = 3.0  # mm
_FLIP = 1e3 * np.array([1.0, -1.0])
"""From m to mm, with y down as SVG has it."""


def still(x: FloatArray, pose: Pose, *, label: str) -> str:
    """Return the knee `x` (SI) in a pose; `label` is read out in the picture's place."""
    outlines = {}
    for bone in bones():
        points = bone.outline
        if bone.frame == "tibia":
            points = to_femur(points, pose.flexion, pose.tibia_position)
        outlines[bone.name] = points * _FLIP
    every = np.concatenate(list(outlines.values()))
    left, top = every.min(axis=0) - _MARGIN
    width, height = every.max(axis=0) + _MARGIN - (left, top)
    body = "".join(_polygon(name, points) for name, points in outlines.items())
    return (
        f'<svg class="knee" viewBox="{left:.1f} {top:.1f} {width:.1f} {height:.1f}" role="img" '
        f'aria-label="{label}">{body}{_surfaces(x, pose)}{_ligaments(x, pose)}</svg>'
    )


def _polygon(name: str, points: FloatArray) -> str:
    corners = " ".join(f"{x:.2f},{y:.2f}" for x, y in points)
    return f'<polygon class="bone {name}" points="{corners}"/>'


def _surfaces(x: FloatArray, pose: Pose) -> str:
    """Return circle and plateau."""
    ends = to_femur(plateau_line(x), pose.flexion, pose.tibia_position) * _FLIP
    (centre_x, centre_y), radius = condyle(x)
    return _line("surface", ends) + (
        f'<circle class="surface" cx="{1e3 * centre_x:.2f}" cy="{-1e3 * centre_y:.2f}" '
        f'r="{1e3 * radius:.2f}"/>'
    )


def _ligaments(x: FloatArray, pose: Pose) -> str:
    """Return the four ligaments with their names beside them."""
    segments = ligament_segments(x, pose)
    spots = label_spots(segments, label_box(forces=False))
    parts = []
    for i, name in enumerate(theme.LIGAMENT_LABELS):
        parts.append(_line(f"ligament {name.lower()}", segments[i] * _FLIP))
    for name, spot, leader in zip(
        theme.LIGAMENT_LABELS, spots * _FLIP, leaders(spots, segments) * _FLIP, strict=True
    ):
        x_mm, y_mm = spot
        parts.append(_line("leader", leader))
        parts.append(f'<text x="{x_mm:.1f}" y="{y_mm + 2.2:.1f}">{name}</text>')
    return "".join(parts)


def _line(kind: str, ends: FloatArray) -> str:
    (x1, y1), (x2, y2) = ends
    return f'<line class="{kind}" x1="{x1:.2f}" y1="{y1:.2f}" x2="{x2:.2f}" y2="{y2:.2f}"/>'

"""The knees as SVG in mm, each part with a name by which it is moved; and their frames."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneeviz.export.chart import scales
from kneeviz.export.film import Film, Filmed
from kneeviz.geometry.bones import Bone, bones
from kneeviz.geometry.mechanism import condyle, plateau_line
from kneeviz.views import theme
from kneeviz.views.scene.body import ligament_width

FloatArray = NDArray[np.float64]


def drawing(film: Film) -> str:
    """Return the femur and all knees; y points down, as SVG has it."""
    left, right, bottom, top = film.window_mm()
    femur = next(bone for bone in bones() if bone.frame == "femur")
    parts = [_body(knee) for knee in film.knees]
    # The femur stands before the baseline's tibia and behind the two that are found.
    parts.insert(int(film.knees[0].name == "baseline"), _polygon(femur, "femur"))
    parts += [_lines(knee) for knee in film.knees]
    return (
        f'<svg class="knees" viewBox="{left:.1f} {-top:.1f} {right - left:.1f} {top - bottom:.1f}" '
        f'role="img" aria-label="The knees at one moment of the motion">{"".join(parts)}</svg>'
    )


def _polygon(bone: Bone, kind: str) -> str:
    points = " ".join(f"{1e3 * x:.2f},{-1e3 * y:.2f}" for x, y in bone.outline)
    return f'<polygon class="bone {kind}" points="{points}"/>'


def _body(knee: Filmed) -> str:
    """Return tibia, fibula and plateau line, which move together."""
    (x1, y1), (x2, y2) = 1e3 * plateau_line(knee.sweep.x)
    tibia = "".join(_polygon(bone, bone.name) for bone in bones() if bone.frame == "tibia")
    line = f'<line class="plateau" x1="{x1:.2f}" y1="{-y1:.2f}" x2="{x2:.2f}" y2="{-y2:.2f}"/>'
    return f'<g class="tibia {knee.name}">{tibia}{line}</g>'


def _lines(knee: Filmed) -> str:
    """Return circle, ligaments and contact."""
    (x, y), radius = condyle(knee.sweep.x)
    parts = [
        f'<circle class="condyle" cx="{1e3 * x:.2f}" cy="{-1e3 * y:.2f}" r="{1e3 * radius:.2f}"/>'
    ]
    parts += [f'<line class="ligament {label.lower()}"/>' for label in theme.LIGAMENT_LABELS]
    parts.append('<circle class="contact" r="2"/>')
    return f'<g class="lines {knee.name}">{"".join(parts)}</g>'


def frames(film: Film) -> dict[str, Any]:
    """Return what moves, frame by frame, as JSON-ready numbers: mm with y down, deg, N, N m."""
    return {"moment": np.round(film.moment, 3).tolist(), "knees": _knees(film)}


def _knees(film: Film) -> list[dict[str, Any]]:
    across, up = scales(film)
    down = np.array([1.0, -1.0])
    told = []
    for knee in film.knees:
        tension = np.array([pose.tension for pose in knee.poses])
        width = [[ligament_width(float(t)) for t in row] for row in tension]
        told.append(
            {
                "name": knee.name,
                "angle": np.round(knee.angle_deg, 2).tolist(),
                "dot": np.round(np.stack([across(knee.angle_deg), up(film.moment)], 1), 1).tolist(),
                "tibia": np.round(knee.tibia_mm * down, 3).tolist(),
                "ends": np.round((knee.ligaments_mm * down).reshape(-1, 4, 4), 2).tolist(),
                "tension": np.round(tension, 1).tolist(),
                "width": np.round(width, 2).tolist(),
                "contact": np.round(knee.contact_mm * down, 2).tolist(),
                "force": [round(pose.contact_force, 1) for pose in knee.poses],
            }
        )
    return told

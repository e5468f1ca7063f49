"""The paper's Figure 2 in numbers: how each worst-case knee differs from the baseline."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore.knee.parameters import LIGAMENTS, NAMES
from kneecore.knee.physics.forces import THETA_0
from kneecore.search.result import SearchResult

__all__ = [
    "ATTACHMENTS",
    "STRUCTURES",
    "GeometryChange",
    "geometry_changes",
    "ligament_lines",
    "place_differences_mm",
]

FloatArray = NDArray[np.float64]
ATTACHMENTS = tuple(f"{ligament}_{bone}" for ligament in LIGAMENTS for bone in ("femur", "tibia"))
"""The eight attachments, in the order of every array here."""
STRUCTURES = (*LIGAMENTS, "condyle", "plateau")
"""What Figure 2 draws, in the order of `place_differences_mm`."""
_PLATEAU_END_MM = 25.0
"""Half of a plateau's length, by which a turn of the line becomes a distance."""
_CENTRE = [NAMES.index(f"condyle_{axis}") for axis in "xy"]
_RADIUS = NAMES.index("condyle_radius")
_SLOPE = NAMES.index("plateau_slope")
_STIFFNESS = [NAMES.index(f"{ligament}_stiffness") for ligament in LIGAMENTS]


@dataclass(frozen=True, kw_only=True, eq=False)
class GeometryChange:
    """One knee less the baseline, both in the load-free pose, as the figure draws them."""

    along_mm: FloatArray
    """Shift of each attachment along the baseline's plateau, shape (8,), mm; anterior > 0."""
    across_mm: FloatArray
    """Across it, shape (8,), mm; proximal > 0."""
    circle_along_mm: float
    """Shift of the condylar circle's centre along the baseline's plateau, mm."""
    circle_across_mm: float
    """Across it, mm."""
    slope_deg: float
    """Turn of the plateau's line, deg; counter-clockwise > 0."""
    angle_deg: FloatArray
    """Turn of each ligament's line, shape (4,), deg; counter-clockwise > 0."""
    stiffness_percent: FloatArray
    """Change of each stiffness, shape (4,), per cent of the baseline's."""

    @property
    def ligament_along_mm(self) -> FloatArray:
        """Shift of the middle of each ligament along the plateau, shape (4,), mm."""
        middle: FloatArray = self.along_mm.reshape(4, 2).mean(axis=1)
        return middle

    @property
    def ligament_across_mm(self) -> FloatArray:
        """The same across it."""
        middle: FloatArray = self.across_mm.reshape(4, 2).mean(axis=1)
        return middle


def _turned(points: FloatArray) -> FloatArray:
    """Turn tibia vectors, shape (..., 2), to where they point in the load-free pose."""
    cos, sin = np.cos(-THETA_0), np.sin(-THETA_0)
    turned: FloatArray = points @ np.array([[cos, sin], [-sin, cos]])
    return turned


def ligament_lines(x: FloatArray, tibia_origin: FloatArray) -> FloatArray:
    """Return the ends of the ligaments in the load-free pose.

    Parameters
    ----------
    x : ndarray, shape (28,)
        The knee, SI.
    tibia_origin : ndarray, shape (2,)
        Its `load_free_position`, m.

    Returns
    -------
    ndarray, shape (4, 2, 2)
        Ligament, (femur, tibia), (x, y); femur frame, m.
    """
    ends = np.array(
        [
            [
                [x[NAMES.index(f"{name}_{bone}_{axis}")] for axis in "xy"]
                for bone in ("femur", "tibia")
            ]
            for name in LIGAMENTS
        ]
    )
    ends[:, 1] = _turned(ends[:, 1]) + tibia_origin
    return ends


def geometry_changes(worst: SearchResult) -> tuple[GeometryChange, GeometryChange]:
    """Return how the two worst-case knees differ from the baseline."""
    baseline = worst.model.nominal
    slope = baseline[_SLOPE]
    along = _turned(np.array([np.cos(slope), np.sin(slope)]))
    across = np.array([-along[1], along[0]])
    before = ligament_lines(baseline, worst.responses["baseline"].load_free_position)
    changes = []
    for x, response in zip(
        worst.x, (worst.responses["model_1"], worst.responses["model_2"]), strict=True
    ):
        after = ligament_lines(x, response.load_free_position)
        shift = (after - before).reshape(8, 2)
        turn = _direction(after) - _direction(before)
        circle = 1e3 * (x[_CENTRE] - baseline[_CENTRE])
        changes.append(
            GeometryChange(
                along_mm=1e3 * shift @ along,
                across_mm=1e3 * shift @ across,
                circle_along_mm=float(circle @ along),
                circle_across_mm=float(circle @ across),
                slope_deg=float(np.degrees(x[_SLOPE] - slope)),
                angle_deg=np.degrees((turn + np.pi) % (2.0 * np.pi) - np.pi),
                stiffness_percent=100.0 * (x[_STIFFNESS] / baseline[_STIFFNESS] - 1.0),
            )
        )
    return changes[0], changes[1]


def place_differences_mm(one: SearchResult, other: SearchResult) -> FloatArray:
    """Return how far apart two searches' worst cases place each of `STRUCTURES`.

    Model 1 is held against model 1, and 2 against 2, in the load-free pose.

    Returns
    -------
    ndarray, shape (6,)
        The larger distance of the two models, mm: of a ligament that of the attachment further
        apart, of the circle that of its outline, of the plateau that of its line's ends.
    """
    found = []
    for k, name in enumerate(("model_1", "model_2")):
        lines, drawn = zip(*(_drawn(run, k, name) for run in (one, other)), strict=True)
        ligaments = np.linalg.norm(lines[0] - lines[1], axis=2).max(axis=1)
        change = np.abs(drawn[0] - drawn[1])
        circle = np.hypot(*change[:2]) + change[2]
        found.append([*(1e3 * ligaments), 1e3 * circle, _PLATEAU_END_MM * change[3]])
    distances: FloatArray = np.array(found).max(axis=0)
    return distances


def _drawn(run: SearchResult, k: int, name: str) -> tuple[FloatArray, FloatArray]:
    """Return a knee's ligaments, m, and its circle (x, y, radius, m) and plateau's slope, rad."""
    x = run.x[k]
    lines = ligament_lines(x, run.responses[name].load_free_position)
    return lines, np.array([*x[_CENTRE], x[_RADIUS], x[_SLOPE]])


def _direction(lines: FloatArray) -> FloatArray:
    """Return the angle of each line from tibia to femur, shape (4,), rad."""
    vector = lines[:, 0] - lines[:, 1]
    angle: FloatArray = np.arctan2(vector[:, 1], vector[:, 0])
    return angle

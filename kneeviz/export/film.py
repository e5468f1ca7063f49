"""The three knees of a result at the same moments of the motion, as numbers to draw."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore import NAMES, SearchResult
from kneeviz.geometry.bones import bones
from kneeviz.geometry.mechanism import Pose, contact_point, ligament_segments, to_femur
from kneeviz.geometry.sweep import Sweep, sweep_of
from kneeviz.state import results

FloatArray = NDArray[np.float64]

FRAMES = 49
"""Moments from full extension to full flexion."""
_MARGIN = 6.0  # mm


@dataclass(frozen=True, kw_only=True, eq=False)
class Filmed:
    """One knee in the film."""

    name: str
    """`baseline`, `model_1` or `model_2`."""
    sweep: Sweep
    poses: tuple[Pose, ...]
    """One a frame."""

    @property
    def angle_deg(self) -> FloatArray:
        """Flexion in each frame, shape (frames,), deg."""
        return np.degrees([pose.flexion for pose in self.poses])

    @property
    def ligaments_mm(self) -> FloatArray:
        """Both ends of the four ligaments in each frame, shape (frames, 4, 2, 2), mm."""
        return 1e3 * np.array([ligament_segments(self.sweep.x, pose) for pose in self.poses])

    @property
    def tibia_mm(self) -> FloatArray:
        """The tibia's origin in the femur frame in each frame, shape (frames, 2), mm."""
        return 1e3 * np.array([pose.tibia_position for pose in self.poses])

    @property
    def contact_mm(self) -> FloatArray:
        """Where condyle and plateau touch in each frame, shape (frames, 2), mm."""
        return 1e3 * np.array([contact_point(self.sweep.x, pose) for pose in self.poses])


@dataclass(frozen=True, kw_only=True, eq=False)
class Film:
    """The knees of a result, those left out for which the model failed."""

    moment: FloatArray
    """N m in each frame, falling, shape (frames,)."""
    knees: tuple[Filmed, ...]

    def window_mm(self) -> tuple[float, float, float, float]:
        """Return left, right, bottom and top of what all frames need, mm."""
        points = [1e3 * bone.outline for bone in bones() if bone.frame == "femur"]
        for bone in bones():
            if bone.frame == "tibia":
                points += [
                    1e3 * to_femur(bone.outline, pose.flexion, pose.tibia_position)
                    for knee in self.knees
                    for pose in knee.poses
                ]
        every = np.concatenate(points)
        (left, bottom), (right, top) = every.min(axis=0) - _MARGIN, every.max(axis=0) + _MARGIN
        return float(left), float(right), float(bottom), float(top)


def film_of(result: SearchResult, frames: int = FRAMES) -> Film:
    """Return a result's film; without knees if the model failed for all three.

    Equal steps of the film turn the first of its knees by equal angles.
    """
    model = results.of_knees(result).model
    strain_free = results.rest_length(result) == "recomputed" and len(model.lower) == len(NAMES)
    sweeps = {
        name: sweep_of(x, result.responses[name], strain_free=strain_free)
        for name, x in zip(result.responses, (model.nominal, *result.x), strict=True)
    }
    shown = {name: sweep for name, sweep in sweeps.items() if sweep is not None}
    if not shown:
        return Film(moment=np.empty(0), knees=())
    leading = next(iter(shown.values()))
    moment = np.array([leading.moment_at(share) for share in np.linspace(0.0, 1.0, frames)])
    knees = (
        Filmed(name=name, sweep=sweep, poses=tuple(sweep.at_moment(m) for m in moment))
        for name, sweep in shown.items()
    )
    return Film(moment=moment, knees=tuple(knees))

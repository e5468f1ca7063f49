"""Measures of single knees: the baseline, and the two worst cases of the main search."""

import numpy as np
from numpy.typing import NDArray

from kneecore.knee.parameters import LIGAMENTS
from kneecore.knee.physics.forces import THETA_0
from kneecore.knee.response import LARGEST_EXTENSION, LARGEST_FLEXION, MOMENT, Response
from kneecore.paper.experiments import Experiments
from kneecore.paper.geometry_changes import ligament_lines

__all__ = [
    "ap_slope_ratio",
    "ap_slopes",
    "baseline_cruciate_force_n",
    "baseline_extension_deg",
    "baseline_flexion_deg",
    "baseline_overshoot_percent",
    "baseline_settled_loads",
    "beyond_sampling_deg",
    "cruciates_cross",
    "early_pcl_ratio",
    "force_ratio_at_minus_10_deg",
    "model_1_extension_deg",
    "model_2_extension_deg",
    "tension_at",
]

FloatArray = NDArray[np.float64]
_ACL, _PCL = LIGAMENTS.index("acl"), LIGAMENTS.index("pcl")
_EXTENSION = np.flatnonzero(MOMENT > 0)
_FLEXION = np.flatnonzero(MOMENT < 0)


def _degrees(response: Response, load: int) -> float:
    return float(np.degrees(response.flexion[load]))


def baseline_extension_deg(done: Experiments) -> float:
    """Angle of the baseline at 5 N m of extension."""
    return _degrees(done.main.responses["baseline"], LARGEST_EXTENSION)


def baseline_flexion_deg(done: Experiments) -> float:
    """Angle of the baseline at 5 N m of flexion."""
    return _degrees(done.main.responses["baseline"], LARGEST_FLEXION)


def baseline_settled_loads(done: Experiments) -> float:
    """Count the loads at which the baseline has come to rest."""
    return float(np.count_nonzero(done.main.responses["baseline"].settled))


def baseline_overshoot_percent(done: Experiments) -> float:
    """Largest angle by which a load carries the baseline past its own end, in % of its turn."""
    motion = done.motion
    worst = 0.0
    for angles, moments in zip(motion.flexion, motion.moment, strict=True):
        starts = np.flatnonzero(np.diff(moments)) + 1
        for frames in np.split(np.arange(len(angles)), starts)[1:]:
            turn = angles[frames] - angles[frames[0] - 1]
            worst = max(worst, float((turn / turn[-1]).max() - 1.0))
    return 100.0 * worst


def baseline_cruciate_force_n(done: Experiments) -> float:
    """Largest ACL or PCL tension of the baseline over the 12 loads."""
    return float(done.main.responses["baseline"].tension[:, [_ACL, _PCL]].max())


def cruciates_cross(done: Experiments) -> float:
    """Return 1 if the baseline's cruciates cross in the load-free pose, 0 if not."""
    lines = ligament_lines(
        done.knee.space.baseline, done.main.responses["baseline"].load_free_position
    )
    (a, b), (c, d) = lines[_ACL], lines[_PCL]
    parted = _side(a, b, c) * _side(a, b, d) < 0 and _side(c, d, a) * _side(c, d, b) < 0
    return float(parted)


def _side(start: FloatArray, end: FloatArray, point: FloatArray) -> float:
    """Tell on which side of a line a point lies, by the sign of an area."""
    along, off = end - start, point - start
    return float(along[0] * off[1] - along[1] * off[0])


def ap_slopes(response: Response) -> tuple[float, float]:
    """Return a knee's slope of contact position over angle, mm/deg, before and beyond 54.79 deg.

    By least squares through the loads on that side; negative: the contact moves back with flexion.
    NaN for a failed knee, and for one with less than two loads on that side.
    """
    angles = np.degrees(response.flexion)
    position = 1e3 * response.ap_position
    beyond = angles > np.degrees(THETA_0)
    before = _slope(angles[~beyond], position[~beyond])
    return before, _slope(angles[beyond], position[beyond])


def _slope(x: FloatArray, y: FloatArray) -> float:
    if len(x) < 2 or not np.isfinite([x, y]).all():
        return float("nan")
    return float(np.polyfit(x, y, 1)[0])


def ap_slope_ratio(done: Experiments) -> float:
    """Slope of the baseline's contact position beyond the load-free angle over that before it."""
    before, beyond = ap_slopes(done.main.responses["baseline"])
    return beyond / before


def model_1_extension_deg(done: Experiments) -> float:
    """Angle of the over-extending worst case at 5 N m of extension."""
    return _degrees(done.main.responses["model_1"], LARGEST_EXTENSION)


def model_2_extension_deg(done: Experiments) -> float:
    """Angle of the other worst case at 5 N m of extension."""
    return _degrees(done.main.responses["model_2"], LARGEST_EXTENSION)


def tension_at(response: Response, angle_deg: float) -> FloatArray:
    """Return the tensions at an angle, shape (4,), N; NaN beyond the knee's reach.

    Interpolated between the loads of extension if the angle is below the load-free one, and of
    flexion if it is above; in the load-free pose all are slack.
    """
    free = np.degrees(THETA_0)
    loads = _EXTENSION if angle_deg < free else _FLEXION
    angles = np.append(np.degrees(response.flexion[loads]), free)
    tensions = np.vstack([response.tension[loads], np.zeros(len(LIGAMENTS))])
    order = np.argsort(angles)
    return np.array(
        [
            np.interp(angle_deg, angles[order], column[order], left=np.nan, right=np.nan)
            for column in tensions.T
        ]
    )


def force_ratio_at_minus_10_deg(done: Experiments) -> float:
    """Largest tension of the over-extending knee at -10 deg over the baseline's at 5 N m."""
    most = float(tension_at(done.main.responses["model_1"], -10.0).max())
    return most / float(done.main.responses["baseline"].tension[LARGEST_EXTENSION].max())


def early_pcl_ratio(done: Experiments) -> float:
    """PCL tension of model 2 at 5 N m of extension over the baseline's at the same angle."""
    stopped = done.main.responses["model_2"]
    usual = tension_at(done.main.responses["baseline"], _degrees(stopped, LARGEST_EXTENSION))[_PCL]
    return float(stopped.tension[LARGEST_EXTENSION, _PCL] / usual) if usual > 0.0 else float("nan")


def beyond_sampling_deg(done: Experiments) -> float:
    """How far the nearer worst case lies outside of mean +- 3 sd at 5 N m of extension."""
    spread = done.sampling.y
    below = spread.sigma_lower[LARGEST_EXTENSION] - model_1_extension_deg(done)
    above = model_2_extension_deg(done) - spread.sigma_upper[LARGEST_EXTENSION]
    return float(np.minimum(below, above))

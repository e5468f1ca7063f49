"""What follows from a knee and its poses without a motion, in plain NumPy: files are held to it.

The kernels of `kneecore.knee.physics` compute the same. This is written apart from them, so that a
file is read without compiling anything, and by the textbook's way: the tibia's origin and its turn,
no mass centre.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore.knee.parameters import LIGAMENTS, N_PARAMETERS
from kneecore.knee.physics.forces import THETA_0
from kneecore.knee.physics.pose import STATION

__all__ = ["LoadFree", "Observed", "load_free", "observed"]

FloatArray = NDArray[np.float64]
_N_LIGAMENTS = len(LIGAMENTS)


@dataclass(frozen=True, kw_only=True, eq=False)
class LoadFree:
    """A knee without load."""

    rest_length: FloatArray
    """Of the four ligaments, shape (4,), m."""
    position: FloatArray
    """The tibia's origin in the femur frame, shape (2,), m."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Observed:
    """What can be read off k poses of a knee."""

    tension: FloatArray
    """Shape (k, 4), N."""
    contact_force: FloatArray
    """Shape (k,), N."""
    indentation: FloatArray
    """Shape (k,), m."""
    ap_position: FloatArray
    """Shape (k,), m."""


def _turns(flexion: FloatArray) -> FloatArray:
    """Return the rotations of the tibia, shape (..., 2, 2), for flexion angles, rad."""
    c, s = np.cos(flexion), np.sin(flexion)
    turns: FloatArray = np.stack([np.stack([c, s], axis=-1), np.stack([-s, c], axis=-1)], axis=-2)
    return turns


def _attachments(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the ligaments' attachments in the femur and in the tibia, shape (4, 2) each."""
    ends = x[: 4 * _N_LIGAMENTS].reshape(_N_LIGAMENTS, 2, 2)
    return ends[:, 0], ends[:, 1]


def _plateau(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the plateau's point, tangent and normal in the tibia, shape (2,) each."""
    c, s = np.cos(x[21]), np.sin(x[21])
    return x[19:21], np.array([c, s]), np.array([-s, c])


def load_free(x: FloatArray, baseline: FloatArray, *, fixed: bool) -> LoadFree:
    """Return the load-free pose of a knee and its ligaments' rest lengths.

    Parameters
    ----------
    x, baseline : ndarray, shape (28,) or (32,)
        The knee, and the one that fixes the pose, SI.
    fixed : bool
        Whether the ligaments are as long as the baseline's.
    """
    turn = _turns(np.array(THETA_0))
    point, tangent, normal = _plateau(baseline)
    touching = point + STATION * tangent + baseline[18] * normal
    first = baseline[16:18] - turn @ touching

    def placed(knee: FloatArray) -> tuple[FloatArray, FloatArray]:
        point, _, normal = _plateau(knee)
        along = turn @ normal
        gap = along @ (knee[16:18] - first - turn @ point) - knee[18]
        position = first + gap * along
        femoral, tibial = _attachments(knee)
        return position, np.linalg.norm(femoral - position - tibial @ turn.T, axis=1)

    position, lengths = placed(x)
    if fixed:
        lengths = placed(baseline)[1]
    if len(x) > N_PARAMETERS:
        lengths = lengths + x[N_PARAMETERS:]
    return LoadFree(rest_length=lengths, position=position)


def observed(
    x: FloatArray, rest_length: FloatArray, flexion: FloatArray, position: FloatArray
) -> Observed:
    """Return the forces and the contact in poses of a knee.

    Parameters
    ----------
    x : ndarray, shape (28,) or (32,)
    rest_length : ndarray, shape (4,)
    flexion : ndarray, shape (k,)
        rad
    position : ndarray, shape (k, 2)
        The tibia's origin in the femur frame, m.
    """
    turns = _turns(flexion)
    femoral, tibial = _attachments(x)
    reach = femoral - position[:, None] - np.einsum("kij,lj->kli", turns, tibial)
    stretch = np.maximum(np.linalg.norm(reach, axis=2) - rest_length, 0.0)
    point, tangent, normal = _plateau(x)
    centre = x[16:18] - position - turns @ point
    indentation = np.maximum(x[18] - ((turns @ normal) * centre).sum(axis=1), 0.0)
    compliance = 2.0 * (1.0 - x[27] ** 2) / x[26]
    return Observed(
        tension=x[22:26] * stretch**2,
        contact_force=4.0 / 3.0 * np.sqrt(x[18]) / compliance * indentation**1.5,
        indentation=indentation,
        ap_position=((turns @ tangent) * centre).sum(axis=1),
    )

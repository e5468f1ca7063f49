"""Two marks beside `settled`: whether an angle is the equilibrium's, and a pose one of a knee."""

import math

import numpy as np
from numpy.typing import NDArray

from kneecore.knee.physics.dynamics import flexion_of
from kneecore.knee.physics.equilibrium import followed
from kneecore.knee.physics.pose import RADIUS

__all__ = ["at_rest", "implausible"]

AT_REST_ANGLE = math.radians(0.1)
"""By this much an angle at rest may differ from the equilibrium of the same knee and load."""
LEAST_FLEXION, MOST_FLEXION = math.radians(-60.0), math.radians(170.0)
MOST_INDENTATION = 0.5
"""Share of the circle's radius."""

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


def at_rest(rows: FloatArray, poses: FloatArray, threads: int | None = None) -> BoolArray:
    """Tell which poses (n, 12, 3) are within 0.1 deg of the same knee's equilibrium, (n, 12).

    False where the knee has no equilibrium that could be followed, and where it failed.
    """
    found, _ = followed(rows, threads)
    near: BoolArray = np.abs(poses[..., 2] - found[..., 2]) <= AT_REST_ANGLE
    return near


def implausible(rows: FloatArray, poses: FloatArray, indentation: FloatArray) -> BoolArray:
    """Tell which poses (n, 12, 3) no knee takes, (n, 12); false of a failed model's."""
    theta = flexion_of(poses)
    deep = indentation > MOST_INDENTATION * rows[:, RADIUS, None]
    outside: BoolArray = (theta < LEAST_FLEXION) | (theta > MOST_FLEXION) | deep
    return outside

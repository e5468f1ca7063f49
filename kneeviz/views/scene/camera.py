"""From where the camera looks: in front of the knee, from its side, or before the landscape."""

import numpy as np
from numpy.typing import NDArray

from kneeviz.geometry.framing import FIELD_OF_VIEW, Frame

FloatArray = NDArray[np.float64]


def _towards(turn_deg: float, rise_deg: float) -> FloatArray:
    turn, rise = np.deg2rad([turn_deg, rise_deg])
    return np.array([np.sin(turn) * np.cos(rise), np.sin(rise), np.cos(turn) * np.cos(rise)])


FRONT, ASIDE, BEFORE_LANDSCAPE = _towards(0.0, 0.0), _towards(38.0, 16.0), _towards(36.0, 27.0)
"""From the middle to the camera: for the flat view, for 3D and for the landscape."""
FIRST = Frame(centre=np.array([-0.031, -0.008, 0.0]), half_height=0.157)
"""What a camera shows before its window is known."""


def position(frame: Frame, direction: FloatArray) -> FloatArray:
    """Return where a camera stands to show a frame, shape (3,), m."""
    placed: FloatArray = frame.centre + direction * frame.half_height / np.tan(0.5 * FIELD_OF_VIEW)
    return placed

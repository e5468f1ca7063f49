"""Where the camera stands: in front of the knee, to its side, or before the landscape."""

import numpy as np

from kneeviz.geometry import surfaces

FIELD_OF_VIEW = np.deg2rad(10.0)
"""Narrow, so that perspective does not show: there is no orthographic camera."""
CENTRE = (-0.031, -0.008, 0.0)
HALF_HEIGHT = 0.157
DISTANCE = HALF_HEIGHT / np.tan(0.5 * FIELD_OF_VIEW)


def knee_position(spatial: bool) -> tuple[float, float, float]:
    """Return where the camera stands: in front, or for the 3D view to the side and above."""
    if not spatial:
        return CENTRE[0], CENTRE[1], float(DISTANCE)
    turn, rise = np.deg2rad(38.0), np.deg2rad(16.0)
    return (
        CENTRE[0] + float(DISTANCE * np.sin(turn) * np.cos(rise)),
        CENTRE[1] + float(DISTANCE * np.sin(rise)),
        float(DISTANCE * np.cos(turn) * np.cos(rise)),
    )


def landscape_position() -> tuple[float, float, float]:
    """Return where the camera stands: in front, to the right and above."""
    turn, rise = np.deg2rad(36.0), np.deg2rad(27.0)
    x, y, z = surfaces.CENTRE
    return (
        x + float(DISTANCE * np.sin(turn) * np.cos(rise)),
        y + float(DISTANCE * np.sin(rise)),
        z + float(DISTANCE * np.cos(turn) * np.cos(rise)),
    )

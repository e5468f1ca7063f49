"""Where the ligaments' names stand: off their ligaments, away from each other."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_LABEL_BOX = (0.034, 0.0125)  # m, a label's room in the flat view


def label_spots(segments: FloatArray) -> FloatArray:
    """Return places for the four names: off their ligaments, away from each other."""
    share = np.array([0.15, 0.85, 0.62, 0.70])  # of the way from femur to tibia
    along = segments[:, 1] - segments[:, 0]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)  # anterior of the ligament
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    offset = np.array([0.020, -0.022, 0.020, -0.024])[:, None] * across
    return spread_labels(segments[:, 0] + share[:, None] * along + offset, _LABEL_BOX)


def spread_labels(anchors: FloatArray, size: tuple[float, float], rounds: int = 60) -> FloatArray:
    """Return places near `anchors` at which boxes of `size` do not overlap.

    Parameters
    ----------
    anchors : ndarray, shape (n, 2)
        Where the boxes' centres would like to be.
    size : tuple of float
        Width and height of a box, in the anchors' unit.
    rounds : int
        Most sweeps over all pairs.
    """
    placed = np.array(anchors, dtype=np.float64)
    for _ in range(rounds):
        moved = False
        for i in range(len(placed)):
            for j in range(i):
                moved |= _push_apart(placed, i, j, size)
        if not moved:
            break
    return placed


def _push_apart(placed: FloatArray, i: int, j: int, size: tuple[float, float]) -> bool:
    gap = placed[i] - placed[j]
    overlap = np.array(size) - np.abs(gap)
    if (overlap <= 1e-12).any():
        return False
    axis = int(np.argmin(overlap))  # the shorter way out
    shift = 0.5 * overlap[axis] * (1.0 if gap[axis] >= 0.0 else -1.0)
    placed[i, axis] += shift
    placed[j, axis] -= shift
    return True

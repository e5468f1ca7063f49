"""Where the ligaments' names stand: off their ligaments, away from each other."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_NAME, _WITH_FORCE = (0.015, 0.010), (0.034, 0.010)
_GAP = 0.004  # m between a ligament and its label
_SHARE = np.array([0.15, 0.75, 0.62, 0.85])
"""Where the labels stand, of the way from femur to tibia."""
_SIDE = np.array([1.0, -1.0, 1.0, -1.0])
"""Anterior of the ligament or behind it."""


def label_box(*, forces: bool, size: float = 1.0) -> tuple[float, float]:
    """Return a label's width and height in the flat view, m; `size` is the theme's."""
    width, height = _WITH_FORCE if forces else _NAME
    return size * width, size * height


def label_spots(segments: FloatArray, box: tuple[float, float]) -> FloatArray:
    """Return places for the four names: close to their ligaments, away from each other."""
    along = segments[:, 1] - segments[:, 0]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    away = _SIDE * (_GAP + 0.5 * np.abs(across) @ np.array(box))
    return spread_labels(segments[:, 0] + _SHARE[:, None] * along + away[:, None] * across, box)


def leaders(spots: FloatArray, segments: FloatArray) -> FloatArray:
    """Return lines from the labels to what they name, shape (4, 2, 2)."""
    along = segments[:, 1] - segments[:, 0]
    share = ((spots - segments[:, 0]) * along).sum(axis=1) / (along**2).sum(axis=1)
    nearest = segments[:, 0] + np.clip(share, 0.0, 1.0)[:, None] * along
    return np.stack([spots, nearest], axis=1)


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

"""The picture's geometry: from shapes in any unit to line segments in the scene. Pure functions."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore import Shape

FloatArray = NDArray[np.float64]

WIDTH, HEIGHT = 0.28, 0.28
"""m of the scene that a picture fills at most, around its origin."""
_MARGIN = 0.06
_DASH, _GAP = 0.006, 0.004
_RING = 0.0022
_BAR_SHARE = 0.25
"""Of the picture's width that the scale takes at most."""
_BAR_ABOVE = 0.004
"""m above the frame's lower edge."""
_TURN = np.linspace(0.0, 2.0 * np.pi, 13)


@dataclass(frozen=True, kw_only=True)
class Frame:
    """What part of the picture's plane is shown, in the picture's unit."""

    low: tuple[float, float]
    high: tuple[float, float]

    @property
    def scale(self) -> float:
        """How many m of the scene are one of the picture's unit."""
        width, height = (max(b - a, 1e-300) for a, b in zip(self.low, self.high, strict=True))
        return min(WIDTH / width, HEIGHT / height)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height in the scene, m."""
        width, height = (b - a for a, b in zip(self.low, self.high, strict=True))
        return width * self.scale, height * self.scale

    def place(self, points: FloatArray) -> FloatArray:
        """Return points of the picture, shape (..., 2), in the scene, m."""
        middle = 0.5 * (np.array(self.low) + np.array(self.high))
        placed: FloatArray = (points - middle) * self.scale
        return placed

    def holds(self, points: FloatArray) -> bool:
        """Tell whether all points lie within the frame."""
        return bool((points >= self.low).all() and (points <= self.high).all())


def scale_bar(frame: Frame) -> tuple[float, FloatArray]:
    """Return a round length in the picture's unit, and its line below, in the scene, m.

    The line, shape (3, 2, 2), has an end mark on either side.
    """
    width = frame.high[0] - frame.low[0]
    longest = _BAR_SHARE * max(width, 1e-300)
    power = 10.0 ** np.floor(np.log10(longest))
    length = max(step for step in (power, 2.0 * power, 5.0 * power) if step <= longest * 1.000001)
    left, bottom = -0.5 * frame.size[0], -0.5 * frame.size[1] + _BAR_ABOVE
    right = left + length * frame.scale
    ends = [[[x, bottom - _RING], [x, bottom + _RING]] for x in (left, right)]
    return float(length), np.array([[[left, bottom], [right, bottom]], *ends])


def frame_around(pictures: Iterable[Sequence[Shape]]) -> Frame | None:
    """Return the frame that holds all pictures, with a margin; None without any point."""
    points = [s.points[np.isfinite(s.points).all(axis=1)] for p in pictures for s in p]
    points = [p for p in points if len(p)]
    if not points:
        return None
    every = np.concatenate(points)
    low, high = every.min(axis=0), every.max(axis=0)
    size = float(max(*(high - low), 1e-9 * np.abs(every).max(), 1e-300))
    margin = _MARGIN * size
    return Frame(
        low=(float(low[0]) - margin, float(low[1]) - margin),
        high=(float(high[0]) + margin, float(high[1]) + margin),
    )


def widened(frame: Frame | None, pictures: Sequence[Sequence[Shape]]) -> Frame | None:
    """Return a frame that holds all pictures: the old one if it does, or one that holds both."""
    needed = frame_around(pictures)
    if frame is None or needed is None:
        return needed or frame
    every = np.concatenate([s.points for p in pictures for s in p])
    if frame.holds(every[np.isfinite(every).all(axis=1)]):
        return frame
    low = np.minimum(frame.low, needed.low)
    high = np.maximum(frame.high, needed.high)
    return Frame(low=(float(low[0]), float(low[1])), high=(float(high[0]), float(high[1])))


def segments(shape: Shape, frame: Frame) -> FloatArray:
    """Return a shape's lines in the scene, shape (n, 2, 2), m; those without a place left out."""
    points = frame.place(shape.points)
    if shape.kind == "closed" and len(points) > 2:
        points = np.vstack([points, points[:1]])
    lines = np.stack([points[:-1], points[1:]], axis=1)
    if shape.kind == "link":
        parts = [*map(_dashed, lines), *map(_ring, points)]
    elif len(points) == 1:
        parts = [_ring(points[0])]
    else:
        parts = [lines]
    every = np.concatenate([p for p in parts if len(p)] or [np.zeros((0, 2, 2))])
    known: FloatArray = every[np.isfinite(every).all(axis=(1, 2))]
    return known


def _dashed(line: FloatArray) -> FloatArray:
    """Return the dashes of a line, shape (n, 2, 2)."""
    way = line[1] - line[0]
    length = float(np.hypot(*way))
    if not np.isfinite(length) or length < _DASH:
        return line[None]
    starts = np.arange(0.0, length, _DASH + _GAP)
    ends = np.minimum(starts + _DASH, length)
    dashes: FloatArray = line[0] + np.stack([starts, ends], axis=1)[..., None] * (way / length)
    return dashes


def _ring(centre: FloatArray) -> FloatArray:
    circle = centre + _RING * np.stack([np.cos(_TURN), np.sin(_TURN)], axis=1)
    return np.stack([circle[:-1], circle[1:]], axis=1)

"""The landscape's shapes: from sheets and marks to points in a box. Pure functions of numbers.

The first parameter runs to the right, the second one into the depth, the angle upwards.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneeviz.geometry.picture import Mark, Picture

FloatArray = NDArray[np.float64]

CENTRE = (-0.031, -0.014, 0.0)
"""Middle of the box, m: where the knee stands otherwise."""
SIDE, HEIGHT = 0.124, 0.115
"""Edges of the box's floor and its height, m."""
_MESH_LINES = 9  # lines along each parameter that a sheet shows


_LABEL_ROOM = 0.022
"""Around the box, m."""


def corners() -> FloatArray:
    """Return the corners of the box with its labels, shape (8, 3), m."""
    half = 0.5 * np.array([SIDE, HEIGHT, SIDE]) + _LABEL_ROOM
    signs = np.array(list(product((-1.0, 1.0), repeat=3)))
    placed: FloatArray = np.array(CENTRE) + signs * half
    return placed


def nice_step(span: float, count: int) -> float:
    """Return a step of 1, 2 or 5 times a power of ten that cuts `span` into about `count`."""
    rough = span / count
    power = 10.0 ** np.floor(np.log10(rough))
    return float(power * min((1.0, 2.0, 5.0, 10.0), key=lambda k: abs(k * power - rough)))


_SLACK = 1e-6  # of a bound: rounding


@dataclass(frozen=True, kw_only=True)
class Box:
    """The box around the landscape: its upright axis goes from `low` to `high` (deg)."""

    low: float
    high: float
    step: float
    """Between two numbers on the upright axis, deg."""

    @property
    def digits(self) -> int:
        """Decimals of the numbers on the upright axis."""
        return max(int(np.ceil(-np.log10(self.step) - 1e-9)), 0)

    @property
    def ticks(self) -> list[float]:
        """Numbers on the upright axis, deg."""
        count = round((self.high - self.low) / self.step)
        return [self.low + k * self.step for k in range(count + 1)]

    def holds(self, value: ArrayLike) -> NDArray[np.bool_]:
        """Tell which values lie within the box's height."""
        return (np.asarray(value) >= self.low) & (np.asarray(value) <= self.high)

    def has(self, mark: Mark) -> bool:
        """Tell whether a mark lies within the box."""
        beside = any(not -_SLACK <= p <= 1.0 + _SLACK for p in mark.place)
        return not beside and bool(self.holds(mark.value))

    def place(self, first: ArrayLike, second: ArrayLike, value: ArrayLike) -> FloatArray:
        """Return points of the scene, shape (..., 3), m.

        Parameters
        ----------
        first, second : array_like
            Places between the bounds of the two parameters, 0 to 1.
        value : array_like
            deg
        """
        along = CENTRE[0] + SIDE * (np.asarray(first) - 0.5)
        share = (np.asarray(value) - self.low) / (self.high - self.low)
        up = CENTRE[1] + HEIGHT * (share - 0.5)
        deep = CENTRE[2] - SIDE * (np.asarray(second) - 0.5)
        return np.stack(np.broadcast_arrays(along, up, deep), axis=-1)


def box_around(shown: Picture, *, zoom: bool) -> Box:
    """Return the box that holds all knees, or (`zoom`) the sheets and the visitor's knee only.

    At its ends are whole steps.
    """
    marks = [shown.own, shown.predicted, *(() if zoom else shown.worst)]
    values = [shown.model.ravel(), np.array([m.value for m in marks if m is not None])]
    if shown.surrogate is not None:
        values.append(shown.surrogate.ravel())
    if not zoom:
        values.append(shown.training[:, 2])
    every = np.concatenate(values)
    low, high = float(np.nanmin(every)), float(np.nanmax(every))
    spare = max(shown.least_span - (high - low), 0.0)
    low, high = low - 0.5 * spare, high + 0.5 * spare
    step = nice_step(high - low, 5)
    low, high = step * np.floor(low / step + 1e-9), step * np.ceil(high / step - 1e-9)
    return Box(low=float(low), high=float(high), step=step)


def _grid(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the places of a sheet's values, each of its shape."""
    first, second = (np.linspace(0.0, 1.0, n) for n in values.shape)
    return first[:, None] + np.zeros(len(second)), second[None, :] + np.zeros((len(first), 1))


def sheet(box: Box, values: FloatArray) -> tuple[FloatArray, NDArray[np.uint32]]:
    """Return the vertices of a sheet (n, k), shape (n * k, 3), m, and its triangles, (t, 3).

    Around a missing value there is a hole.
    """
    known = np.isfinite(values)
    vertices = box.place(*_grid(values), np.where(known, values, box.low)).reshape(-1, 3)
    corner = np.arange(values.size).reshape(values.shape)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return vertices, faces[known.ravel()[faces].all(axis=1)].astype(np.uint32)


def mesh_lines(box: Box, values: FloatArray) -> FloatArray:
    """Return a sheet's lines along both parameters as segments, shape (k, 2, 3), m."""
    points = box.place(*_grid(values), values)
    first, second = (
        np.unique(np.linspace(0, n - 1, _MESH_LINES).round().astype(int)) for n in values.shape
    )
    along = np.stack([points[:-1, second], points[1:, second]], axis=2)
    deep = np.stack([points[first, :-1], points[first, 1:]], axis=2)
    segments = np.concatenate([along.reshape(-1, 2, 3), deep.reshape(-1, 2, 3)])
    known: FloatArray = segments[np.isfinite(segments).all(axis=(1, 2))]
    return known


def frame_lines(box: Box) -> FloatArray:
    """Return the box's floor, its two back walls and their level lines, shape (k, 2, 3), m."""
    lo, hi = box.low, box.high
    edges = [
        ((0, 0, lo), (1, 0, lo)),
        ((1, 0, lo), (1, 1, lo)),
        ((0, 0, lo), (0, 1, lo)),
        ((0, 0, lo), (0, 0, hi)),
        ((0, 1, lo), (0, 1, hi)),
        ((1, 1, lo), (1, 1, hi)),
    ]
    for level in box.ticks:
        edges += [((0, 0, level), (0, 1, level)), ((0, 1, level), (1, 1, level))]
    ends = np.array(edges, dtype=np.float64)
    return box.place(ends[..., 0], ends[..., 1], ends[..., 2])


def stem(box: Box, mark: Mark) -> FloatArray:
    """Return the line from a mark down to the floor, shape (1, 2, 3), m."""
    return box.place(*mark.place, np.array([box.low, mark.value]))[None]


def spot(box: Box, mark: Mark) -> tuple[float, float, float]:
    """Return where a mark stands, m."""
    x, y, z = box.place(*mark.place, mark.value)
    return float(x), float(y), float(z)


def beads(points: FloatArray, ball: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return one mesh of a small ball (vertices, faces) at each of `points`, shape (k, 3)."""
    vertices, faces = ball
    placed = (points[:, None] + vertices[None]).reshape(-1, 3)
    shifts = len(vertices) * np.arange(len(points))[:, None, None]
    return placed, (faces[None] + shifts).reshape(-1, 3)

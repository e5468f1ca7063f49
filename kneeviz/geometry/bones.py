"""From outlines to meshes: the shapes of the bones. Pure functions of numbers, in mm or m as said.

The bones are illustrative. A closed smooth curve runs through an outline's points, its inside is
triangulated and extruded, and in 3D the surface bulges with the distance from the rim.
"""

import tomllib
from dataclasses import dataclass
from functools import cache

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import Delaunay

from kneecore import asset_path

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_SAMPLES = 6  # points of the curve between two points of an outline
_SPACING = 5.0  # mm, of the inner points of a mesh
_RIM = 0.1  # thickness at the rim, as a share of the full one
_BULGE = 22.0  # mm, distance from the rim at which a bone reaches its full depth


@dataclass(frozen=True, kw_only=True, eq=False)
class Bone:
    """A bone's outline and mesh in its own frame."""

    name: str
    frame: str
    """femur or tibia: the body that it moves with."""
    outline: FloatArray
    """Closed curve without its repeated first point, shape (n, 2), m."""
    vertices: FloatArray
    """Of the bulging surface, shape (v, 3), m."""
    faces: IntArray
    """Shape (f, 3)."""


def smooth_loop(points: FloatArray, samples: int = _SAMPLES) -> FloatArray:
    """Return a closed centripetal Catmull-Rom curve through `points`.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        At least three distinct points, in order.
    samples : int
        Points of the curve for each of `points`.

    Returns
    -------
    ndarray, shape (n * samples, 2)
    """
    p0, p1, p2, p3 = (np.roll(points, shift, axis=0)[:, None] for shift in (1, 0, -1, -2))
    # The centripetal form neither overshoots nor loops between points of uneven spacing.
    d1, d2, d3 = (
        np.sqrt(np.linalg.norm(b - a, axis=-1, keepdims=True))
        for a, b in ((p0, p1), (p1, p2), (p2, p3))
    )
    t1, t2, t3 = d1, d1 + d2, d1 + d2 + d3
    t = t1 + d2 * np.linspace(0.0, 1.0, samples, endpoint=False)[None, :, None]
    a1 = (t1 - t) / t1 * p0 + t / t1 * p1
    a2 = (t2 - t) / d2 * p1 + (t - t1) / d2 * p2
    a3 = (t3 - t) / d3 * p2 + (t - t2) / d3 * p3
    b1 = (t2 - t) / t2 * a1 + t / t2 * a2
    b2 = (t3 - t) / (t3 - t1) * a2 + (t - t1) / (t3 - t1) * a3
    curve: FloatArray = (t2 - t) / d2 * b1 + (t - t1) / d2 * b2
    return curve.reshape(-1, 2)


def inside(points: FloatArray, loop: FloatArray) -> NDArray[np.bool_]:
    """Tell which of `points`, shape (n, 2), lie inside the closed polygon `loop`, shape (m, 2)."""
    a, b = loop, np.roll(loop, -1, axis=0)
    x, y = points[:, :1], points[:, 1:]
    straddles = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(b[:, 1] == a[:, 1], 1.0, b[:, 1] - a[:, 1])
    crossing = a[:, 0] + (y - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
    return np.asarray((straddles & (x < crossing)).sum(axis=1) % 2 == 1)


def distance_to_loop(points: FloatArray, loop: FloatArray) -> FloatArray:
    """Return the distance of each of `points`, shape (n, 2), from the closed polygon `loop`."""
    a, edge = loop, np.roll(loop, -1, axis=0) - loop
    offset = points[:, None] - a
    along = np.clip((offset * edge).sum(-1) / (edge * edge).sum(-1), 0.0, 1.0)
    gap: FloatArray = np.linalg.norm(offset - along[..., None] * edge, axis=-1).min(axis=1)
    return gap


def triangulate(loop: FloatArray, spacing: float = _SPACING) -> tuple[FloatArray, IntArray]:
    """Return points, shape (p, 2), and triangles, shape (t, 3), that fill the polygon `loop`.

    The first ``len(loop)`` points are the polygon's own.
    """
    low, high = loop.min(axis=0), loop.max(axis=0)
    x, y = np.meshgrid(*(np.arange(lo, hi, spacing) for lo, hi in zip(low, high, strict=True)))
    grid = np.column_stack([x.ravel(), y.ravel()])
    grid = grid[inside(grid, loop)]
    # Points near the rim could tear a triangle out of it.
    grid = grid[distance_to_loop(grid, loop) > 0.8 * spacing]
    points = np.vstack([loop, grid])
    triangles = Delaunay(points).simplices.astype(np.int64)
    kept = triangles[inside(points[triangles].mean(axis=1), loop)]
    first, second, third = (points[kept[:, i]] for i in range(3))
    one, two = second - first, third - first
    backwards = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0] < 0.0
    kept[backwards] = kept[backwards][:, ::-1]
    return points, kept


def bulge(loop: FloatArray, depth: float, centre: float) -> tuple[FloatArray, IntArray]:
    """Return vertices and faces of a body with the outline `loop`, rounded towards its rim.

    Parameters
    ----------
    loop : ndarray, shape (m, 2)
        Closed outline, mm.
    depth, centre : float
        Half the thickness and the middle of the body across the outline's plane, mm.
    """
    points, triangles = triangulate(loop)
    body = trimesh.creation.extrude_triangulation(points, triangles, height=2.0)
    vertices = np.array(body.vertices)
    reach = np.clip(distance_to_loop(vertices[:, :2], loop) / _BULGE, 0.0, 1.0)
    height = depth * np.maximum(np.sqrt(1.0 - (1.0 - reach) ** 2), _RIM)
    vertices[:, 2] = centre + (vertices[:, 2] - 1.0) * height
    return vertices, np.array(body.faces, dtype=np.int64)


@cache
def bones() -> tuple[Bone, ...]:
    """Return the packaged bones: femur, tibia and fibula, in m."""
    document = tomllib.loads(asset_path("outlines.toml").read_text(encoding="utf-8"))
    return tuple(_bone(name, entry) for name, entry in document.items())


def _bone(name: str, entry: dict[str, object]) -> Bone:
    loop = smooth_loop(np.array(entry["points"], dtype=np.float64))
    vertices, faces = bulge(loop, float(str(entry["depth"])), float(str(entry["centre"])))
    return Bone(
        name=name,
        frame=str(entry["frame"]),
        outline=1e-3 * loop,
        vertices=1e-3 * vertices,
        faces=faces,
    )

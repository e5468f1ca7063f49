"""Lines and meshes as nodes of the scene, in thin layers across the sagittal plane."""

import numpy as np
import viser
from numpy.typing import NDArray

from kneeviz.geometry.bones import Bone

FloatArray = NDArray[np.float64]

FLAT = 0.002
"""Share of the bones' depth that the flat view keeps."""
LAYER = 4e-4
"""m between the flat view's layers."""
RIM_WIDTH = 2.0
"""Pixels, of a bone's outline."""
_OVERLAY_OPACITY = 0.30


def lift(segments: FloatArray, depth: FloatArray | float) -> NDArray[np.float32]:
    """Return plane segments, shape (n, 2, 2), at a depth across the plane, shape (n, 2, 3)."""
    lifted = np.empty((*segments.shape[:-1], 3), dtype=np.float32)
    lifted[..., :2] = segments
    lifted[..., 2] = np.reshape(depth, (-1, 1)) if np.ndim(depth) else depth
    return lifted


def _chain(loop: FloatArray) -> FloatArray:
    return np.stack([loop, np.roll(loop, -1, axis=0)], axis=1)


def opacity(spatial: bool, ghost: bool, share: float) -> float | None:
    """Return a bone's opacity, None for a solid one; `share` fades an overlay (ghost) in."""
    if ghost:
        return _OVERLAY_OPACITY * share
    return 0.45 if spatial else None


def add_line(
    scene: viser.SceneApi, name: str, segments: FloatArray, depth: float, width: float
) -> viser.LineSegmentsHandle:
    """Add plane segments, shape (n, 2, 2), at a depth (m); `width` is in pixels."""
    return scene.add_line_segments(
        name,
        points=lift(segments, depth),
        colors=(128, 128, 128),
        thickness=width,
        thickness_units="screen",
    )


def add_mesh(scene: viser.SceneApi, name: str, bone: Bone, layer: int) -> viser.MeshHandle:
    """Add a bone's surface."""
    return scene.add_mesh_simple(
        name,
        vertices=bone.vertices.astype(np.float32),
        faces=bone.faces.astype(np.uint32),
        color=(230, 220, 200),
        side="double",
        cast_shadow=False,
        receive_shadow=False,
        position=(0.0, 0.0, layer * LAYER),
    )


def add_rim(scene: viser.SceneApi, name: str, bone: Bone, layer: float) -> viser.LineSegmentsHandle:
    """Add a bone's outline, which the flat view shows."""
    return add_line(scene, name, _chain(bone.outline), layer * LAYER, RIM_WIDTH)

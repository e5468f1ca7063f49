"""The visitor's earlier knees in the scene: outlines alone."""

from collections.abc import Sequence

import numpy as np
import viser
from numpy.typing import NDArray

from kneeviz.geometry.bones import bones
from kneeviz.geometry.mechanism import Pose, circle, ligament_segments, quaternion
from kneeviz.state.ghosts import MOST
from kneeviz.views import theme
from kneeviz.views.scene.nodes import LAYER, add_line, add_rim, lift

FloatArray = NDArray[np.float64]

_LAYER = 5.5
"""Before the bones, behind the lines of the present knee, which may be in the same places."""
_WIDTH = 1.5
"""Pixels."""
_PALE = (0.35, 0.5, 0.65)
"""How far towards the bones' colour: the older, the paler."""


class Ghosts:
    """The nodes of all ghosts."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._roots, self._tibias, self._lines = [], [], []
        self._rims: list[list[viser.LineSegmentsHandle]] = []
        tibial = [bone for bone in bones() if bone.frame == "tibia"]
        for i in range(MOST):
            name = f"/ghost_{i + 1}"
            self._roots.append(scene.add_frame(name, show_axes=False, visible=False))
            self._tibias.append(scene.add_frame(f"{name}/tibia", show_axes=False))
            self._rims.append(
                [add_rim(scene, f"{name}/tibia/{b.name}_rim", b, _LAYER) for b in tibial]
            )
            self._lines.append(add_line(scene, f"{name}/lines", np.zeros((1, 2, 2)), 0.0, 1.0))

    def paint(self, colours: theme.Palette) -> None:
        """Take the colours and sizes of a theme."""
        hue = theme.rgb(colours.ghost)
        for pale, line, rims in zip(_PALE, self._lines, self._rims, strict=True):
            for handle in (line, *rims):
                handle.colors = theme.handle_colour(theme.mix(hue, colours.bone, pale))
                handle.thickness = _WIDTH * colours.size

    def draw(self, knees: Sequence[tuple[FloatArray, Pose]]) -> None:
        """Draw knees with the parameters `x` in their poses, the newest first; hide the rest."""
        for i, root in enumerate(self._roots):
            if root.visible != (i < len(knees)):
                root.visible = i < len(knees)
        for (x, pose), tibia, line in zip(knees, self._tibias, self._lines, strict=False):
            tibia.wxyz = quaternion(pose.flexion)
            tibia.position = (*pose.tibia_position, 0.0)
            segments = np.concatenate([circle(x), ligament_segments(x, pose)])
            line.points = lift(segments, _LAYER * LAYER)

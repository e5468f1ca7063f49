"""The scene's nodes: created once, then only moved, coloured, shown and hidden.

Everything lies in the sagittal plane of the femur frame (x anterior, y up), in m. In the flat view
all depths shrink to thin layers, so that what is in front covers what is behind; in the 3D view
the bones have their illustrative depth and the collateral ligaments stand on their own sides.
"""

import numpy as np
import viser
from numpy.typing import NDArray

from kneeviz.geometry.bones import bones
from kneeviz.geometry.mechanism import Pose, contact_arrow, contact_point
from kneeviz.views import theme
from kneeviz.views.scene.beside import Beside
from kneeviz.views.scene.body import Body
from kneeviz.views.scene.ghosts import Ghosts
from kneeviz.views.scene.nodes import (
    FLAT,
    LAYER,
    RIM_WIDTH,
    add_line,
    add_mesh,
    add_rim,
    lift,
    opacity,
)

FloatArray = NDArray[np.float64]

_SPOT_WIDTH, _ARROW_WIDTH = 9.0, 3.0


def _arrow_segments(arrow: FloatArray) -> FloatArray:
    """Return shaft and the head's two barbs, shape (3, 2, 2)."""
    tail, head = arrow
    way = tail - head
    length = float(np.hypot(*way))
    back = way / length if length > 1e-9 else np.array([0.0, 1.0])
    side = np.array([-back[1], back[0]])
    size = min(0.006, 0.5 * length + 1e-6)
    barbs = [head + size * (back + 0.5 * sign * side) for sign in (1.0, -1.0)]
    return np.array([[tail, head], [barbs[0], head], [barbs[1], head]])


class KneeScene:
    """The knee on screen: femur, the visitor's tibia, two overlays, contact and lights."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self.spatial, self.forces = False, False
        self.hidden = False
        self._colours = theme.palette(False)
        scene.set_up_direction("+y")
        scene.configure_environment_map(None)
        scene.configure_default_lights(False)
        self._ambient = scene.add_light_ambient("/light/ambient", intensity=float(np.pi))
        self._sun = scene.add_light_directional(
            "/light/sun", intensity=0.0, position=(0.4, 0.8, 1.0)
        )
        femur = next(bone for bone in bones() if bone.frame == "femur")
        self._roots = [
            scene.add_frame(f"/{name}", show_axes=False) for name in ("knee", "worst_1", "worst_2")
        ]
        self.own = Body(scene, "knee", 0, None)
        self.own.add_labels()
        self._femur = add_mesh(scene, "/knee/femur", femur, 4)
        self._femur_rim = add_rim(scene, "/knee/femur_rim", femur, 5)
        self.overlays = (
            Body(scene, "worst_1", 8, "model_1"),
            Body(scene, "worst_2", 14, "model_2"),
        )
        for overlay in self.overlays:
            overlay.set_visible(False)
        self._beside = Beside(scene, self._roots)
        self.ghosts = Ghosts(scene)
        self._spot = add_line(scene, "/knee/contact", np.zeros((1, 2, 2)), 0.0, _SPOT_WIDTH)
        self._arrow = add_line(scene, "/knee/force", np.zeros((3, 2, 2)), 0.0, _ARROW_WIDTH)
        self.repaint()

    def paint(self, colours: theme.Palette) -> None:
        """Take other colours."""
        self._colours = colours
        self.repaint()

    def repaint(self, *, overlay_share: float = 1.0) -> None:
        """Apply colours and view (flat or 3D) to every node."""
        colours = self._colours
        shaded = self.spatial or self.hidden  # what takes the knee's place is a landscape
        self._ambient.intensity = 1.7 if shaded else float(np.pi)
        self._sun.intensity = 2.2 if shaded else 0.0
        self._femur.color = colours.bone
        self._femur.opacity = opacity(self.spatial, False, 1.0)
        self._femur.scale = (1.0, 1.0, 1.0 if self.spatial else FLAT)
        self._femur_rim.colors = theme.handle_colour(colours.rim)
        self._femur_rim.thickness = RIM_WIDTH * colours.size
        self._femur_rim.visible = not self.spatial
        self._spot.colors = theme.handle_colour(colours.contact)
        self._arrow.colors = theme.handle_colour(colours.arrow)
        self._spot.thickness = _SPOT_WIDTH * colours.size
        self._arrow.thickness = _ARROW_WIDTH * colours.size
        self.ghosts.paint(colours)
        self._beside.paint(colours, self.spatial)
        self.own.paint(colours, self.spatial)
        for overlay in self.overlays:
            overlay.paint(colours, self.spatial, overlay_share)

    def set_hidden(self, hidden: bool) -> None:
        """Hide all knees, or show them again."""
        self.hidden = hidden
        for root in self._roots:
            root.visible = not hidden
        self.ghosts.draw(())
        self.repaint()

    def stand(self, apart: float) -> None:
        """Put both worst cases so far to the sides of the visitor's knee, m; 0 is over it."""
        self._beside.stand(apart)
        self.own.show_labels(apart == 0.0)  # on three small knees they would cover one

    def fade_overlays(self, share: float) -> None:
        """Set how far the overlays have faded in."""
        for overlay in self.overlays:
            overlay.paint(self._colours, self.spatial, share)

    def draw(self, x: FloatArray, pose: Pose) -> None:
        """Draw the visitor's knee with its contact."""
        self.own.draw(x, pose, self._colours, self.spatial)
        self.own.place_labels(x, pose, self._colours, self.spatial, self.forces)
        touching = pose.contact_force > 0.05
        self._spot.visible = self._arrow.visible = touching
        if touching:
            point = contact_point(x, pose)
            half = np.array([[0.0011, 0.0], [-0.0011, 0.0]])
            depth = 0.0 if self.spatial else 14 * LAYER
            self._spot.points = lift((point + half)[None], depth)
            self._arrow.points = lift(_arrow_segments(contact_arrow(x, pose)), depth)

    def draw_overlay(self, index: int, x: FloatArray | None, pose: Pose | None) -> None:
        """Draw worst case `index` (0 or 1), or hide it."""
        body = self.overlays[index]
        if x is None or pose is None:
            body.set_visible(False)
            return
        body.set_visible(True)
        body.draw(x, pose, self._colours, self.spatial)

"""One knee without its femur: tibia, fibula, plateau line, circle and ligaments."""

import numpy as np
import viser
from numpy.typing import NDArray

from kneeviz.geometry.bones import bones
from kneeviz.geometry.mechanism import (
    LIGAMENT_DEPTH,
    TAUT_TENSION,
    Pose,
    circle,
    ligament_segments,
    plateau_line,
    quaternion,
)
from kneeviz.views import theme
from kneeviz.views.scene.labels import label_box, label_spots, leaders
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

FULL_TENSION = 300.0
"""N; at it a ligament has its full width."""
_PLATEAU_WIDTH, _CIRCLE_WIDTH, _LEADER_WIDTH = 2.0, 1.5, 1.2
_IN_FRONT = 30
"""Layer of the visitor's ligaments, before both overlays."""


def ligament_width(tension: float) -> float:
    """Return a ligament's width in pixels: thin when slack, growing with tension when taut."""
    if tension < TAUT_TENSION:
        return 2.0
    return float(3.5 + 6.0 * min(tension / FULL_TENSION, 1.5) ** 0.5)


def ligament_colour(index: int, tension: float, slack: theme.RGB) -> theme.RGB:
    """Return a ligament's colour: grey when slack, then quickly its own hue."""
    hue = theme.rgb(theme.LIGAMENT_COLOURS[index])
    if tension < TAUT_TENSION:
        return slack
    return theme.mix(slack, hue, 0.45 + 0.55 * min(tension / 60.0, 1.0))


class Body:
    """A tibia with its fibula, plateau line and ligaments: the visitor's knee or an overlay."""

    def __init__(self, scene: viser.SceneApi, name: str, layer: int, ghost: str | None) -> None:
        self._scene, self._name, self._layer, self._ghost = scene, name, layer, ghost
        self.frame = scene.add_frame(f"/{name}/tibia", show_axes=False)
        self._meshes, self._rims = [], []
        for bone in bones():
            if bone.frame == "tibia":
                depth = layer - (2 if bone.name == "fibula" else 0)
                self._meshes.append(add_mesh(scene, f"/{name}/tibia/{bone.name}", bone, depth))
                self._rims.append(add_rim(scene, f"/{name}/tibia/{bone.name}_rim", bone, depth + 1))
        self._plateau = add_line(
            scene, f"/{name}/tibia/plateau", np.zeros((1, 2, 2)), 0.0, _PLATEAU_WIDTH
        )
        self._circle = add_line(scene, f"/{name}/circle", np.zeros((1, 2, 2)), 0.0, _CIRCLE_WIDTH)
        self._ligaments = [
            add_line(scene, f"/{name}/ligament_{label}", np.zeros((1, 2, 2)), 0.0, 2.0)
            for label in theme.LIGAMENT_LABELS
        ]
        self._labels: list[viser.LabelHandle] = []
        self._leaders: list[viser.LineSegmentsHandle] = []
        self._drawn_x: FloatArray | None = None
        self.visible = True

    @property
    def _own(self) -> list[viser.LineSegmentsHandle]:
        return [self._circle, *self._ligaments]

    def add_labels(self) -> None:
        """Give the ligaments names; only the visitor's knee has them."""
        self._labels = [
            self._scene.add_label(
                f"/{self._name}/label_{label}", label, font_screen_scale=1.0, anchor="center-center"
            )
            for label in theme.LIGAMENT_LABELS
        ]
        self._leaders = [
            add_line(
                self._scene,
                f"/{self._name}/leader_{label}",
                np.zeros((1, 2, 2)),
                0.0,
                _LEADER_WIDTH,
            )
            for label in theme.LIGAMENT_LABELS
        ]

    def show_labels(self, shown: bool) -> None:
        """Show or hide the ligaments' names."""
        for handle in (*self._labels, *self._leaders):
            if handle.visible != shown:
                handle.visible = shown

    def set_visible(self, visible: bool) -> None:
        """Show or hide everything of this knee."""
        if visible == self.visible:
            return
        self.visible = visible
        for handle in (self.frame, *self._own, *self._labels, *self._leaders):
            handle.visible = visible

    def paint(self, colours: theme.Palette, spatial: bool, share: float = 1.0) -> None:
        """Take the theme's colours; `share` fades an overlay in."""
        ghost = None if self._ghost is None else theme.rgb(getattr(colours, self._ghost))
        for mesh, rim, own in zip(
            self._meshes, self._rims, (colours.bone, colours.fibula), strict=True
        ):
            mesh.color = ghost or own
            mesh.opacity = opacity(spatial, ghost is not None, share)
            mesh.scale = (1.0, 1.0, 1.0 if spatial else FLAT)
            rim.colors = theme.handle_colour(ghost or colours.rim)
            rim.thickness = RIM_WIDTH * colours.size
            rim.visible = not spatial
        line = theme.handle_colour(ghost or colours.mechanism)
        self._plateau.colors = line
        self._circle.colors = line
        self._plateau.thickness = _PLATEAU_WIDTH * colours.size
        self._circle.thickness = _CIRCLE_WIDTH * colours.size
        for label in self._labels:
            label.font_screen_scale = colours.size
        for leader in self._leaders:
            leader.thickness = _LEADER_WIDTH * colours.size
        if ghost is not None:
            for ligament in self._ligaments:
                ligament.colors = line

    def draw(self, x: FloatArray, pose: Pose, colours: theme.Palette, spatial: bool) -> None:
        """Put the knee with the parameters `x` into `pose`."""
        z = self._layer * LAYER
        self.frame.wxyz = quaternion(pose.flexion)
        self.frame.position = (*pose.tibia_position, 0.0)
        if self._drawn_x is None or not np.array_equal(x, self._drawn_x):
            self._drawn_x = np.array(x)
            self._plateau.points = lift(plateau_line(x)[None], z + 6 * LAYER)
            self._circle.points = lift(circle(x), z + 6 * LAYER)
        segments = ligament_segments(x, pose)
        base = (_IN_FRONT if self._ghost is None else self._layer + 12) * LAYER
        for i in range(len(self._ligaments)):
            depth = LIGAMENT_DEPTH[i] if spatial else base - (2 * (i // 2) + i % 2) * LAYER
            points = lift(segments[i : i + 1], depth)
            self._draw_ligament(i, points, float(pose.tension[i]), colours)

    def _draw_ligament(
        self, i: int, points: NDArray[np.float32], tension: float, colours: theme.Palette
    ) -> None:
        handle, width = self._ligaments[i], colours.size * ligament_width(tension)
        handle.points = points
        if self._ghost is None:
            handle.colors = theme.handle_colour(ligament_colour(i, tension, colours.slack))
        else:  # two more knees: their slack ligaments would only clutter
            width *= 0.5
            handle.visible = self.visible and tension >= TAUT_TENSION
        handle.thickness = width

    def place_labels(
        self, x: FloatArray, pose: Pose, colours: theme.Palette, spatial: bool, forces: bool
    ) -> None:
        """Write the ligaments' names, on demand with their tension, beside them."""
        segments = ligament_segments(x, pose)
        spots = label_spots(segments, label_box(forces=forces, size=colours.size))
        lines = leaders(spots, segments)
        for i, handle in enumerate(self._labels):
            name, tension = theme.LIGAMENT_LABELS[i], float(pose.tension[i])
            handle.text = f"{name} {tension:.0f} N" if forces else name
            depth = LIGAMENT_DEPTH[i] if spatial else 0.006
            handle.position = (float(spots[i, 0]), float(spots[i, 1]), depth)
            leader = self._leaders[i]
            leader.points = lift(lines[i : i + 1], depth if spatial else (_IN_FRONT - 6) * LAYER)
            leader.colors = theme.handle_colour(ligament_colour(i, tension, colours.slack))

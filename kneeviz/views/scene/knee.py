"""The scene's nodes: created once, then only moved, coloured, shown and hidden.

Everything lies in the sagittal plane of the femur frame (x anterior, y up), in m. In the flat view
all depths shrink to thin layers, so that what is in front covers what is behind; in the 3D view
the bones have their illustrative depth and the collateral ligaments stand on their own sides.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneeviz.geometry.bones import Bone, bones
from kneeviz.geometry.mechanism import (
    LIGAMENT_DEPTH,
    TAUT_TENSION,
    Pose,
    circle,
    contact_arrow,
    contact_point,
    ligament_colour,
    ligament_segments,
    ligament_width,
    plateau_line,
    quaternion,
    spread_labels,
)
from kneeviz.views import theme

FloatArray = NDArray[np.float64]

FIELD_OF_VIEW = np.deg2rad(10.0)
"""Narrow, so that perspective does not show: there is no orthographic camera."""
CENTRE = (-0.031, -0.008, 0.0)
HALF_HEIGHT = 0.157
DISTANCE = HALF_HEIGHT / np.tan(0.5 * FIELD_OF_VIEW)
_FLAT = 0.002  # share of the bones' depth that the flat view keeps
_LAYER = 4e-4  # m between the flat view's layers
_LABEL_BOX = (0.034, 0.0125)  # m, a label's room in the flat view
_OVERLAY_OPACITY = 0.30


def camera_position(spatial: bool) -> tuple[float, float, float]:
    """Return where the camera stands: in front, or for the 3D view to the side and above."""
    if not spatial:
        return CENTRE[0], CENTRE[1], float(DISTANCE)
    turn, rise = np.deg2rad(38.0), np.deg2rad(16.0)
    return (
        CENTRE[0] + float(DISTANCE * np.sin(turn) * np.cos(rise)),
        CENTRE[1] + float(DISTANCE * np.sin(rise)),
        float(DISTANCE * np.cos(turn) * np.cos(rise)),
    )


def _lift(segments: FloatArray, depth: FloatArray | float) -> NDArray[np.float32]:
    """Return plane segments, shape (n, 2, 2), at a depth across the plane, shape (n, 2, 3)."""
    lifted = np.empty((*segments.shape[:-1], 3), dtype=np.float32)
    lifted[..., :2] = segments
    lifted[..., 2] = np.reshape(depth, (-1, 1)) if np.ndim(depth) else depth
    return lifted


def _chain(loop: FloatArray) -> FloatArray:
    return np.stack([loop, np.roll(loop, -1, axis=0)], axis=1)


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


class Body:
    """A tibia with its fibula, plateau line and ligaments: the visitor's knee or an overlay."""

    def __init__(self, scene: Any, name: str, layer: int, ghost: theme.RGB | None) -> None:
        self._scene, self._name, self._layer, self._ghost = scene, name, layer, ghost
        self.frame = scene.add_frame(f"/{name}/tibia", show_axes=False)
        self._meshes, self._rims = [], []
        for bone in bones():
            if bone.frame == "tibia":
                depth = layer - (2 if bone.name == "fibula" else 0)
                self._meshes.append(_mesh(scene, f"/{name}/tibia/{bone.name}", bone, depth))
                self._rims.append(_rim(scene, f"/{name}/tibia/{bone.name}_rim", bone, depth + 1))
        self._plateau = _line(scene, f"/{name}/tibia/plateau", np.zeros((1, 2, 2)), 0.0, 2.0)
        self._circle = _line(scene, f"/{name}/circle", np.zeros((1, 2, 2)), 0.0, 1.5)
        self._ligaments = [
            _line(scene, f"/{name}/ligament_{label}", np.zeros((1, 2, 2)), 0.0, 2.0)
            for label in theme.LIGAMENT_LABELS
        ]
        self._labels: list[Any] = []
        self._drawn_x: FloatArray | None = None
        self.visible = True

    @property
    def _own(self) -> list[Any]:
        return [self._circle, *self._ligaments]

    def add_labels(self) -> None:
        """Give the ligaments names; only the visitor's knee has them."""
        self._labels = [
            self._scene.add_label(
                f"/{self._name}/label_{label}", label, font_screen_scale=1.0, anchor="center-center"
            )
            for label in theme.LIGAMENT_LABELS
        ]

    def set_visible(self, visible: bool) -> None:
        """Show or hide everything of this knee."""
        if visible == self.visible:
            return
        self.visible = visible
        for handle in (self.frame, *self._own, *self._labels):
            handle.visible = visible

    def paint(self, colours: theme.Palette, spatial: bool, share: float = 1.0) -> None:
        """Take the theme's colours; `share` fades an overlay in."""
        ghost = self._ghost
        for mesh, rim, own in zip(
            self._meshes, self._rims, (colours.bone, colours.fibula), strict=True
        ):
            mesh.color = ghost or own
            mesh.opacity = _opacity(spatial, ghost is not None, share)
            mesh.scale = (1.0, 1.0, 1.0 if spatial else _FLAT)
            rim.colors = theme.wire_colour(ghost or colours.rim)
            rim.visible = not spatial
        line = theme.wire_colour(ghost or colours.mechanism)
        self._plateau.colors = line
        self._circle.colors = line
        if ghost is not None:
            for ligament in self._ligaments:
                ligament.colors = line

    def draw(self, x: FloatArray, pose: Pose, colours: theme.Palette, spatial: bool) -> None:
        """Put the knee with the parameters `x` into `pose`."""
        z = self._layer * _LAYER
        self.frame.wxyz = quaternion(pose.flexion)
        self.frame.position = (*pose.tibia_position, 0.0)
        if self._drawn_x is None or not np.array_equal(x, self._drawn_x):
            self._drawn_x = np.array(x)
            self._plateau.points = _lift(plateau_line(x)[None], z + 6 * _LAYER)
            self._circle.points = _lift(circle(x), z + 6 * _LAYER)
        segments = ligament_segments(x, pose)
        for i, handle in enumerate(self._ligaments):
            depth = LIGAMENT_DEPTH[i] if spatial else z + (12 - 2 * (i // 2) - i % 2) * _LAYER
            handle.points = _lift(segments[i : i + 1], depth)
            width = ligament_width(float(pose.tension[i]))
            if self._ghost is None:
                colour = ligament_colour(i, float(pose.tension[i]), colours.slack)
                handle.colors = theme.wire_colour(colour)
            if self._ghost is not None:  # two more knees: their slack ligaments would only clutter
                width *= 0.5
                handle.visible = self.visible and float(pose.tension[i]) >= TAUT_TENSION
            handle.thickness = width

    def place_labels(self, x: FloatArray, pose: Pose, spatial: bool, forces: bool) -> None:
        """Write the ligaments' names, on demand with their tension, beside them."""
        segments = ligament_segments(x, pose)
        spots = _label_spots(segments)
        for i, handle in enumerate(self._labels):
            name, tension = theme.LIGAMENT_LABELS[i], float(pose.tension[i])
            handle.text = f"{name} {tension:.0f} N" if forces else name
            depth = LIGAMENT_DEPTH[i] if spatial else 0.006
            handle.position = (float(spots[i, 0]), float(spots[i, 1]), depth)


def _label_spots(segments: FloatArray) -> FloatArray:
    """Return places for the four names: off their ligaments, away from each other."""
    share = np.array([0.15, 0.85, 0.62, 0.70])  # of the way from femur to tibia
    along = segments[:, 1] - segments[:, 0]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)  # anterior of the ligament
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    offset = np.array([0.020, -0.022, 0.020, -0.024])[:, None] * across
    return spread_labels(segments[:, 0] + share[:, None] * along + offset, _LABEL_BOX)


def _opacity(spatial: bool, ghost: bool, share: float) -> float | None:
    if ghost:
        return _OVERLAY_OPACITY * share
    return 0.45 if spatial else None


def _line(scene: Any, name: str, segments: FloatArray, depth: float, width: float) -> Any:
    return scene.add_line_segments(
        name,
        points=_lift(segments, depth),
        colors=(128, 128, 128),
        thickness=width,
        thickness_units="screen",
    )


def _mesh(scene: Any, name: str, bone: Bone, layer: int) -> Any:
    return scene.add_mesh_simple(
        name,
        vertices=bone.vertices.astype(np.float32),
        faces=bone.faces.astype(np.uint32),
        color=(230, 220, 200),
        side="double",
        cast_shadow=False,
        receive_shadow=False,
        position=(0.0, 0.0, layer * _LAYER),
    )


def _rim(scene: Any, name: str, bone: Bone, layer: int) -> Any:
    return _line(scene, name, _chain(bone.outline), layer * _LAYER, 2.0)


class KneeScene:
    """The knee on screen: femur, the visitor's tibia, two overlays, contact and lights."""

    def __init__(self, scene: Any) -> None:
        self._scene = scene
        self.spatial, self.dark, self.forces = False, False, False
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
        self._femur = _mesh(scene, "/knee/femur", femur, 4)
        self._femur_rim = _rim(scene, "/knee/femur_rim", femur, 5)
        self.overlays = (
            Body(scene, "worst_1", 8, theme.rgb(theme.MODEL_1)),
            Body(scene, "worst_2", 14, theme.rgb(theme.MODEL_2)),
        )
        for overlay in self.overlays:
            overlay.set_visible(False)
        self._spot = _line(scene, "/knee/contact", np.zeros((1, 2, 2)), 0.0, 9.0)
        self._arrow = _line(scene, "/knee/force", np.zeros((3, 2, 2)), 0.0, 3.0)
        self.repaint()

    def repaint(self, *, overlay_share: float = 1.0) -> None:
        """Apply theme and view (flat or 3D) to every node."""
        self._colours = colours = theme.palette(self.dark)
        shaded = self.spatial or self.hidden  # what takes the knee's place is a landscape
        self._ambient.intensity = 1.7 if shaded else float(np.pi)
        self._sun.intensity = 2.2 if shaded else 0.0
        self._femur.color = colours.bone
        self._femur.opacity = _opacity(self.spatial, False, 1.0)
        self._femur.scale = (1.0, 1.0, 1.0 if self.spatial else _FLAT)
        self._femur_rim.colors = theme.wire_colour(colours.rim)
        self._femur_rim.visible = not self.spatial
        self._spot.colors = theme.wire_colour(colours.contact)
        self._arrow.colors = theme.wire_colour(colours.arrow)
        self.own.paint(colours, self.spatial)
        for overlay in self.overlays:
            overlay.paint(colours, self.spatial, overlay_share)

    def set_hidden(self, hidden: bool) -> None:
        """Hide all knees, or show them again."""
        self.hidden = hidden
        for root in self._roots:
            root.visible = not hidden
        self.repaint()

    def fade_overlays(self, share: float) -> None:
        """Set how far the overlays have faded in."""
        for overlay in self.overlays:
            overlay.paint(self._colours, self.spatial, share)

    def draw(self, x: FloatArray, pose: Pose) -> None:
        """Draw the visitor's knee with its contact."""
        self.own.draw(x, pose, self._colours, self.spatial)
        self.own.place_labels(x, pose, self.spatial, self.forces)
        touching = pose.contact_force > 0.05
        self._spot.visible = self._arrow.visible = touching
        if touching:
            point = contact_point(x, pose)
            half = np.array([[0.0011, 0.0], [-0.0011, 0.0]])
            depth = 0.0 if self.spatial else 14 * _LAYER
            self._spot.points = _lift((point + half)[None], depth)
            self._arrow.points = _lift(_arrow_segments(contact_arrow(x, pose)), depth)

    def draw_overlay(self, index: int, x: FloatArray | None, pose: Pose | None) -> None:
        """Draw worst case `index` (0 or 1), or hide it."""
        body = self.overlays[index]
        if x is None or pose is None:
            body.set_visible(False)
            return
        body.set_visible(True)
        body.draw(x, pose, self._colours, self.spatial)

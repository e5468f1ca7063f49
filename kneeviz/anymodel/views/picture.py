"""The user's picture in the scene: own shapes dark, those of both worst models blue and orange."""

from collections.abc import Sequence

import numpy as np
import viser

from kneecore import Shape
from kneeviz.anymodel.frame import Frame, scale_bar, segments
from kneeviz.views import theme
from kneeviz.views.scene.nodes import LAYER, add_line, lift

_NAMES = ("own", "worst_1", "worst_2")
_WIDTHS = (3.0, 2.5, 2.5)
_DEPTHS = (12 * LAYER, 4 * LAYER, 8 * LAYER)
_LABEL_SHIFT = 0.004


class PictureScene:
    """Three pictures, the own one with its labels, and the lights."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        scene.set_up_direction("+y")
        scene.configure_environment_map(None)
        scene.configure_default_lights(False)
        self._ambient = scene.add_light_ambient("/light/ambient", intensity=float(np.pi))
        self._sun = scene.add_light_directional(
            "/light/sun", intensity=0.0, position=(0.4, 0.8, 1.0)
        )
        self._root = scene.add_frame("/model", show_axes=False)
        self.lines = [
            add_line(scene, f"/model/{name}", np.zeros((1, 2, 2)), 0.0, width)
            for name, width in zip(_NAMES, _WIDTHS, strict=True)
        ]
        for line in self.lines:
            line.visible = False
        self._scale = add_line(scene, "/model/scale", np.zeros((1, 2, 2)), 0.0, 1.5)
        self._length = scene.add_label("/model/scale_length", "", anchor="bottom-left")
        self._scale.visible = self._length.visible = False
        self._labels: list[viser.LabelHandle] = []

    def set_hidden(self, hidden: bool) -> None:
        """Hide the pictures for a landscape, or show them again."""
        self._root.visible = not hidden
        self._ambient.intensity = 1.7 if hidden else float(np.pi)
        self._sun.intensity = 2.2 if hidden else 0.0

    def draw(
        self, pictures: Sequence[Sequence[Shape] | None], frame: Frame, colours: theme.Palette
    ) -> None:
        """Draw those that are there: own, worst model 1 and 2."""
        hues = (colours.current, colours.model_1, colours.model_2)
        for line, shapes, hue, depth in zip(self.lines, pictures, hues, _DEPTHS, strict=True):
            drawn = [segments(shape, frame) for shape in shapes or ()]
            every = np.concatenate(drawn or [np.zeros((0, 2, 2))])
            line.visible = len(every) > 0
            if len(every):
                line.points = lift(every, depth)
                line.colors = theme.handle_colour(theme.rgb(hue))
        self._write([s for s in pictures[0] or () if s.label], frame)

    def draw_scale(self, frame: Frame, unit: str, colours: theme.Palette) -> None:
        """Draw a line of a round length below the shapes, where its unit is known."""
        if not unit:
            return
        length, lines = scale_bar(frame)
        self._scale.points = lift(lines, 0.0)
        self._scale.colors = theme.handle_colour(theme.rgb(colours.baseline))
        self._length.text = f"{length:g} {unit}"
        x, y = lines[0, 1]
        self._length.position = (float(x) + _LABEL_SHIFT, float(y), 20 * LAYER)
        self._scale.visible = self._length.visible = True

    def _write(self, shapes: Sequence[Shape], frame: Frame) -> None:
        """Write labels beside the middle of a shape's first line."""
        spots = [np.mean(frame.place(s.points[:2]), axis=0) for s in shapes]
        known = [
            (s.label, at) for s, at in zip(shapes, spots, strict=True) if np.isfinite(at).all()
        ]
        while len(self._labels) < len(known):
            name = f"/model/label_{len(self._labels)}"
            self._labels.append(self._scene.add_label(name, "", anchor="bottom-left"))
        for label, (text, at) in zip(self._labels, known, strict=False):
            label.text = text
            label.position = (float(at[0]) + _LABEL_SHIFT, float(at[1]) + _LABEL_SHIFT, 20 * LAYER)
        for k, label in enumerate(self._labels):
            label.visible = k < len(known)

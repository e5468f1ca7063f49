"""What knees that stand side by side need more than knees over one another: femurs and names."""

from collections.abc import Sequence

import viser

from kneeviz.geometry.bones import bones
from kneeviz.views import theme
from kneeviz.views.scene.nodes import FLAT, RIM_WIDTH, add_mesh, add_rim, opacity

_NAMES = ("yours", "model 1", "model 2")
_SIDES = (0.0, -1.0, 1.0)
_ABOVE = 0.006
"""m from a femur's upper end to the knee's name."""


class Beside:
    """Both worst cases' own femurs, and all three knees' names.

    Parameters
    ----------
    scene : SceneApi
    roots : sequence of FrameHandle
        Of the visitor's knee and both worst cases.
    """

    def __init__(self, scene: viser.SceneApi, roots: Sequence[viser.FrameHandle]) -> None:
        self._roots, self._apart = roots, 0.0
        femur = next(bone for bone in bones() if bone.frame == "femur")
        place = (0.0, float(femur.outline[:, 1].max()) + _ABOVE, 0.0)
        self._femurs = [add_mesh(scene, f"{root.name}/femur", femur, 4) for root in roots[1:]]
        self._rims = [add_rim(scene, f"{root.name}/femur_rim", femur, 5) for root in roots[1:]]
        self._names = [
            scene.add_label(f"{root.name}/name", name, position=place, anchor="bottom-center")
            for root, name in zip(roots, _NAMES, strict=True)
        ]
        self._show(False)

    def _show(self, shown: bool) -> None:
        for handle in (*self._femurs, *self._rims, *self._names):
            handle.visible = shown

    def paint(self, colours: theme.Palette, spatial: bool) -> None:
        """Take the colours of a theme: a femur is bone, its outline its model's."""
        hues = (colours.model_1, colours.model_2)
        for femur, rim, hue in zip(self._femurs, self._rims, hues, strict=True):
            femur.color = colours.bone
            femur.opacity = opacity(spatial, False, 1.0)
            femur.scale = (1.0, 1.0, 1.0 if spatial else FLAT)
            rim.colors = theme.handle_colour(theme.rgb(hue))
            rim.thickness = RIM_WIDTH * colours.size
        for name in self._names:
            name.font_screen_scale = colours.size

    def stand(self, apart: float) -> None:
        """Put both worst cases so far to the sides, m; 0 is over the visitor's knee."""
        if apart == self._apart:
            return
        self._apart = apart
        for root, side in zip(self._roots, _SIDES, strict=True):
            root.position = (side * apart, 0.0, 0.0)
        self._show(apart > 0.0)

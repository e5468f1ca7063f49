"""The landscape's nodes: two translucent sheets in a box, training knees and marked knees.

Created when the landscape is first shown; then only moved, coloured, shown and hidden.
"""

from typing import Any

import numpy as np
import trimesh
import viser
from numpy.typing import NDArray

from kneeviz.geometry import surfaces
from kneeviz.geometry.picture import Mark, Picture
from kneeviz.geometry.surfaces import Box
from kneeviz.views import theme
from kneeviz.views.html.pieces import number

FloatArray = NDArray[np.float64]

_BEAD, _BALL = 0.0013, 0.0024  # m: radius of a training knee and of a marked one
_SHEET_OPACITY = 0.42
_FLOOR_TICKS = (0.0, 0.5, 1.0)
# Outwards from the box, so that the two axes' numbers keep apart at their common corner.
_TICK_SHIFT = ((-0.007, -0.002, 0.006), (0.012, -0.002, -0.003))
_TITLE_SHIFT = ((-0.008, -0.010, 0.014), (0.020, -0.010, 0.0))
_MAX_TICKS = 12
_MARKED = (True, False, True, True)
"""Which marks have a stem and a name: one for a knee and its guess."""
_BESIDE = (0.0045, 0.0, -0.0033)  # to the right, as the camera first sees it


def _ball(radius: float, subdivisions: int) -> tuple[FloatArray, FloatArray]:
    body = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return np.array(body.vertices), np.array(body.faces)


class LandscapeScene:
    """Sheets, box, axes and marks under one node."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._root = scene.add_frame("/landscape", show_axes=False, visible=False)
        self._frame = self._lines("frame", 1.0)
        self._sheets = [self._mesh(name, opacity=_SHEET_OPACITY) for name in ("model", "surrogate")]
        self._nets = [self._lines(f"{name}_net", 1.0) for name in ("model", "surrogate")]
        self._training = self._mesh("training")
        large, small = _ball(_BALL, 2), _ball(0.75 * _BALL, 2)
        self._balls = [
            self._mesh(name, *body)
            for name, body in (("own", large), ("said", small), ("one", large), ("two", large))
        ]
        self._stems = [self._lines(f"stem_{k}", 1.5) for k in range(4)]
        anchors = ("bottom-center", "bottom-center", "center-left", "center-left")
        self._names = [self._label(f"mark_{k}", anchor) for k, anchor in enumerate(anchors)]
        for name, text in zip(self._names[2:], ("model 1", "model 2"), strict=True):
            name.text = text
        self._levels = [self._label(f"level_{k}", "center-right") for k in range(_MAX_TICKS)]
        self._ticks = [
            [self._label(f"tick_{axis}_{k}", "top-center") for k in range(len(_FLOOR_TICKS))]
            for axis in range(2)
        ]
        self._titles = [
            self._label("title_0", "top-center"),
            self._label("title_1", "top-center"),
            self._label("title_2", "bottom-left"),
        ]
        self._bead = _ball(_BEAD, 1)

    def set_visible(self, visible: bool) -> None:
        """Show or hide everything."""
        self._root.visible = visible

    def _mesh(
        self,
        name: str,
        vertices: FloatArray | None = None,
        faces: FloatArray | None = None,
        *,
        opacity: float | None = None,
    ) -> viser.MeshHandle:
        points = np.zeros((3, 3)) if vertices is None else vertices
        triangles = np.array([[0, 1, 2]]) if faces is None else faces
        return self._scene.add_mesh_simple(
            f"/landscape/{name}",
            vertices=points.astype(np.float32),
            faces=triangles.astype(np.uint32),
            opacity=opacity,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

    def _lines(self, name: str, width: float) -> viser.LineSegmentsHandle:
        return self._scene.add_line_segments(
            f"/landscape/{name}",
            points=np.zeros((1, 2, 3), np.float32),
            colors=(128, 128, 128),
            thickness=width,
            thickness_units="screen",
        )

    def _label(self, name: str, anchor: Any) -> viser.LabelHandle:
        return self._scene.add_label(f"/landscape/{name}", "", anchor=anchor)

    def paint(self, colours: theme.Palette) -> None:
        """Take a theme's colours."""
        hues = (theme.rgb(colours.current), theme.rgb(colours.surrogate))
        for mesh, net, hue in zip(self._sheets, self._nets, hues, strict=True):
            mesh.color, net.colors = hue, theme.handle_colour(hue)
        self._frame.colors = theme.handle_colour(theme.rgb(colours.faint))
        self._training.color = theme.rgb(colours.baseline)
        marks = (*hues, theme.rgb(colours.model_1), theme.rgb(colours.model_2))
        for ball, line, hue in zip(self._balls, self._stems, marks, strict=True):
            ball.color, line.colors = hue, theme.handle_colour(hue)

    def draw(self, shown: Picture, *, title: str, labels: tuple[str, str], zoom: bool) -> None:
        """Draw a picture; `title` names what stands upright, `labels` the two parameters."""
        box = surfaces.box_around(shown, zoom=zoom)
        self._frame.points = surfaces.frame_lines(box).astype(np.float32)
        for k, values in enumerate((shown.model, shown.surrogate)):
            self._draw_sheet(k, box, values)
        self._draw_training(box, shown.training[box.holds(shown.training[:, 2])])
        for k, mark in enumerate((shown.own, shown.predicted, *shown.worst)):
            self._draw_mark(k, box, mark if mark is not None and box.has(mark) else None)
        self._names[0].text = shown.own_label
        self._write_axes(box, shown, title, labels)

    def _draw_sheet(self, k: int, box: Box, values: FloatArray | None) -> None:
        mesh, net = self._sheets[k], self._nets[k]
        drawn = None if values is None else surfaces.sheet(box, values)
        mesh.visible = net.visible = drawn is not None and len(drawn[1]) > 0
        if values is None or drawn is None or not mesh.visible:
            return
        vertices, faces = drawn
        mesh.vertices, mesh.faces = np.asarray(vertices, np.float32), faces
        net.points = surfaces.mesh_lines(box, values).astype(np.float32)

    def _draw_training(self, box: Box, points: FloatArray) -> None:
        self._training.visible = len(points) > 0
        if len(points):
            places = box.place(*points.T)
            vertices, faces = surfaces.beads(places, self._bead)
            self._training.vertices = vertices.astype(np.float32)
            self._training.faces = faces.astype(np.uint32)

    def _draw_mark(self, k: int, box: Box, mark: Mark | None) -> None:
        ball, line, name = self._balls[k], self._stems[k], self._names[k]
        ball.visible = mark is not None
        line.visible = name.visible = mark is not None and _MARKED[k]
        if mark is None:
            return
        x, y, z = surfaces.spot(box, mark)
        ball.position = (x, y, z)
        _move(name, np.array([x, y, z]), (0.0, 1.6 * _BALL, 0.0) if k == 0 else _BESIDE)
        line.points = surfaces.stem(box, mark).astype(np.float32)

    def _write_axes(self, box: Box, shown: Picture, title: str, labels: tuple[str, str]) -> None:
        _write(self._titles[2], title, box.place(0.0, 0.0, box.high), (-0.02, 0.007, 0.0))
        for k, handle in enumerate(self._levels):
            handle.visible = k < len(box.ticks)
            if handle.visible:
                at = box.place(0.0, 0.0, box.ticks[k])
                text = number(box.ticks[k], box.digits, shown.unit)
                _write(handle, text, at, (-0.004, 0.0, 0.0))
        for axis in range(2):
            low, high = shown.ends[axis]
            digits = min(max(int(np.ceil(2.0 - np.log10(high - low))), 0), 9)
            for share, handle in zip(_FLOOR_TICKS, self._ticks[axis], strict=True):
                text = number(low + share * (high - low), digits)
                _write(handle, text, _on_floor(box, axis, share), _TICK_SHIFT[axis])
            _write(self._titles[axis], labels[axis], _on_floor(box, axis, 0.5), _TITLE_SHIFT[axis])


def _on_floor(box: Box, axis: int, share: float) -> FloatArray:
    """Return a point on the floor's edge that carries a parameter's numbers."""
    place = (share, 0.0) if axis == 0 else (1.0, share)
    return box.place(*place, box.low)


def _write(
    handle: viser.LabelHandle, text: str, at: FloatArray, shift: tuple[float, float, float]
) -> None:
    handle.text = text
    _move(handle, at, shift)


def _move(handle: viser.LabelHandle, at: FloatArray, shift: tuple[float, float, float]) -> None:
    x, y, z = (float(a + s) for a, s in zip(at, shift, strict=True))
    handle.position = (x, y, z)

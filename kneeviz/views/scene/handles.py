"""Handles on the knee: rings to take hold of, their bounds as boxes, and the chosen one's loupe."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import viser
from numpy.typing import NDArray

from kneecore import LIGAMENTS
from kneeviz.geometry.handles import HANDLES, Handle, Three
from kneeviz.geometry.mechanism import LIGAMENT_DEPTH
from kneeviz.jobs.messages import Asked, Post
from kneeviz.views import theme
from kneeviz.views.scene.clicks import Clicks
from kneeviz.views.scene.nodes import LAYER, add_line, lift

FloatArray = NDArray[np.float64]

_HIT, _RING, _CHOSEN_RING = 0.0095, 0.0021, 0.0032
"""m: radius of what a finger can hit, and of the ring that is seen, unless it is chosen."""
_IN_FRONT = 0.020
"""m: depth of the handles in the flat view."""
_LENS = 0.1
"""Share of its breadth that a hit's depth is: of lenses that overlap, the one whose middle is
nearest in the picture is in front, and is hit."""
_EDGE_NEARER, _CHOSEN_NEARER = 1.2e-3, 1.6e-3
"""m: how much nearer a loupe's edges are than the other handles, and the chosen one itself."""
_EDGE_BREADTH, _GRIP = 0.007, 0.005
_EDGES = ((0, -1), (0, 1), (1, -1), (1, 1))
_EDGE_CORNERS = ((3, 0), (1, 2), (0, 1), (2, 3))
"""The corners between which each edge runs, in the order of `corners`."""


class Pointer(NamedTuple):
    """Where a hand is: what viser tells of a drag, unchecked."""

    eye: Three
    """The visitor's camera."""
    start: Three
    """The place that he took hold of, which goes along with what he moves."""
    end: Three
    """What he points at now."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LoupeShown:
    """The chosen handle's box, magnified."""

    number: int
    """Of the handle."""
    corners: FloatArray
    """Shape (4, 2), m."""
    text: str
    n_edges: int
    """How many of its edges can be moved: four, a strip's two, or none."""


def depth_of(handle: Handle, spatial: bool) -> float:
    """Return how far from the sagittal plane a handle stands, m."""
    if not spatial:
        return _IN_FRONT
    group = handle.name.split("_")[0]
    return LIGAMENT_DEPTH[LIGAMENTS.index(group)] if group in LIGAMENTS else 0.0


def _ring(n: int = 20) -> FloatArray:
    angle = np.linspace(0.0, 2.0 * np.pi, n + 1)
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.stack([rim[:-1], rim[1:]], axis=1)


def _sides(corners: FloatArray) -> FloatArray:
    """Return a box's sides, shape (4, 2, 2), of its corners in turn."""
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


class HandleScene:
    """The nodes of all handles: created once, then only moved, shown and hidden.

    Parameters
    ----------
    scene : SceneApi
    post : callable
        Gets "grab_start", "grab_update" and "grab_end" with the handle's name, its edge (None for
        the handle itself) and the visitor's number, and an `Asked` with a `Pointer`;
        "handle_choose" and "handle_home" with the handle's name.
    """

    def __init__(self, scene: viser.SceneApi, post: Post) -> None:
        self._scene, self._post = scene, post
        self._clicks = Clicks()
        self._chosen: Handle | None = None
        self._colours = theme.palette(False)
        self.root = scene.add_frame("/handles", show_axes=False, visible=False)
        self._boxes = add_line(scene, "/handles/boxes", np.zeros((1, 2, 2)), 0.0, 1.0)
        self._rays = add_line(scene, "/handles/rays", np.zeros((1, 2, 2)), 0.0, 1.0)
        self._loupe = add_line(scene, "/handles/loupe", np.zeros((1, 2, 2)), 0.0, 1.5)
        self._grips = add_line(scene, "/handles/grips", np.zeros((1, 2, 2)), 0.0, 5.0)
        self._label = scene.add_label("/handles/label", "", anchor="center-left", visible=False)
        self.hits = [self._add_handle(handle) for handle in HANDLES]
        self._rings = [
            add_line(scene, f"/handles/{handle.name}/ring", _RING * _ring(), 0.0, 2.5)
            for handle in HANDLES
        ]
        self.edges = [self._add_edge(i) for i in range(len(_EDGES))]
        self.paint(self._colours)

    def _add_handle(self, handle: Handle) -> Any:
        hit = self._scene.add_icosphere(
            f"/handles/{handle.name}",
            _HIT,
            scale=(1.0, 1.0, _LENS),
            subdivisions=2,
            opacity=0.0,
            cast_shadow=False,
            receive_shadow=False,
        )
        self._listen(hit, handle)
        return hit

    def _listen(self, hit: Any, handle: Handle) -> None:
        # Coroutines run on viser's event loop, in the order of arrival.
        async def clicked(event: Any) -> None:
            twice = self._clicks.is_second(event.client_id, handle.name)
            asked = Asked(hit, event.client_id, True)
            self._post(("handle_home" if twice else "handle_choose", handle.name), asked)

        async def dragged(event: Any) -> None:
            self._tell_drag(event, handle, None)

        hit.on_click(clicked)
        hit.on_drag(dragged)

    def _add_edge(self, number: int) -> Any:
        bar = self._scene.add_box(
            f"/handles/edge_{number}",
            dimensions=(0.01, 0.01, 0.001),
            opacity=0.0,
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )

        async def dragged(event: Any) -> None:
            if self._chosen is not None:
                self._tell_drag(event, self._chosen, _EDGES[number])

        bar.on_drag(dragged)
        return bar

    def _tell_drag(self, event: Any, handle: Handle, edge: tuple[int, int] | None) -> None:
        pointer = Pointer(
            tuple(event.client.camera.position), event.start_position, event.end_position
        )
        key = (f"grab_{event.phase}", handle.name, edge, event.client_id)
        self._post(key, Asked(event.target, event.client_id, pointer))

    @property
    def unseen(self) -> list[str]:
        """The names of the nodes that are there only to be hit."""
        return [str(node.name) for node in (*self.hits, *self.edges)]

    def hide(self) -> None:
        """Show no handle."""
        self.root.visible = False

    def paint(self, colours: theme.Palette) -> None:
        """Take the theme's colours."""
        self._colours = colours
        line = theme.handle_colour(colours.handle)
        for node in (self._boxes, self._loupe, self._grips):
            node.colors = line
        self._rays.colors = theme.handle_colour(colours.slack)

    def _colour(self, handle: Handle) -> theme.RGB:
        group = handle.name.split("_")[0]
        if group in LIGAMENTS:
            return theme.rgb(theme.LIGAMENT_COLOURS[LIGAMENTS.index(group)])
        return self._colours.handle

    def draw(
        self,
        points: FloatArray,
        boxes: FloatArray,
        fixed: NDArray[np.bool_],
        loupe: LoupeShown | None,
        *,
        spatial: bool,
    ) -> None:
        """Put the handles to `points`, shape (n, 2), and their bounds to `boxes`, (n, 4, 2), m.

        Those that are `fixed`, shape (n,), are grey.
        """
        chosen = None if loupe is None else loupe.number
        depths = [depth_of(handle, spatial) for handle in HANDLES]
        for i, handle in enumerate(HANDLES):
            nearer = _CHOSEN_NEARER if i == chosen else 0.0
            self.hits[i].position = (*points[i], depths[i] + nearer)
            colour = self._colours.slack if fixed[i] else self._colour(handle)
            self._rings[i].colors = theme.handle_colour(colour)
            size = _CHOSEN_RING if i == chosen else _RING
            self._rings[i].points = lift(size * _ring(), 0.0)
        sides = np.concatenate([_sides(box) for box in boxes])
        self._boxes.points = lift(sides, np.repeat(depths, 4) + 2 * LAYER)
        self._draw_loupe(boxes, depths, loupe)
        self.root.visible = True

    def _draw_loupe(self, boxes: FloatArray, depths: list[float], loupe: LoupeShown | None) -> None:
        n_edges = 0 if loupe is None else loupe.n_edges
        self._chosen = None if loupe is None else HANDLES[loupe.number]
        self._label.visible = loupe is not None
        for node in (self._loupe, self._grips, self._rays):
            node.visible = n_edges > 0
        for i, bar in enumerate(self.edges):
            bar.visible = i < n_edges
        if loupe is None:
            return
        depth, corners = depths[loupe.number], loupe.corners
        right, middle = corners[:, 0].max() + 0.003, corners[:, 1].mean()
        self._label.position = (float(right), float(middle), depth)
        self._label.text = loupe.text
        self._loupe.points = lift(_sides(corners), depth)
        self._rays.points = lift(np.stack([boxes[loupe.number], corners], axis=1), depth)
        if n_edges:
            grips = [self._place_edge(i, corners, depth) for i in range(n_edges)]
            self._grips.points = lift(np.array(grips), depth)

    def _place_edge(self, number: int, corners: FloatArray, depth: float) -> FloatArray:
        """Lay what can be hit over an edge of the loupe; return its grip, shape (2, 2), m."""
        start, end = corners[list(_EDGE_CORNERS[number])]
        middle, along = 0.5 * (start + end), end - start
        length = float(np.linalg.norm(along))
        turn = 0.5 * float(np.arctan2(along[1], along[0]))
        bar = self.edges[number]
        bar.dimensions = (max(length, 2.0 * _GRIP), _EDGE_BREADTH, 0.001)
        bar.wxyz = (np.cos(turn), 0.0, 0.0, np.sin(turn))
        bar.position = (*middle, depth + _EDGE_NEARER)
        half = min(_GRIP, 0.5 * length) * along / max(length, 1e-9)
        return np.array([middle - half, middle + half])

"""The loupe: the chosen handle's bound, magnified, with edges to take hold of, and its numbers."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from kneeviz.views import theme
from kneeviz.views.scene.nodes import add_line, lift

FloatArray = NDArray[np.float64]
Edge = tuple[int, int]

EDGES: tuple[Edge, ...] = ((0, -1), (0, 1), (1, -1), (1, 1))
"""A box's edges: which parameter, and which side."""
_EDGE_CORNERS = ((3, 0), (1, 2), (0, 1), (2, 3))
"""The corners between which each runs."""
_BREADTH, _GRIP = 0.007, 0.005
"""m: the breadth of an edge that can be hit, and half the length of the grip that shows it."""
_WIDTHS = (1.0, 1.5, 5.0)
"""Pixels, of rays, box and grips."""
_NEARER = 1.2e-3
"""m: how much nearer edges are than the handles around."""
_ASIDE = 0.003  # m, from the box to its numbers


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


def sides(corners: FloatArray) -> FloatArray:
    """Return a box's sides, shape (4, 2, 2), of its corners in turn."""
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


class LoupeScene:
    """The nodes of the loupe: created once, then only moved, shown and hidden.

    Parameters
    ----------
    scene : SceneApi
    dragged : callable
        Gets viser's event of a drag, and the edge.
    """

    def __init__(self, scene: viser.SceneApi, dragged: Callable[[Any, Edge], None]) -> None:
        self._scene = scene
        nowhere = np.zeros((1, 2, 2))
        self._rays = add_line(scene, "/handles/rays", nowhere, 0.0, _WIDTHS[0])
        self._box = add_line(scene, "/handles/loupe", nowhere, 0.0, _WIDTHS[1])
        self._grips = add_line(scene, "/handles/grips", nowhere, 0.0, _WIDTHS[2])
        self._label = scene.add_label("/handles/label", "", anchor="top-center", visible=False)
        self.edges = [self._add_edge(i, edge, dragged) for i, edge in enumerate(EDGES)]
        self._placed = b""

    def _add_edge(self, number: int, edge: Edge, dragged: Callable[[Any, Edge], None]) -> Any:
        bar = self._scene.add_box(
            f"/handles/edge_{number}",
            dimensions=(0.01, 0.01, 0.001),
            opacity=0.0,
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )

        async def tell(event: Any) -> None:
            dragged(event, edge)

        bar.on_drag(tell)
        return bar

    def paint(self, colours: theme.Palette) -> None:
        """Take the theme's colours and size."""
        for node, width in zip((self._rays, self._box, self._grips), _WIDTHS, strict=True):
            node.thickness = width * colours.size
        self._label.font_screen_scale = colours.size
        for node in (self._box, self._grips):
            node.colors = theme.handle_colour(colours.handle)
        self._rays.colors = theme.handle_colour(colours.slack)

    def draw(self, shown: LoupeShown | None, box: FloatArray, depth: float) -> None:
        """Show a loupe, or none; `box` has the corners of the bound itself, shape (4, 2), m."""
        n_edges = 0 if shown is None else shown.n_edges
        self._label.visible = shown is not None
        for node in (self._box, self._grips, self._rays):
            node.visible = n_edges > 0
        for i, bar in enumerate(self.edges):
            bar.visible = i < n_edges
        if shown is not None:
            self._label.text = shown.text
            self._place(shown, box, depth)

    def _place(self, shown: LoupeShown, box: FloatArray, depth: float) -> None:
        corners = shown.corners
        places = np.array([*corners.flat, *box.flat, depth, shown.number])
        placed = np.round(places, 9).tobytes()
        if placed == self._placed:  # most drags leave the box where it is
            return
        self._placed = placed
        # Below, since the panels are at the sides.
        middle, bottom = corners[:, 0].mean(), corners[:, 1].min() - _ASIDE
        self._label.position = (float(middle), float(bottom), depth)
        self._box.points = lift(sides(corners), depth)
        self._rays.points = lift(np.stack([box, corners], axis=1), depth)
        if shown.n_edges:
            grips = [self._place_edge(i, corners, depth) for i in range(shown.n_edges)]
            self._grips.points = lift(np.array(grips), depth)

    def _place_edge(self, number: int, corners: FloatArray, depth: float) -> FloatArray:
        """Lay what can be hit over an edge of the box; return its grip, shape (2, 2), m."""
        start, end = corners[list(_EDGE_CORNERS[number])]
        middle, along = 0.5 * (start + end), end - start
        length = float(np.linalg.norm(along))
        turn = 0.5 * float(np.arctan2(along[1], along[0]))
        bar = self.edges[number]
        bar.dimensions = (max(length, 2.0 * _GRIP), _BREADTH, 0.001)
        bar.wxyz = (np.cos(turn), 0.0, 0.0, np.sin(turn))
        bar.position = (*middle, depth + _NEARER)
        half = min(_GRIP, 0.5 * length) * along / max(length, 1e-9)
        return np.array([middle - half, middle + half])

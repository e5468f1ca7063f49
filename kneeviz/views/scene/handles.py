"""Handles on the knee: rings to take hold of, their bounds as boxes, and the chosen one's loupe."""

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
from kneeviz.views.scene.loupe import Edge, LoupeScene, LoupeShown, sides
from kneeviz.views.scene.nodes import LAYER, add_line, lift

FloatArray = NDArray[np.float64]

_HIT, _RING, _CHOSEN_RING = 0.0095, 0.0021, 0.0032
"""m: radius of what a finger can hit, and of the ring that is seen, unless it is chosen."""
_RING_WIDTH, _BOX_WIDTH = 2.5, 1.0  # pixels
_IN_FRONT = 0.020
"""m: depth of the handles in the flat view."""
_LENS = 0.1
"""Share of its breadth that a hit's depth is: of lenses that overlap, the one whose middle is
nearest in the picture is in front, and is hit."""
_CHOSEN_NEARER = 1.6e-3
"""m: how much nearer the chosen one is than the others."""


class Pointer(NamedTuple):
    """Where a hand is: what viser tells of a drag, unchecked."""

    eye: Three
    """The visitor's camera."""
    start: Three
    """The place that he took hold of, which goes along with what he moves."""
    end: Three
    """What he points at now."""


def hit_radius(size: float) -> float:
    """Return how far from its middle a handle can be taken, m; `size` is the theme's."""
    return _HIT * size


def depth_of(handle: Handle, spatial: bool) -> float:
    """Return how far from the sagittal plane a handle stands, m."""
    if not spatial:
        return _IN_FRONT
    group = handle.name.split("_")[0]
    return LIGAMENT_DEPTH[LIGAMENTS.index(group)] if group in LIGAMENTS else 0.0


def _ring(n: int = 12) -> FloatArray:
    angle = np.linspace(0.0, 2.0 * np.pi, n + 1)
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.stack([rim[:-1], rim[1:]], axis=1)


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
        self._wide: int | None = None
        self._colours = theme.palette(False)
        self.root = scene.add_frame("/handles", show_axes=False, visible=False)
        self._boxes = add_line(scene, "/handles/boxes", np.zeros((1, 2, 2)), 0.0, _BOX_WIDTH)
        self._loupe = LoupeScene(scene, self._edge_dragged)
        self.hits = [self._add_handle(handle) for handle in HANDLES]
        self._rings = [
            add_line(scene, f"/handles/{handle.name}/ring", _RING * _ring(), 0.0, _RING_WIDTH)
            for handle in HANDLES
        ]
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

    def _edge_dragged(self, event: Any, edge: Edge) -> None:
        if self._chosen is not None:
            self._tell_drag(event, self._chosen, edge)

    def _tell_drag(self, event: Any, handle: Handle, edge: Edge | None) -> None:
        pointer = Pointer(
            tuple(event.client.camera.position), event.start_position, event.end_position
        )
        key = (f"grab_{event.phase}", handle.name, edge, event.client_id)
        self._post(key, Asked(event.target, event.client_id, pointer))

    @property
    def unseen(self) -> list[str]:
        """The names of the nodes that are there only to be hit."""
        return [str(node.name) for node in (*self.hits, *self._loupe.edges)]

    def hide(self) -> None:
        """Show no handle."""
        self.root.visible = False

    def paint(self, colours: theme.Palette) -> None:
        """Take the theme's colours and size."""
        size, self._colours = colours.size, colours
        for i, (hit, ring) in enumerate(zip(self.hits, self._rings, strict=True)):
            hit.scale = (size, size, _LENS)
            ring.thickness = _RING_WIDTH * size
            self._size_ring(i)
        self._boxes.thickness = _BOX_WIDTH * size
        self._boxes.colors = theme.handle_colour(colours.handle)
        self._loupe.paint(colours)

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
        self._size_rings(chosen)
        lines = np.concatenate([sides(box) for box in boxes])
        self._boxes.points = lift(lines, np.repeat(depths, 4) + 2 * LAYER)
        self._chosen = None if chosen is None else HANDLES[chosen]
        at = 0 if chosen is None else chosen
        self._loupe.draw(loupe, boxes[at], depths[at])
        self.root.visible = True

    def _size_rings(self, chosen: int | None) -> None:
        """Make the chosen handle's ring wider than the others."""
        before, self._wide = self._wide, chosen
        if chosen == before:
            return
        for i in (before, chosen):
            if i is not None:
                self._size_ring(i)

    def _size_ring(self, i: int) -> None:
        radius = _CHOSEN_RING if i == self._wide else _RING
        self._rings[i].points = lift(self._colours.size * radius * _ring(), 0.0)

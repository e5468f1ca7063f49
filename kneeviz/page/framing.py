"""Where each visitor's camera stands: what is shown fills his window until he moves it himself."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache, partial
from itertools import count
from typing import Any, NamedTuple, Protocol

import numpy as np
import viser
from numpy.typing import NDArray

from kneeviz import viser_internals
from kneeviz.geometry import surfaces
from kneeviz.geometry.framing import (
    Frame,
    between,
    frame_around,
    holds,
    knee_points,
    spacing,
)
from kneeviz.geometry.mechanism import Pose
from kneeviz.geometry.sweep import Sweep
from kneeviz.jobs.messages import Post
from kneeviz.page.animation import smooth
from kneeviz.state.ghosts import Ghosts
from kneeviz.state.motion import Knees
from kneeviz.views.scene import camera

FloatArray = NDArray[np.float64]

_EASE_SECONDS = 0.6
_ECHO_SECONDS = 1.0
"""How long a browser may still tell of a camera that has been moved since."""
_REMEMBERED = 3
_NEAR = 1e-3
"""m; a camera that is farther from where it was put has been moved by its visitor."""
_SHARES = np.linspace(0.0, 1.0, 13)
NARROW = 0.42
"""Width of a picture over its height below which the charts give way. A browser tells pixels of its
screen, of which there may be any number to one of the page: only their ratios mean something."""
_UNFOLDED = 1.2
"""How much wider it must be for them to come back."""


class Seen(Protocol):
    """What is to be seen; compared with what was, so that it is looked at once."""

    @property
    def flat(self) -> bool:
        """Whether cameras only pan and zoom."""

    @property
    def direction(self) -> FloatArray:
        """From the middle to the camera."""

    def points(self) -> FloatArray | None:
        """Return what must be in the picture, shape (n, 3); None if there is nothing."""


class Subject(NamedTuple):
    """The knees, or a landscape."""

    knees: Knees
    spatial: bool
    """Whether they are shown in 3D."""
    landscape: bool
    """Whether a landscape stands in their place."""
    ghosts: Ghosts = ()
    """Earlier knees that stand where the visitor's does."""
    apart: float = 0.0
    """How far to the sides both worst cases stand, m."""

    @property
    def flat(self) -> bool:
        """Whether cameras only pan and zoom."""
        return not (self.spatial or self.landscape)

    @property
    def direction(self) -> FloatArray:
        """From the middle to the camera."""
        if self.landscape:
            return camera.BEFORE_LANDSCAPE
        return camera.ASIDE if self.spatial else camera.FRONT

    def points(self) -> FloatArray | None:
        """Return what must be in the picture all through the motion; None if there is nothing."""
        if self.landscape:
            return surfaces.corners()
        places = [*zip(self.knees, (0.0, -self.apart, self.apart), strict=True)]
        places += [(ghost, 0.0) for ghost in self.ghosts]
        parts = []
        for knee, aside in places:
            if knee is not None and knee.sweep is not None:
                points = knee_points(_through(knee.sweep), spatial=self.spatial)
                parts.append(points + np.array([aside, 0.0, 0.0]))
        return np.concatenate(parts) if parts else None


def _through(sweep: Sweep) -> list[Pose]:
    return [sweep.at_moment(sweep.moment_at(share)) for share in _SHARES]


@lru_cache(maxsize=2)
def room_between(knees: Knees) -> float:
    """Return how far to the sides both worst cases must stand so that no knees touch, m."""
    own, *worst = (None if knee is None else knee.sweep for knee in knees)
    if own is None or None in worst:
        return 0.0
    in_line = (worst[0], own, worst[1])
    moments = [own.moment_at(share) for share in _SHARES]
    return spacing([[s.at_moment(m) for s in in_line if s is not None] for m in moments])


@dataclass(eq=False)
class _Camera:
    """One visitor's camera."""

    client: viser.ClientHandle
    aspect: float
    shown: Frame = camera.FIRST
    """What it was last made to show."""
    direction: FloatArray = field(default_factory=lambda: camera.FRONT)
    placed_at: float = -np.inf
    placed: tuple[FloatArray, ...] = (camera.position(camera.FIRST, camera.FRONT),)
    """Where it stood last."""
    way: tuple[Frame, Frame, float] | None = None
    """From where to where it moves, and since when."""
    own: bool = False
    """Whether its visitor has moved it himself, to leave alone."""
    folded_at: float | None = None
    """When the charts were made to give way; None if they were not."""
    narrow: float = 0.0
    """Width of the picture then."""
    gained: float = 0.0
    """By how much it became wider by that."""
    checked: tuple[object, ...] = ()

    def was_moved(self, now: float) -> bool:
        """Tell whether the visitor has moved it since it was placed."""
        if self.way is not None or now - self.placed_at < _ECHO_SECONDS:
            return False
        seen = np.asarray(self.client.camera.position)
        # A slow browser may still tell of where it was before.
        return all(np.abs(seen - one).max() > _NEAR for one in self.placed)

    def put(self, frame: Frame, now: float) -> None:
        """Show a frame at once."""
        self.shown, self.placed_at = frame, now
        position = camera.position(frame, self.direction)
        self.placed = (*self.placed[-_REMEMBERED:], position)
        place(self.client, position, frame.centre)


def aspect_of(client: viser.ClientHandle) -> float:
    """Return the width of a visitor's picture over its height, whatever his browser says."""
    width, height = client.camera.image_width, client.camera.image_height
    if not (width > 0 and height > 0):  # hidden, or no browser
        return 1.0
    return float(np.clip(width / height, 0.1, 10.0))


def place(client: viser.ClientHandle, position: FloatArray, look_at: FloatArray) -> None:
    """Put a camera somewhere."""
    with client.atomic():
        client.camera.up_direction = (0.0, 1.0, 0.0)
        client.camera.position = position
        client.camera.look_at = look_at
    client.flush()


NOTHING = Subject(knees=(None, None, None), spatial=False, landscape=False)


class Framing:
    """The cameras of all who look at a page.

    Parameters
    ----------
    clients : callable
        Returns the clients that look at it, by their number.
    charts : PanelHandle, optional
        What gives way in a narrow window.
    post : callable
        Gets ("resized", client's number).
    """

    def __init__(
        self, clients: Callable[[], dict[int, viser.ClientHandle]], charts: Any, post: Post
    ) -> None:
        self._clients, self._charts, self._post = clients, charts, post
        self._cameras: dict[int, _Camera] = {}
        self._subject: Seen = NOTHING
        self._points: FloatArray | None = None
        self._folds = count(1)

    @property
    def running(self) -> bool:
        """Whether a camera is on its way."""
        return any(held.way is not None for held in self._cameras.values())

    def join(self, client: viser.ClientHandle, subject: Seen, now: float) -> None:
        """Place the camera of a visitor who has come, and watch his window."""
        held = _Camera(client, aspect_of(client))
        self._cameras[client.client_id] = held

        # On viser's own thread, for a camera tells fifty times a second.
        async def told(event: Any) -> None:
            if abs(aspect_of(client) / held.aspect - 1.0) > 0.01:
                self._post(("resized", client.client_id), None)

        client.camera.on_update(told)
        self._fold(held, now)
        self.reset(subject, now, only=client.client_id)

    def resize(self, client_id: int, now: float) -> None:
        """Take a window's new size."""
        held = self._cameras.get(client_id)
        if held is None:
            return
        held.own = held.own or held.was_moved(now)
        held.aspect = aspect_of(held.client)
        self._fold(held, now)

    def _fold(self, held: _Camera, now: float) -> None:
        """Let the charts give way in a narrow window, and come back in a wide one."""
        if self._charts is None:
            return
        width, height = held.client.camera.image_width, held.client.camera.image_height
        if held.folded_at is None:
            if width < NARROW * height:
                held.folded_at, held.narrow, held.gained = now, width, 0.0
                viser_internals.fold_panel(held.client, self._charts, True, next(self._folds))
            return
        if now - held.folded_at < _ECHO_SECONDS:
            held.gained = max(held.gained, width - held.narrow)
        elif width - held.gained > _UNFOLDED * NARROW * height:
            held.folded_at = None
            viser_internals.fold_panel(held.client, self._charts, False, next(self._folds))

    def reset(self, subject: Seen, now: float, only: int | None = None) -> None:
        """Show everything again to all visitors, or to one."""
        self._look(subject)
        for client_id, held in self._here().items():
            if only in (None, client_id):
                held.own, held.way, held.direction = False, None, subject.direction
                self._steer(held, partial(held.put, self._best(held), now))

    def _steer(self, held: _Camera, put: Callable[[], None]) -> None:
        # A locked camera turns while position and target come one after the other.
        viser_internals.set_camera_lock(held.client, locked=False)
        put()
        if self._subject.flat:
            viser_internals.set_camera_lock(held.client, locked=True)

    def _best(self, held: _Camera) -> Frame:
        if self._points is None:
            return camera.FIRST
        return frame_around(self._points, held.direction, held.aspect)

    def _here(self) -> dict[int, _Camera]:
        """Return the cameras of those who have not left."""
        for client_id in self._cameras.keys() - self._clients().keys():
            del self._cameras[client_id]
        return self._cameras

    def _look(self, subject: Seen) -> None:
        """Take what is shown now, if it is something else."""
        if subject != self._subject:
            self._subject, self._points = subject, subject.points()

    def follow(self, subject: Seen, now: float) -> None:
        """Start to move the cameras for which what is shown no longer fits."""
        self._look(subject)
        for held in self._here().values():
            if held.checked == (self._subject, held.aspect) or self._points is None:
                continue
            held.checked = (self._subject, held.aspect)
            held.own = held.own or held.was_moved(now)
            goal = held.shown if held.way is None else held.way[1]
            if not held.own and not holds(goal, self._points, held.direction, held.aspect):
                held.way = (held.shown, self._best(held), now)
                viser_internals.set_camera_lock(held.client, locked=False)

    def advance(self, now: float) -> None:
        """Carry on the cameras that are on their way."""
        for held in self._here().values():
            if held.way is None:
                continue
            start, end, began = held.way
            share = min((now - began) / _EASE_SECONDS, 1.0)
            held.put(between(start, end, smooth(share)), now)
            if share >= 1.0:
                held.way = None
                if self._subject.flat:
                    viser_internals.set_camera_lock(held.client, locked=True)

    def moved_by_visitors(self, now: float) -> dict[int, tuple[FloatArray, FloatArray]]:
        """Return position and target of the cameras that visitors have moved themselves."""
        return {
            client_id: (
                np.asarray(held.client.camera.position),
                np.asarray(held.client.camera.look_at),
            )
            for client_id, held in self._cameras.items()
            if held.own or held.was_moved(now)
        }

    def put_back(
        self, kept: dict[int, tuple[FloatArray, FloatArray]], subject: Seen, now: float
    ) -> None:
        """Put cameras back that visitors had moved themselves; the others show everything."""
        self.reset(subject, now)
        for client_id, spot in kept.items():
            held = self._cameras.get(client_id)
            if held is not None:
                held.own = True
                self._steer(held, partial(place, held.client, *spot))

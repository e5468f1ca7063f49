"""What one connection may send, and how many there may be."""

import time
from collections.abc import Callable
from functools import reduce
from operator import or_
from typing import Annotated, Any, Generic, Literal, TypeVar

import msgspec
from msgspec import Meta, Struct

MAX_MESSAGE = 640 * 1024
"""Bytes; the page sends a file in parts of 512 kB."""
MAX_SHORT_MESSAGE = 64 * 1024
"""Bytes of a message that is no part of a file."""
MAX_WAITING = 4
"""Messages of a connection that have arrived and wait to be read."""
MAX_CONNECTIONS = 128
MESSAGES_PER_SECOND, BURST = 200.0, 400.0
"""A page sends some 20 messages a second from each tab and 50 of its camera."""
FREE_FRAMES, SILENT_SECONDS = 20, 1.0
"""What is sent to a page before it has joined (the state takes three), and how often after that."""
_BYTES_A_MESSAGE = 16 * 1024
_MALFORMED_COST = 10.0

_Text = Annotated[str, Meta(max_length=1000)]
_Id = Annotated[str, Meta(max_length=100)]
_Number = Annotated[float, Meta(ge=-1e9, le=1e9)]
_Count = Annotated[int, Meta(ge=-1, le=2**40)]
_Three = tuple[_Number, _Number, _Number]
_Modifier = Annotated[str, Meta(max_length=30)]


class Message(Struct, tag_field="type", forbid_unknown_fields=True):
    """What a page sends."""


class ViewerCamera(Message, tag="ViewerCameraMessage"):
    """Where the visitor looks from; the first that a page sends."""

    wxyz: tuple[_Number, _Number, _Number, _Number]
    position: _Three
    fov: _Number
    near: _Number
    far: _Number
    image_height: _Number
    image_width: _Number
    look_at: _Three
    up_direction: _Three


class GuiUpdate(Message, tag="GuiUpdateMessage"):
    """A widget was moved or pressed; its value is checked where the widget is known."""

    uuid: _Id
    updates: dict[_Id, Any]


class CommandTrigger(Message, tag="CommandTriggerMessage"):
    """A command's key was pressed."""

    uuid: _Id


class SceneNodeClick(Message, tag="SceneNodeClickMessage"):
    """A handle on the knee was clicked."""

    name: _Id
    instance_index: _Count | None
    ray_origin: _Three
    ray_direction: _Three
    screen_pos: tuple[_Number, _Number]
    modifier: _Modifier | None
    owner: _Id


class SceneNodeDrag(Message, tag="SceneNodeDragMessage"):
    """A handle is dragged; whether its places are places is checked where the handle is known."""

    phase: Literal["start", "update", "end"]
    name: _Id
    instance_index: _Count | None
    start_position: tuple[float, float, float]
    start_screen_pos: tuple[float, float]
    end_position: tuple[float, float, float]
    end_screen_pos: tuple[float, float]
    button: Literal["left", "middle", "right"]
    modifier: _Modifier | None
    owner: _Id


class FileTransferStartUpload(Message, tag="FileTransferStartUpload"):
    """A file is announced."""

    source_component_uuid: _Id
    transfer_uuid: _Id
    filename: _Text
    mime_type: _Text
    part_count: _Count
    size_bytes: _Count


class FileTransferPart(Message, tag="FileTransferPart"):
    """A part of a file."""

    source_component_uuid: _Id | None
    transfer_uuid: _Id
    part_index: _Count
    content: bytes


ACCEPTED = (
    ViewerCamera,
    GuiUpdate,
    CommandTrigger,
    SceneNodeClick,
    SceneNodeDrag,
    FileTransferStartUpload,
    FileTransferPart,
)
"""All that the page sends; viser knows more kinds, which none of our widgets needs."""
_decode: Callable[[bytes], Message] = msgspec.msgpack.Decoder(reduce(or_, ACCEPTED)).decode


def understood(raw: str | bytes) -> Message | None:
    """Return a message that our page could have sent, decoded, or None."""
    if not isinstance(raw, bytes):
        return None
    try:
        message = _decode(raw)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        return None
    if len(raw) > MAX_SHORT_MESSAGE and not isinstance(message, FileTransferPart):
        return None
    return message


class Pace:
    """How fast a connection is read: who sends faster waits, as his own socket's buffer is full.

    Nothing is lost by it, and an honest page never feels it.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._credit, self._seen = BURST, clock()

    def charge(self, size: int, *, malformed: bool = False) -> float:
        """Count a message of `size` bytes; return how long to wait before the next one, s."""
        now = self._clock()
        self._credit = min(self._credit + (now - self._seen) * MESSAGES_PER_SECOND, BURST)
        self._seen = now
        self._credit -= (1.0 + size / _BYTES_A_MESSAGE) * (_MALFORMED_COST if malformed else 1.0)
        return max(-self._credit / MESSAGES_PER_SECOND, 0.0)


T = TypeVar("T")


class Crowd(Generic[T]):
    """The open connections, at most `limit`.

    When one more comes, the oldest of those that have not shown yet what they want has to go:
    connections that say nothing can neither fill the server nor keep a visitor out.
    """

    def __init__(self, limit: int = MAX_CONNECTIONS) -> None:
        self._limit = limit
        self._silent: dict[T, None] = {}
        self._known: set[T] = set()

    def __len__(self) -> int:
        return len(self._silent) + len(self._known)

    def enter(self, connection: T) -> T | None:
        """Count one more; return the connection that must go for it, if any: maybe itself."""
        goes: T | None = None
        if len(self) >= self._limit:
            goes = next(iter(self._silent), connection)
            self._silent.pop(goes, None)
        if goes is not connection:
            self._silent[connection] = None
        return goes

    def know(self, connection: T) -> None:
        """Note that a connection belongs to a visitor."""
        if connection in self._silent:
            del self._silent[connection]
            self._known.add(connection)

    def leave(self, connection: T) -> None:
        """Count one less."""
        self._silent.pop(connection, None)
        self._known.discard(connection)

"""A visitor without a browser: speaks viser's protocol over a WebSocket and keeps what it is told.

It sends anything, also what no browser would, and decodes what a browser would draw.
"""

import contextlib
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import msgspec
import numpy as np
import viser
import zstandard
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (0.0, 0.0, 2.0),
    "fov": 0.17,
    "near": 0.1,
    "far": 20.0,
    "image_height": 640,
    "image_width": 1000,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 1.0, 0.0),
}


def _decoded(value: Any, arrays: list[bytes]) -> Any:
    if isinstance(value, dict):
        if "__binary_index" in value:
            return np.frombuffer(arrays[value["__binary_index"]], dtype=value["dtype"])
        return {k: _decoded(v, arrays) for k, v in value.items()}
    if isinstance(value, list):
        return [_decoded(v, arrays) for v in value]
    return value


def decode_frame(frame: bytes) -> list[dict[str, Any]]:
    """Return the messages of one frame, arrays decoded."""
    size = int.from_bytes(frame[8:16], "little")
    document = msgspec.msgpack.decode(zstandard.decompress(frame[16 : 16 + size]))
    at, arrays = 16 + size, []
    for length in document["binaryBufferLengths"]:
        at += -at % 8
        arrays.append(frame[at : at + length])
        at += length
    return [_decoded(message, arrays) for message in document["messages"]]


_SET_IN_SCENE = {
    "SetOrientationMessage": "wxyz",
    "SetPositionMessage": "position",
    "SetSceneNodeVisibilityMessage": "visible",
}
"""What has a message of its own in viser, and what it is of a node."""


class WebSocketClient:
    """One visitor. Use it as a context manager.

    Parameters
    ----------
    port : int
        Where the server listens on 127.0.0.1.
    on_message : callable, optional
        Called with every message.
    path : str
        What follows the port in the address.
    headers : mapping, optional
        Further headers of the request, such as ``Origin`` or ``Cookie``.
    camera : mapping, optional
        The first message: its camera and its window.
    """

    def __init__(
        self,
        port: int,
        *,
        on_message: Callable[[dict[str, Any]], None] | None = None,
        path: str = "",
        headers: Mapping[str, str] | None = None,
        camera: Mapping[str, Any] = CAMERA,
    ):
        self.port = port
        self._socket = connect(
            f"ws://127.0.0.1:{port}{path}",
            additional_headers=headers,
            subprotocols=[f"viser-v{viser.__version__}"],
            max_size=None,
            compression=None,
        )
        self._on_message = on_message
        self._lock = threading.Lock()
        self._news = threading.Condition(self._lock)
        self.values: dict[str, Any] = {}
        self.props: dict[str, dict[str, Any]] = {}
        self.notifications: list[dict[str, Any]] = []
        self.downloads: dict[str, bytes] = {}
        self._names: dict[str, str] = {}
        self.scene: dict[str, dict[str, Any]] = {}
        self.counts: dict[str, int] = {}
        self.frames = 0
        self.arrived = 0.0
        """When the last frame that was taken in arrived, before its decoding (`perf_counter`)."""
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self.send(dict(camera))

    def __enter__(self) -> "WebSocketClient":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._socket.close()
        self._reader.join(5.0)

    def send(self, message: dict[str, Any]) -> None:
        self._socket.send(msgspec.msgpack.encode(message))

    def send_raw(self, content: bytes) -> None:
        self._socket.send(content)

    def set(self, uuid: str, value: Any) -> None:
        self.update(uuid, {"value": value})

    def update(self, uuid: str, updates: Any) -> None:
        self.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": updates})

    def click(self, node: str) -> None:
        """Click a node of the scene."""
        self.send(
            {
                "type": "SceneNodeClickMessage",
                "name": node,
                "instance_index": None,
                "ray_origin": (0.0, 0.0, 2.0),
                "ray_direction": (0.0, 0.0, -1.0),
                "screen_pos": (0.5, 0.5),
                "modifier": None,
                "owner": "",
            }
        )

    def drag(self, node: str, phase: str, start: Sequence[float], end: Sequence[float]) -> None:
        """Tell of a drag of a node: where it was taken hold of, and where the pointer is."""
        self.send(
            {
                "type": "SceneNodeDragMessage",
                "phase": phase,
                "name": node,
                "instance_index": None,
                "start_position": [float(v) for v in start],
                "start_screen_pos": (0.5, 0.5),
                "end_position": [float(v) for v in end],
                "end_screen_pos": (0.5, 0.5),
                "button": "left",
                "modifier": None,
                "owner": "",
            }
        )

    def upload(self, uuid: str, name: str, content: bytes, *, size: int | None = None) -> None:
        self.send(
            {
                "type": "FileTransferStartUpload",
                "source_component_uuid": uuid,
                "transfer_uuid": f"transfer-{name}",
                "filename": name,
                "mime_type": "text/plain",
                "part_count": 1,
                "size_bytes": len(content) if size is None else size,
            }
        )
        self.send(
            {
                "type": "FileTransferPart",
                "source_component_uuid": uuid,
                "transfer_uuid": f"transfer-{name}",
                "part_index": 0,
                "content": content,
            }
        )

    def wait(self, condition: Callable[["WebSocketClient"], Any], timeout: float = 60.0) -> Any:
        """Return the condition's first true value; an AssertionError after `timeout` s."""
        end = time.monotonic() + timeout
        with self._news:
            while True:
                value = condition(self)
                if value:
                    return value
                left = end - time.monotonic()
                assert left > 0.0, "what was waited for did not come"
                self._news.wait(min(left, 0.1))

    def _read(self) -> None:
        with contextlib.suppress(ConnectionClosed, OSError, EOFError):
            for frame in self._socket:
                arrived = time.perf_counter()
                messages = decode_frame(frame)
                with self._news:
                    self.arrived = arrived
                    self.frames += 1
                    for message in messages:
                        self._take(message)
                    self._news.notify_all()

    def _take(self, message: dict[str, Any]) -> None:
        kind = message["type"]
        self.counts[kind] = self.counts.get(kind, 0) + 1
        if self._on_message is not None:
            self._on_message(message)
        if kind == "GuiUpdateMessage":
            updates = dict(message["updates"])
            if "value" in updates:
                self.values[message["uuid"]] = updates.pop("value")
            self.props.setdefault(message["uuid"], {}).update(updates)
        elif kind.startswith("Gui") and "props" in message and "uuid" in message:
            self.props[message["uuid"]] = dict(message["props"])
            self.values[message["uuid"]] = message.get("value")
        elif kind == "NotificationShowMessage":
            self.notifications.append(message)
        elif kind == "SceneNodeUpdateMessage":
            self.scene.setdefault(message["name"], {}).update(message["updates"])
        elif kind in _SET_IN_SCENE:
            key = _SET_IN_SCENE[kind]
            self.scene.setdefault(message["name"], {})[key] = message[key]
        elif kind == "FileTransferStartDownload":
            self._names[message["transfer_uuid"]] = message["filename"]
            self.downloads[message["filename"]] = b""
        elif kind == "FileTransferPart":
            self.downloads[self._names[message["transfer_uuid"]]] += message["content"]

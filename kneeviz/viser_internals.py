"""What viser's API cannot do yet (1.1.1, pinned): the private parts that are touched for it.

viser checks nothing that comes from a browser: any attribute of any widget can be set, values may
have any type, range or size, and disabled buttons can be clicked. So every message passes here
before viser handles it. The flat view's camera lock and the repair of a browser that disagrees
with the server have no public call either. What passes on the wire is another matter:
`kneeviz.server.caps` says in words of its own what our page may send, and touches nothing of viser.
How news go out to many is `kneeviz.viser_broadcast`; no third module touches such parts.
"""

import asyncio
import math
import time
import weakref
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy.typing as npt
import viser
from viser import _assignable_props_api, _client_autobuild, infra
from viser import _gui_handles as handles
from viser import _messages as messages

_SERVES = "viser.infra._infra"
"""Where viser keeps what it does with a connection."""
MAX_UPLOAD = 5_000_000
"""Bytes; a result is a few hundred thousand, a knee ten thousand."""
MAX_TEXT = 8000
"""Characters of a text that a page may send; a link's has fewer."""
_MAX_PARTS = 64
_PENDING, _PENDING_BYTES = 2, 2 * MAX_UPLOAD
"""Uploads of one visitor that are not finished, and what they may hold together."""
_PENDING_OF_ALL, _PENDING_BYTES_OF_ALL = 16, 4 * MAX_UPLOAD
_PATIENCE = 30.0  # s without a new part, after which an upload is given up
_ACKS_KEPT = 64
_MOST_SLACK = 1e-3
"""A whole number, however large its range, is rounded into it."""
_guarded: "weakref.WeakSet[Any]" = weakref.WeakSet()
"""The `gui` objects whose unfinished uploads are counted together."""

Reject = Callable[[int, Any, str, Any], None]
"""Called with the client's number, the widget (None if unknown), what is wrong, in words, and the
value that was sent, if it was one."""
Arrival = Callable[[int, Any], None]
"""Called with the client's number and the value that it sent."""
_arrivals: "weakref.WeakKeyDictionary[Any, dict[str, Arrival]]" = weakref.WeakKeyDictionary()
"""What is called when a browser sends a widget's value, by `gui` and the widget's id."""

_FLAT_CAMERA = """
  c.minAzimuthAngle = c.maxAzimuthAngle = Math.PI;
  c.minPolarAngle = c.maxPolarAngle = Math.PI / 2;
  c.mouseButtons.left = 2; c.mouseButtons.right = 2; c.touches.one = 64;
"""
_FREE_CAMERA = """
  c.minAzimuthAngle = -Infinity; c.maxAzimuthAngle = Infinity;
  c.minPolarAngle = 0; c.maxPolarAngle = Math.PI;
  c.mouseButtons.left = 1; c.mouseButtons.right = 2; c.touches.one = 32;
"""
_WHEN_READY = """(() => {{
  window.__kneevizCamera = {token};
  const apply = () => {{
    const c = window.__viserMutable && window.__viserMutable.cameraControl;
    if (window.__kneevizCamera !== {token}) return;
    if (!c) {{ setTimeout(apply, 50); return; }}
    {body}
  }};
  apply();
}})();"""


def run_script(client: viser.ClientHandle, source: str) -> None:
    """Let this client's page run a script."""
    client.gui._websock_interface.queue_message(messages.RunJavascriptMessage(source=source))


def set_camera_lock(client: viser.ClientHandle, locked: bool) -> None:
    """Let the mouse only pan and zoom in this client (locked), or orbit as well (free)."""
    body = _FLAT_CAMERA if locked else _FREE_CAMERA
    source = _WHEN_READY.format(token=1 if locked else 2, body=body)
    run_script(client, source)


def fold_panel(client: viser.ClientHandle, panel: Any, folded: bool, number: int) -> None:
    """Fold a panel to a strip, or unfold it, in this client alone.

    `number` rises from call to call: a browser takes only what is newer than what it has.
    """
    told = messages.GuiSetPanelCollapsedMessage(
        panel._placement_uuid, folded, counter=number, run_id=f"client {client.client_id}"
    )
    client.gui._websock_interface.queue_message(told)


def force_value(gui: Any, handle: Any) -> None:
    """Send a widget's value even if the server believes that the browser has it."""
    gui._websock_interface.queue_message(
        messages.GuiUpdateMessage(handle._impl.uuid, {"value": handle.value})
    )


def widget_id(handle: Any) -> str:
    """Return the id under which the browser knows a widget."""
    return str(handle._impl.uuid)


def skip_client_build() -> None:
    """Let a new server not look for a compiler: an installed client is always built."""
    _client_autobuild.ensure_client_is_built = lambda: None


class _ArrayTypes(dict[Any, Any]):
    """The types ``NDArray[...]``, each made once."""

    def __missing__(self, kind: Any) -> Any:
        made = self[kind] = npt.NDArray[kind]
        return made


def know_array_types() -> None:
    """Let viser not make the types anew that it compares with whenever a property is assigned.

    They took a third of the time in which a page is brought up to date.
    """
    vars(_assignable_props_api)["npt"] = SimpleNamespace(NDArray=_ArrayTypes())


def is_own_server(handler: Any) -> bool:
    """Tell whether it is viser that starts a WebSocket server, by what it does with connections."""
    return getattr(handler, "__module__", None) == _SERVES


def subprotocol() -> str:
    """Return what a page of the same version says that it speaks."""
    return f"viser-v{viser.__version__}"


def refuse_tunnel(server: viser.ViserServer) -> None:
    """Drop requests for a public address, which a client could make without any button."""
    interface = server._websock_server
    if messages.ShareUrlRequest in interface._incoming_handlers:
        interface.unregister_handler(messages.ShareUrlRequest)


def connection_of(server: viser.ViserServer, client_id: int) -> Any:
    """Return the connection of a client, or None if it is gone."""
    return server._websock_server._live_connections.get(client_id)


def end_drags(server: viser.ViserServer, client_id: int) -> None:
    """Let a client's drags of the server's nodes end where they are, as if it had let go."""
    client = server.get_clients().get(client_id)
    number = infra.ClientId(client_id)
    ended = server.scene._drop_active_drags_for_client(number, event_client=client)
    asyncio.run_coroutine_threadsafe(ended, server.get_event_loop())


def dropped(gui: Any, client_id: int, message: Any) -> Any:
    """Return the widget of a message that was dropped, or None; an upload's notice ends."""
    if hasattr(message, "transfer_uuid") and hasattr(message, "size_bytes"):
        _acknowledge(gui, client_id, message)
    return gui._gui_input_handle_from_uuid.get(getattr(message, "uuid", None))


def guard(gui: Any, reject: Reject) -> None:
    """Put checks in front of all that a `gui` (the server's or a client's) takes from browsers."""
    _guard_values(gui, reject)
    _guard_uploads(gui, reject)


def _guard_values(gui: Any, reject: Reject) -> None:
    take = gui._handle_gui_updates
    gui._websock_interface.unregister_handler(messages.GuiUpdateMessage, take)

    async def checked(client_id: int, message: Any) -> None:
        handle = gui._gui_input_handle_from_uuid.get(message.uuid)
        if handle is None:
            return
        fault = update_fault(handle, message.updates)
        if fault is not None:
            reject(client_id, handle, fault, message.updates.get("value"))
            return
        value = type(handle.value)(message.updates["value"])
        await take(client_id, message)
        arrival = _arrivals.get(gui, {}).get(message.uuid)
        if arrival is not None:
            arrival(client_id, value)

    gui._websock_interface.register_handler(messages.GuiUpdateMessage, checked)


def on_arrival(handle: Any, call: Arrival) -> None:
    """Have `call` called, on viser's event loop, with each value of a widget from a browser.

    viser's own callbacks read the value from the widget, where another thread may have set a
    different one since it arrived, and are not called if another has just set the same.
    """
    _arrivals.setdefault(handle._impl.gui_api, {})[widget_id(handle)] = call


def _guard_uploads(gui: Any, reject: Reject) -> None:
    _guarded.add(gui)
    begin, go_on = gui._handle_file_transfer_start, gui._handle_file_transfer_part
    interface = gui._websock_interface
    interface.unregister_handler(messages.FileTransferStartUpload, begin)
    interface.unregister_handler(messages.FileTransferPart, go_on)

    def checked_start(client_id: int, message: Any) -> None:
        handle = gui._gui_input_handle_from_uuid.get(message.source_component_uuid)
        if not isinstance(handle, handles.GuiUploadButtonHandle):
            return
        fault = upload_fault(message.size_bytes, message.part_count)
        _give_up_old_uploads()
        fault = fault or crowding_fault(client_id, message.transfer_uuid, message.size_bytes)
        _forget_old_acks(gui)
        if handle.disabled:
            fault = "that button cannot be used now"
        if fault is not None:
            _acknowledge(gui, client_id, message)
            reject(client_id, handle, fault, None)
            return
        begin(client_id, message)
        if message.transfer_uuid in gui._current_file_upload_states:
            gui._current_file_upload_states[message.transfer_uuid]["touched"] = time.monotonic()

    def checked_part(client_id: int, message: Any) -> None:
        state = gui._current_file_upload_states.get(message.transfer_uuid)
        if state is None or state["client_id"] != client_id:
            return
        if state["transferred_bytes"] + len(message.content) > state["total_bytes"]:
            gui._current_file_upload_states.pop(message.transfer_uuid, None)
            reject(client_id, None, "the upload is larger than it said", None)
            return
        state["touched"] = time.monotonic()
        go_on(client_id, message)

    interface.register_handler(messages.FileTransferStartUpload, checked_start)
    interface.register_handler(messages.FileTransferPart, checked_part)


def _acknowledge(gui: Any, client_id: int, message: Any) -> None:
    """Tell the browser that a refused upload is over, or its progress notice stays for ever."""
    gui._websock_interface.queue_message(
        messages.FileTransferPartAck(
            source_component_uuid=message.source_component_uuid,
            transfer_uuid=message.transfer_uuid,
            transferred_bytes=message.size_bytes,
            total_bytes=message.size_bytes,
        )
    )


def unfinished_uploads() -> dict[str, Any]:
    """Return what viser keeps of the uploads that are under way, by their name on the wire."""
    return {
        name: state
        for gui in list(_guarded)
        for name, state in list(gui._current_file_upload_states.items())
    }


def _give_up_old_uploads() -> None:
    """Drop the uploads of which no part has come for long."""
    for gui in list(_guarded):
        states = gui._current_file_upload_states
        for name, state in list(states.items()):
            if time.monotonic() - state.get("touched", math.inf) > _PATIENCE:
                states.pop(name, None)


def crowding_fault(client_id: int, name: str, size_bytes: int) -> str | None:
    """Return why one more upload is too much, for its visitor or for the server, or None."""
    under_way = unfinished_uploads()
    if name in under_way:
        return "that upload is under way already"
    own = [s["total_bytes"] for s in under_way.values() if s["client_id"] == client_id]
    all_ = [s["total_bytes"] for s in under_way.values()]
    if len(own) >= _PENDING or sum(own) + size_bytes > _PENDING_BYTES:
        return "your other uploads are not finished yet"
    if len(all_) >= _PENDING_OF_ALL or sum(all_) + size_bytes > _PENDING_BYTES_OF_ALL:
        return "too many files are on their way; please try again in a minute"
    return None


def _forget_old_acks(gui: Any) -> None:
    """Drop all but the last acknowledgements, of which viser's buffer keeps every one for ever."""
    buffer = gui._websock_interface.get_message_buffer()
    with buffer.buffer_lock:
        acks = [
            number
            for number, message in buffer.message_from_id.items()
            if isinstance(message, messages.FileTransferPartAck)
        ]
        for number in acks[:-_ACKS_KEPT]:
            buffer.pop_message_locked(number)


def upload_fault(size_bytes: Any, part_count: Any) -> str | None:
    """Return what is wrong with an announced upload, or None."""
    if not isinstance(size_bytes, int) or not isinstance(part_count, int):
        return "the upload is malformed"
    if size_bytes > MAX_UPLOAD:
        return f"the file has {size_bytes:,} bytes; at most {MAX_UPLOAD:,} are allowed"
    if size_bytes < 0 or not 0 <= part_count <= _MAX_PARTS:
        return "the upload is malformed"
    return None


def update_fault(handle: Any, updates: Any) -> str | None:
    """Return what is wrong with a widget's update from a browser, or None.

    Parameters
    ----------
    handle : GuiInputHandle
        The widget.
    updates : Any
        What the browser wants to set; only ``{"value": ...}`` of the right kind passes.
    """
    if not isinstance(updates, dict) or set(updates) != {"value"}:
        return "only its value can be changed"
    if getattr(handle, "disabled", False):
        return "it cannot be used now"
    return value_fault(handle, updates["value"])


def value_fault(handle: Any, value: Any) -> str | None:
    """Return why a widget cannot have a value that somebody else has told, or None."""
    if isinstance(handle, handles.GuiSliderHandle | handles.GuiNumberHandle):
        return number_fault(value, handle.min, handle.max)
    if isinstance(handle, handles.GuiButtonGroupHandle | handles.GuiDropdownHandle):
        return None if value in handle.options else "that is not one of its choices"
    if isinstance(handle, handles.GuiCheckboxHandle | handles.GuiButtonHandle):
        return None if isinstance(value, bool) else "it is either on or off"
    if isinstance(handle, handles.GuiTextHandle):
        return None if isinstance(value, str) and len(value) <= MAX_TEXT else "it is no short text"
    return "it takes no value"


def number_fault(value: Any, low: float | None, high: float | None) -> str | None:
    """Return what is wrong with a number from a browser, or None.

    The bounds forgive the rounding of a number that was shown with few digits.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return "a finite number is needed"
    slack = min(1e-6 * max(abs(low or 0.0), abs(high or 0.0), 1.0), _MOST_SLACK)
    if (low is not None and value < low - slack) or (high is not None and value > high + slack):
        return f"{value:g} is outside {_edge(low)} to {_edge(high)}"
    return None


def _edge(value: float | None) -> str:
    return "any" if value is None else f"{value:g}"


__all__ = [
    "MAX_TEXT",
    "MAX_UPLOAD",
    "connection_of",
    "crowding_fault",
    "dropped",
    "end_drags",
    "force_value",
    "guard",
    "is_own_server",
    "know_array_types",
    "number_fault",
    "on_arrival",
    "refuse_tunnel",
    "run_script",
    "set_camera_lock",
    "skip_client_build",
    "subprotocol",
    "unfinished_uploads",
    "update_fault",
    "upload_fault",
    "value_fault",
    "widget_id",
]

"""What a visitor is told when something he sent was turned away: once, and only him."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import viser

from kneeviz import viser_internals

QUIET_SECONDS = 0.8
"""A number that is being typed is wrong until its last digit: wait for this long a pause."""
_SHOWN_SECONDS = 8.0


@dataclass
class _Waiting:
    """What a client is told once he has paused."""

    title: str
    text: str
    due: float
    handle: Any = None
    """The widget whose value was turned away."""
    sent: Any = None
    """That value."""


class Notices:
    """Collects what clients are to be told, and tells each once he has paused."""

    def __init__(self, clients: Callable[[], dict[int, Any]], gui: viser.GuiApi) -> None:
        self._clients, self._gui = clients, gui
        self._waiting: dict[tuple[int, str], _Waiting] = {}

    def complain(
        self, client_id: int, handle: Any, fault: str, sent: Any = None, *, now: float | None = None
    ) -> None:
        """Note a fault of what was `sent`; a later one of the same client takes its place."""
        text = f"{_named(handle, fault)}. The last value stands."
        self._wait(client_id, _Waiting("Not taken", text, _due(now), handle, sent))

    def remark(
        self, client_id: int | None, title: str, text: str, *, now: float | None = None
    ) -> None:
        """Note something for a client, or for all; a later one of this title takes its place."""
        for number in self._clients() if client_id is None else (client_id,):
            self._wait(number, _Waiting(title, text, _due(now)))

    def _wait(self, client_id: int, waiting: _Waiting) -> None:
        self._waiting[client_id, waiting.title] = waiting

    def withdraw(self, client_id: int, handle: Any, value: Any) -> None:
        """Forget a fault of a widget that has sent something good since.

        A browser puts a number that was too large to its limit when the widget is left: that is
        told, since nobody has typed it.
        """
        waiting = self._waiting.get((client_id, "Not taken"))
        if waiting is None or waiting.handle is not handle:
            return
        del self._waiting[client_id, waiting.title]
        if _is_limited(handle, waiting.sent, value):
            text = _named(handle, f"{waiting.sent:g} was limited to {value:g}")
            self.tell(client_id, "Limited", f"{text}.")

    def deliver(self, now: float) -> float | None:
        """Tell those whose pause is over; return when the next is due."""
        for (client_id, title), waiting in list(self._waiting.items()):
            if waiting.due <= now:
                del self._waiting[client_id, title]
                self.tell(client_id, title, waiting.text)
                if hasattr(waiting.handle, "value") and not _is_button(waiting.handle):
                    viser_internals.force_value(self._gui, waiting.handle)
        return min((w.due for w in self._waiting.values()), default=None)

    def tell(self, client_id: int, title: str, text: str, *, bad: bool = True) -> None:
        """Show one notification to one client, if he is still there."""
        client = self._clients().get(client_id)
        if client is None:
            return
        client.add_notification(
            title,
            text,
            with_close_button=True,
            auto_close_seconds=_SHOWN_SECONDS,
            color=(214, 51, 108) if bad else (43, 138, 62),
        )
        client.flush()


def _is_button(handle: Any) -> bool:
    return isinstance(handle.value, bool) and not hasattr(handle, "min")


def _due(now: float | None) -> float:
    return (time.monotonic() if now is None else now) + QUIET_SECONDS


def _named(handle: Any, text: str) -> str:
    label = getattr(handle, "label", None)
    return f"{label}: {text}" if label else text


def _is_limited(handle: Any, sent: Any, value: Any) -> bool:
    """Tell whether `value` is the limit that `sent` went beyond, and not what was typed on."""
    limits = (getattr(handle, "min", None), getattr(handle, "max", None))
    if type(sent) not in (int, float) or value not in limits:
        return False
    return not f"{value:g}".startswith(f"{sent:g}")

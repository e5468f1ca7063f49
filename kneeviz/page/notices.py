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
class _Complaint:
    handle: Any
    text: str
    due: float


class Notices:
    """Collects faults by client and tells each client once he has paused."""

    def __init__(self, clients: Callable[[], dict[int, Any]], gui: viser.GuiApi) -> None:
        self._clients, self._gui = clients, gui
        self._waiting: dict[int, _Complaint] = {}

    def complain(
        self, client_id: int, handle: Any, fault: str, *, now: float | None = None
    ) -> None:
        """Note a fault; a later one of the same client takes its place."""
        label = getattr(handle, "label", None)
        text = f"{label}: {fault}" if label else fault
        due = (time.monotonic() if now is None else now) + QUIET_SECONDS
        self._waiting[client_id] = _Complaint(handle, text, due)

    def withdraw(self, client_id: int, handle: Any) -> None:
        """Forget a fault of a widget that has sent something good since."""
        waiting = self._waiting.get(client_id)
        if waiting is not None and waiting.handle is handle:
            del self._waiting[client_id]

    def deliver(self, now: float) -> float | None:
        """Tell those whose pause is over; return when the next is due."""
        for client_id, complaint in list(self._waiting.items()):
            if complaint.due <= now:
                del self._waiting[client_id]
                self.tell(client_id, "Not taken", f"{complaint.text}. The last value stands.")
                if hasattr(complaint.handle, "value") and not _is_button(complaint.handle):
                    viser_internals.force_value(self._gui, complaint.handle)
        return min((c.due for c in self._waiting.values()), default=None)

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

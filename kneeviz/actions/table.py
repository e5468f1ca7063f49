"""What can be asked of a session, by name. Runs on the session's worker."""

import time
from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, Any

from kneeviz.actions import files as do_files
from kneeviz.actions import knee as do_knee
from kneeviz.actions import landscape as do_landscape
from kneeviz.actions import lesson as do_lesson
from kneeviz.actions import live as do_live
from kneeviz.actions import methods as do_methods
from kneeviz.actions import search as do_search
from kneeviz.actions import study as do_study
from kneeviz.actions import view as do_view
from kneeviz.views.tabs.controls import Asked

if TYPE_CHECKING:
    from kneeviz.server.session import Session


def _reject(session: "Session", value: Any, _client: int) -> None:
    client_id, handle, fault = value
    session.notices.complain(client_id, handle, fault, now=time.monotonic())


_DEEDS: dict[str, Callable[..., None]] = {
    **do_knee.DEEDS,
    **do_view.DEEDS,
    **do_search.DEEDS,
    **do_live.DEEDS,
    **do_methods.DEEDS,
    **do_files.DEEDS,
    **do_study.DEEDS,
    **do_landscape.DEEDS,
    **do_lesson.DEEDS,
    "reject": _reject,
}


def asked_by(value: Any) -> int | None:
    """Return the number of the client whose widget asked, or None."""
    return value.client_id if isinstance(value, Asked) else None


def perform(session: "Session", key: Hashable, value: Any) -> None:
    """Do what was asked under `key`.

    `value` is an `Asked` for what came from a browser.
    """
    name, *rest = key if isinstance(key, tuple) else (key,)
    client_id = asked_by(value)
    if client_id is not None and name != "reject":
        session.notices.withdraw(client_id, value.handle)
    _DEEDS[name](session, value, *rest)

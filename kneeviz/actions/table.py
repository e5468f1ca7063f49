"""What can be asked of a page, by name. Runs on the session's worker."""

import time
from collections.abc import Callable, Hashable
from typing import Any

from kneeviz.actions import (
    export,
    files,
    knee,
    landscape,
    lesson,
    live,
    methods,
    search,
    study,
    view,
)
from kneeviz.jobs.messages import Asked
from kneeviz.page.page import Page


def _reject(page: Page, value: tuple[int, Any, str], _client: int) -> None:
    client_id, handle, fault = value
    page.notices.complain(client_id, handle, fault, now=time.monotonic())


ACTIONS: dict[str, Callable[..., None]] = {
    **knee.ACTIONS,
    **view.ACTIONS,
    **search.ACTIONS,
    **live.ACTIONS,
    **methods.ACTIONS,
    **files.ACTIONS,
    **export.ACTIONS,
    **study.ACTIONS,
    **landscape.ACTIONS,
    **lesson.ACTIONS,
    "reject": _reject,
}
"""By the name that is posted. Each gets the page, the posted value, and the rest of the key."""


def asked_by(value: Any) -> int | None:
    """Return the number of the client whose widget asked, or None."""
    return value.client_id if isinstance(value, Asked) else None


def moves_a_slider(key: Hashable) -> bool:
    """Tell whether what is asked under `key` changes one of the knee's parameters."""
    return isinstance(key, tuple) and key[0] == "param"


def perform(page: Page, key: Hashable, value: Any) -> None:
    """Do what was asked under `key`.

    `value` is an `Asked` for what came from a browser.
    """
    name, *rest = key if isinstance(key, tuple) else (key,)
    client_id = asked_by(value)
    if client_id is not None and name != "reject":
        page.notices.withdraw(client_id, value.handle)
    ACTIONS[name](page, value, *rest)

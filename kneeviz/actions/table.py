"""What can be asked of a page, by name. Runs on the session's worker."""

import time
from collections.abc import Callable, Hashable
from typing import Any

from kneeviz.actions import (
    commands,
    export,
    files,
    ghosts,
    handles,
    knee,
    landscape,
    lesson,
    links,
    live,
    methods,
    pointer,
    search,
    study,
    undo,
    view,
    visitors,
)
from kneeviz.jobs.messages import asked_by
from kneeviz.page.page import Page


def _reject(page: Page, value: tuple[int, Any, str, Any], _client: int) -> None:
    client_id, handle, fault, sent = value
    page.notices.complain(client_id, handle, fault, sent, now=time.monotonic())


ACTIONS: dict[str, Callable[..., None]] = {
    **knee.ACTIONS,
    **handles.ACTIONS,
    **view.ACTIONS,
    **pointer.ACTIONS,
    **ghosts.ACTIONS,
    **commands.ACTIONS,
    **search.ACTIONS,
    **live.ACTIONS,
    **methods.ACTIONS,
    **files.ACTIONS,
    **export.ACTIONS,
    **study.ACTIONS,
    **landscape.ACTIONS,
    **lesson.ACTIONS,
    **undo.ACTIONS,
    **links.ACTIONS,
    **visitors.ACTIONS,
    "reject": _reject,
}
"""By the name that is posted. Each gets the page, the posted value, and the rest of the key."""


def moves_a_slider(key: Hashable) -> bool:
    """Tell whether what is asked under `key` changes one of the knee's parameters."""
    return isinstance(key, tuple) and key[0] in ("param", "grab_update")


def perform(page: Page, key: Hashable, value: Any) -> None:
    """Do what was asked under `key`.

    `value` is an `Asked` for what came from a browser.
    """
    name, *rest = key if isinstance(key, tuple) else (key,)
    client_id = asked_by(value)
    if client_id is not None and name != "reject":
        page.notices.withdraw(client_id, value.handle, value.value)
    ACTIONS[name](page, value, *rest)

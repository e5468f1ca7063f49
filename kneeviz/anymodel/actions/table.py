"""What can be asked of a model's page, by name. Runs on the session's worker."""

import time
from collections.abc import Callable, Hashable
from typing import Any

from kneeviz.anymodel.actions import commands, files, inputs, look, search, study, undo
from kneeviz.anymodel.page import ModelPage
from kneeviz.jobs.messages import Asked


def _reject(page: ModelPage, value: tuple[int, Any, str, Any], _client: int) -> None:
    client_id, handle, fault, sent = value
    page.notices.complain(client_id, handle, fault, sent, now=time.monotonic())


ACTIONS: dict[str, Callable[..., None]] = {
    **inputs.ACTIONS,
    **search.ACTIONS,
    **study.ACTIONS,
    **files.ACTIONS,
    **look.ACTIONS,
    **commands.ACTIONS,
    **undo.ACTIONS,
    "reject": _reject,
}
"""By the name that is posted. Each gets the page, the posted value, and the rest of the key."""


def perform(page: ModelPage, key: Hashable, value: Any) -> None:
    """Do what was asked under `key`; `value` is an `Asked` for what came from a browser."""
    name, *rest = key if isinstance(key, tuple) else (key,)
    if isinstance(value, Asked) and name != "reject":
        page.notices.withdraw(value.client_id, value.handle, value.value)
    ACTIONS[name](page, value, *rest)

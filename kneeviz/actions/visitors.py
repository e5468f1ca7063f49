"""Visitors' windows, as they come and change. Runs on the session's worker."""

import time
from collections.abc import Callable
from typing import Any

from kneeviz import viser_scripts
from kneeviz.actions import links
from kneeviz.page.page import Page


def _joined(page: Page, _value: Any, client_id: int) -> None:
    client = page.clients().get(client_id)
    if client is not None:
        page.framing.join(client, page.subject, time.monotonic())
        viser_scripts.watch_charts(client)
        viser_scripts.look_closer(client, **page.view.pointed)
        viser_scripts.see_through(client, page.view.handles.unseen)
        viser_scripts.name_widgets(
            client, "the knees' curves", "The knee; its pose is told in the panel"
        )
        links.receive(page, client)


def _resized(page: Page, _value: Any, client_id: int) -> None:
    page.framing.resize(client_id, time.monotonic())


ACTIONS: dict[str, Callable[..., None]] = {"joined": _joined, "resized": _resized}

"""How a browser's changes become posts: a widget's callbacks only say what was asked."""

from collections.abc import Hashable
from typing import Any

from kneeviz.jobs.messages import Asked, Post


def on_value(handle: Any, post: Post, key: Hashable) -> None:
    """Post an `Asked` under `key` whenever a browser changes the widget."""

    # A coroutine runs on viser's event loop, in the order of arrival, without a pool thread.
    async def changed(event: Any) -> None:
        if event.client is not None:
            post(key, Asked(handle, event.client.client_id, event.target.value))

    handle.on_update(changed)


def on_press(handle: Any, post: Post, key: Hashable) -> None:
    """Post an `Asked` under `key` whenever a browser presses the button."""

    async def pressed(event: Any) -> None:
        if event.client is not None:
            post(key, Asked(handle, event.client.client_id, event.target.value))

    handle.on_click(pressed)


def on_command(handle: Any, post: Post, key: Hashable, value: Any = True) -> None:
    """Post an `Asked` with `value` under `key` whenever a browser gives the command."""

    async def given(event: Any) -> None:
        if event.client_id is not None:
            post(key, Asked(handle, event.client_id, value))

    handle.on_trigger(given)

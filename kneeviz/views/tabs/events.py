"""How a browser's changes become posts: a widget's callbacks only say what was asked."""

from collections.abc import Hashable
from typing import Any

from kneeviz import viser_internals
from kneeviz.jobs.messages import Asked, Post


def on_value(handle: Any, post: Post, key: Hashable) -> None:
    """Post an `Asked` under `key` whenever a browser sets the widget."""
    viser_internals.on_arrival(
        handle, lambda client_id, value: post(key, Asked(handle, client_id, value))
    )


on_press = on_value
"""A button's value is that it was pressed; a group's, which of its buttons."""


def on_upload(handle: Any, post: Post) -> None:
    """Post ("upload", client's number) with a file's name and content whenever one arrives."""

    async def arrived(event: Any) -> None:
        file = event.target.value
        post(("upload", event.client_id), (file.name, file.content))

    handle.on_upload(arrived)


def on_command(handle: Any, post: Post, key: Hashable, value: Any = True) -> None:
    """Post an `Asked` with `value` under `key` whenever a browser gives the command."""

    async def given(event: Any) -> None:
        if event.client_id is not None:
            post(key, Asked(handle, event.client_id, value))

    handle.on_trigger(given)

"""Undo, redo and start over: buttons, and commands of the keyboard."""

from typing import Any

from kneeviz.jobs.messages import Post
from kneeviz.views.tabs.events import on_press

UNDO, REDO, START_OVER = "Undo", "Redo", "Start over"


def add_change(gui: Any, post: Post, what: str) -> Any:
    """Build the three buttons; `what` says which changes they are about."""
    change = gui.add_button_group(
        "Change",
        (UNDO, REDO, START_OVER),
        hint=f"Every change of {what}: one step back, one step on "
        "(Ctrl+Z, Ctrl+Shift+Z), or all as at first.",
    )
    on_press(change, post, "change")
    return change

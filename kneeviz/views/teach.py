"""What the teacher of a class sees beside the page: who drives."""

from collections.abc import Sequence
from typing import Any

from kneeviz.jobs.messages import Post
from kneeviz.views.html.pieces import box
from kneeviz.views.tabs.events import on_value

TEACHER, ALL = "You alone", "Everybody"
WATCHING = "You are watching; the teacher drives"
"""Why something of a visitor's is not taken."""
_FIRST = -1.0
"""Above all that the page has."""


class TeachBox:
    """The switch on a teacher's own page."""

    def __init__(self, gui: Any, post: Post) -> None:
        self.driver = gui.add_dropdown(
            "Who drives",
            (TEACHER, ALL),
            order=_FIRST,
            hint="Watchers look around and read, but change nothing. Give one of them the wheel, "
            "or let all drive.",
        )
        self.here = gui.add_html("", order=_FIRST)
        on_value(self.driver, post, "driver")

    def show(self, driver: str, names: Sequence[str]) -> None:
        """Show who drives, and offer all who are here."""
        options = (TEACHER, ALL, *names)
        if self.driver.options != options:
            self.driver.options = options
        if self.driver.value != driver:
            self.driver.value = driver
        n = len(names)
        self.here.content = box("1 visitor is here." if n == 1 else f"{n} visitors are here.")


def role_of(name: str, *, drives: bool, all_drive: bool) -> str | None:
    """Return the line that tells a visitor what he may do; None where that is as usual."""
    if all_drive:
        return None
    return f"You have the wheel ({name})." if drives else f"{WATCHING} ({name})."

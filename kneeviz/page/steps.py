"""Undo and redo of any page: a step is noted, and gone back. Runs on the session's worker."""

import time
from collections.abc import Callable, Hashable
from typing import Any, Protocol, TypeVar

from kneeviz.jobs.messages import Asked, asked_by
from kneeviz.page.notices import Notices
from kneeviz.state.history import History, Moment
from kneeviz.views.html.pieces import escape
from kneeviz.views.tabs.change import REDO, START_OVER, UNDO

MomentT = TypeVar("MomentT", bound="Told")


class Told(Moment, Protocol):
    """A state that can say how it differs from another."""

    def changes_from(self, other: Any) -> tuple[str, ...]:
        """Return what differs, in words."""


class Stepped(Protocol[MomentT]):
    """A page whose states are kept."""

    history: History[MomentT]
    notices: Notices

    def snapshot(self) -> MomentT:
        """Return what a visitor may change and want back, as it is now."""

    def say(self, text: str, kind: str = "calm") -> None:
        """Write the status line."""


def noted(
    page: Stepped[MomentT], key: Hashable, value: Any, *, drag: Hashable | None = None
) -> bool:
    """Keep a page's state as a step, if what was done under `key` has changed it.

    `drag` is the hand's hold that `key` belongs to, from its start to its end, if it does.
    """
    return page.history.record(
        page.snapshot(),
        who=asked_by(value),
        what=_moved(key, value) if drag is None else drag,
        now=time.monotonic(),
        held=drag is not None,
    )


def _moved(key: Hashable, value: Any) -> Hashable | None:
    """Return `key` if it is of a slider or a number, which a hand moves on; None otherwise."""
    moves = isinstance(value, Asked) and type(value.value) in (int, float)
    return key if moves else None


def go(
    page: Stepped[MomentT],
    value: Asked | None,
    name: str,
    restore: Callable[[MomentT], None],
) -> bool:
    """Undo or redo, as `name` says; return whether there was anything left there."""
    wanted = page.history.undo() if name == "undo" else page.history.redo()
    if wanted is None:
        if value is not None:
            page.notices.tell(value.client_id, f"Nothing to {name}", "No change is left there.")
        return False
    changes = wanted.changes_from(page.snapshot())
    restore(wanted)
    page.history.amend(page.snapshot())
    page.say(f"{name.capitalize()}: {', '.join(changes)}.")
    return True


def actions(
    restore: Callable[[Any, Any], None],
    *,
    keep: Callable[[Any], None],
    stop_search: Callable[[Any], None],
    started_over: str,
) -> dict[str, Callable[..., None]]:
    """Return what the buttons and keys of undo, redo and start over do on one kind of page.

    Parameters
    ----------
    restore : callable
        Brings a page into a state.
    keep : callable
        Puts a page's present state into its file, if it has one.
    stop_search : callable
        Ends the search that runs for a page.
    started_over : str
        What is said then.
    """

    def undo(page: Any, value: Asked | None) -> None:
        if go(page, value, "undo", lambda wanted: restore(page, wanted)):
            keep(page)

    def redo(page: Any, value: Asked | None) -> None:
        if go(page, value, "redo", lambda wanted: restore(page, wanted)):
            keep(page)

    def start_over(page: Any, _value: Asked | None) -> None:
        """Go back to where the page began; a step like others, so that it can be undone."""
        page.history.rest()
        stop_search(page)
        restore(page, page.history.start)
        page.say(started_over)

    def not_kept(page: Any, why: str) -> None:
        page.say(f"The state is not kept: {escape(why)}", "bad")

    def change(page: Any, value: Asked) -> None:
        {UNDO: undo, REDO: redo, START_OVER: start_over}[value.value](page, value)

    return {
        "undo": undo,
        "redo": redo,
        "start_over": start_over,
        "change": change,
        "not_kept": not_kept,
    }

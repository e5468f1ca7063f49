"""Undo and redo of any page: a step is noted, and gone back. Runs on the session's worker."""

import time
from collections.abc import Callable, Hashable
from typing import Any, Protocol, TypeVar

from kneeviz.jobs.messages import Asked, asked_by
from kneeviz.page.notices import Notices
from kneeviz.state.history import History, Moment

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

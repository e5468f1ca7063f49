"""The states of a page one after the other, for undo and redo.

What is kept are whole states that nobody alters, not the changes between them: so undo gives the
same bytes back, whatever kind of change it was.
"""

from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any, Generic, Protocol, TypeVar

PAUSE = 0.8
"""s: a slider that rests for longer has been let go; what it does then is another step."""
DEEPEST = 200
"""Steps that are kept."""


class Moment(Protocol):
    """One state of a page, whatever it shows; never altered."""

    def same_as(self, other: Any) -> bool:
        """Tell whether both are the same, to the bit."""


MomentT = TypeVar("MomentT", bound=Moment)


@dataclass
class _Gesture:
    """What has made the present step, while it may go on."""

    last: float = -float("inf")
    parts: set[tuple[int | None, Hashable]] = field(default_factory=set)
    """Who, with what."""

    def goes_on(self, who: int | None, what: Hashable | None, now: float) -> bool:
        """Tell whether a change belongs to it: the same again, or that of another visitor."""
        if what is None or not self.parts or now - self.last > PAUSE:
            return False
        return (who, what) in self.parts or who not in {visitor for visitor, _ in self.parts}


class History(Generic[MomentT]):
    """Past, present and future of a page.

    Parameters
    ----------
    start : Moment
        Where the page began, and where *Start over* goes.
    """

    def __init__(self, start: MomentT) -> None:
        self.start = self.present = start
        self._past: list[MomentT] = []
        self._future: list[MomentT] = []
        self._gesture = _Gesture()

    def record(
        self,
        state: MomentT,
        *,
        who: int | None,
        what: Hashable | None,
        now: float,
        held: bool = False,
    ) -> bool:
        """Make `state` the present one; return whether it differs from the last.

        The changes of one drag are one step, and so are those of two visitors who drag at the
        same time.

        Parameters
        ----------
        state : Moment
        who : int or None
            The visitor's number.
        what : hashable or None
            The slider or number that is being moved; None for a change that is over at once.
        now : float
            s of `time.monotonic`.
        held : bool
            Whether the hand has not let go since, however long it rested.
        """
        if state.same_as(self.present):
            return False
        if not self._gesture.goes_on(who, what, self._gesture.last if held else now):
            self._past = [*self._past[1 - DEEPEST :], self.present]
            self._gesture = _Gesture()
        if what is not None:
            self._gesture.last = now
            self._gesture.parts.add((who, what))
        self.present = state
        self._future.clear()
        if state.same_as(self._past[-1]):  # back where the drag began
            self._past.pop()
            self.rest()
        return True

    @property
    def last(self) -> MomentT | None:
        """The state one step back; None at the beginning."""
        return self._past[-1] if self._past else None

    def amend(self, state: MomentT) -> bool:
        """Make `state` the present one without a step; return whether it differs."""
        differs = not state.same_as(self.present)
        self.present = state
        return differs

    def rest(self) -> None:
        """Let the next change be a step of its own."""
        self._gesture = _Gesture()

    def undo(self) -> MomentT | None:
        """Go a step back and return what is the present then; None at the beginning."""
        return self._go(self._past, self._future)

    def redo(self) -> MomentT | None:
        """Take an undo back; None if there is none."""
        return self._go(self._future, self._past)

    def _go(self, out_of: list[MomentT], into: list[MomentT]) -> MomentT | None:
        self.rest()
        if not out_of:
            return None
        into.append(self.present)
        self.present = out_of.pop()
        return self.present

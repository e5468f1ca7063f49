"""Places for visitors who each have something of their own, however they come and go.

A visitor may leave before he has come (his two callbacks run on threads of a pool) or while what is
made for him is still being made. So a place is taken under the lock before the work begins, and is
free again only once nothing is left of it.
"""

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class NoRoom(Exception):
    """All places are taken."""


class _Seat(Generic[T]):
    """A visitor's place; `made` is None while the work for him goes on."""

    def __init__(self) -> None:
        self.made: T | None = None
        self.left = False


class Seats(Generic[T]):
    """At most `limit` places.

    Parameters
    ----------
    limit : int
        How many there are.
    discard : callable
        Ends what was made for a visitor who has left. Called without the lock.
    """

    def __init__(self, limit: int, discard: Callable[[T], None]) -> None:
        self._limit, self._discard = limit, discard
        self._lock = threading.Lock()
        self._seats: dict[int, _Seat[T]] = {}
        self._turned_away: set[int] = set()
        self._left_before: set[int] = set()
        self._closed = False

    def __len__(self) -> int:
        """Return how many places are taken, also those of work that goes on."""
        with self._lock:
            return len(self._seats)

    @property
    def made(self) -> dict[int, T]:
        """What the visitors who are here have, by their number."""
        with self._lock:
            return {
                visitor: seat.made for visitor, seat in self._seats.items() if seat.made is not None
            }

    def join(self, visitor: int, make: Callable[[], T | None]) -> T | None:
        """Take a place and return what `make` makes for it; None if the visitor has left.

        `make` may return None itself if it finds nobody to work for.

        Raises
        ------
        NoRoom
            If all places are taken.
        Exception
            Whatever `make` raises; the place is free again.
        """
        seat: _Seat[T] = _Seat()
        with self._lock:
            if self._closed or visitor in self._left_before:
                self._left_before.discard(visitor)
                return None
            if len(self._seats) >= self._limit:
                self._turned_away.add(visitor)
                raise NoRoom
            self._seats[visitor] = seat
        made = None
        try:
            made = make()
        finally:
            stays = self._settle(visitor, seat, made)
        if stays:
            return made
        self._end(visitor, made)
        return None

    def _settle(self, visitor: int, seat: _Seat[T], made: T | None) -> bool:
        """Give a place what was made for it; return whether its visitor is still here."""
        with self._lock:
            if made is None:
                # Nothing to end; his leaving, if it is still to come, must not be remembered.
                self._seats.pop(visitor, None)
                if not seat.left:
                    self._turned_away.add(visitor)
                return False
            if not seat.left:
                seat.made = made
            return not seat.left

    def _end(self, visitor: int, made: T | None) -> None:
        """End what was made, and only then free the place."""
        try:
            if made is not None:
                self._discard(made)
        finally:
            with self._lock:
                self._seats.pop(visitor, None)

    def leave(self, visitor: int) -> None:
        """Free a visitor's place, at once or as soon as the work for him is done."""
        with self._lock:
            seat = self._seats.get(visitor)
            if seat is None:
                if visitor not in self._turned_away:
                    self._left_before.add(visitor)
                self._turned_away.discard(visitor)
                return
            seat.left = True
            made, seat.made = seat.made, None
        if made is not None:
            self._end(visitor, made)

    def close(self) -> None:
        """Let nobody in any more and end all that was made."""
        with self._lock:
            self._closed = True
            visitors = list(self._seats)
        for visitor in visitors:
            self.leave(visitor)

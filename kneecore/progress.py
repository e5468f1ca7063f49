"""What a long computation tells about itself, and how it is stopped."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, kw_only=True)
class Progress:
    """One report of a running search."""

    stage: str
    """`compile`, `sampling`, `fit`, `search`, `bound`, `verify`, or a few words
    for people."""
    done: int
    """Work done in this stage (generations over all runs in `search`, models in `repair`)."""
    total: int
    """Work of this stage."""
    best: float | None = None
    """Best objective so far in this run, in the outputs' unit (deg for the knee)."""
    run: int = 0
    """Number of the run, from 0."""
    n_models: int | None = None
    """Models that the search had evaluated when it knew `best`; None where it does not count."""
    seconds_left: float | None = None
    """What the runs that are left will take at most, by those measured; None where unknown."""
    so_far: Callable[[], Any] | None = None
    """Returns the best pair until now as the search's result, computed in the true model, with the
    `stop_reason` "cancelled"; to be called during the report. None where there is no pair yet, and
    of searches that cannot tell."""


class Clock:
    """Measures what a run takes."""

    def __init__(self) -> None:
        self._begun = time.perf_counter()

    def left(self, n_done: int, n_left: int) -> float | None:
        """Return what so many more runs will take, s; None before one is done."""
        if n_done <= 0:
            return None
        return (time.perf_counter() - self._begun) * n_left / n_done


Callback = Callable[[Progress], object]
"""Gets each report; a true result cancels."""


class Cancelled(Exception):
    """The callback asked to stop before the search had a first pair. No error."""

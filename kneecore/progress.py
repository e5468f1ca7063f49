"""What a long computation tells about itself, and how it is stopped."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, kw_only=True)
class Progress:
    """One report of a running search."""

    stage: str
    """`compile`, `sampling`, `fit`, `search`, `verify`, or a few words for people."""
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
    so_far: Callable[[], Any] | None = None
    """Returns the best pair until now as the search's result, computed in the true model, with the
    `stop_reason` "cancelled"; to be called during the report. None where there is no pair yet, and
    of searches that cannot tell."""


Callback = Callable[[Progress], object]
"""Gets each report; a true result cancels."""


class Cancelled(Exception):
    """The callback asked to stop before the search had a first pair. No error."""

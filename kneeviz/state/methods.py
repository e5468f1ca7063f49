"""The comparison of the search's methods: the one that runs, and the last one found."""

from dataclasses import dataclass
from typing import Any

from kneeviz.jobs.computations import Compared
from kneeviz.jobs.job import Job


@dataclass
class MethodsState:
    """The comparison that runs, and the last one found."""

    job: Job | None = None
    found: Compared | None = None
    written: tuple[Any, ...] = ()
    """What the text on screen was made of."""

"""The comparison of the search's methods: the one that runs, and the last one found."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from kneecore.search.compare import MethodTrace
from kneeviz.jobs.job import Job


@dataclass
class MethodsState:
    """The comparison that runs, and the last one found."""

    job: Job | None = None
    found: Mapping[str, MethodTrace] | None = None
    written: tuple[Any, ...] = ()
    """What the text on screen was made of."""

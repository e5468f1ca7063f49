"""The worst-case search that runs."""

from dataclasses import dataclass, field

from kneeviz.jobs.job import Job


@dataclass
class SearchState:
    """The search that runs, and how far it has come; what it finds goes to the `KneeState`."""

    job: Job | None = None
    rising: list[float] = field(default_factory=list)
    """The best objective at each report, deg."""

"""A worst-case search on a thread of its own, which reports and can be told to stop."""

import logging
import threading
import time
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any

import kneecore
from kneecore import KneecoreError, ParameterSpace
from kneecore._threads import available_cores
from kneecore.knee.model import Objective
from kneecore.knee.response import Solver
from kneecore.search.settings import Method, SearchSpace

_LOG = logging.getLogger(__name__)
_REPORT_SECONDS = 0.1

Post = Callable[[Hashable, Any], None]


@dataclass(frozen=True, kw_only=True)
class SearchSettings:
    """What to search, and how."""

    space: ParameterSpace
    rest_length: Any
    search_space: SearchSpace
    method: Method
    repair: bool
    """Whether a surrogate is repaired; a search in the true model has none."""
    solver: Solver
    objective: Objective
    pop_size: int
    n_generations: int
    seed: int


@dataclass(frozen=True, kw_only=True)
class SearchReport:
    """How far a search is."""

    percent: float
    best_deg: float | None
    stage: str


class SearchJob:
    """Posts "progress" while it runs and "search_done" with (job, result or None, why) at its end.

    Without a result, `why` says what went wrong; it is None after a cancellation.
    """

    def __init__(self, settings: SearchSettings, post: Post) -> None:
        self.settings = settings
        self._post = post
        self._cancelled = threading.Event()
        self._last_report = 0.0
        self._thread = threading.Thread(target=self._run, name="search", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def cancel(self) -> None:
        """Ask the search to stop; it does at its next report."""
        self._cancelled.set()

    def join(self, timeout: float) -> None:
        """Wait for the search's end."""
        if self._thread.is_alive():
            self._thread.join(timeout)

    def _watch(self, progress: Any) -> bool:
        now = time.monotonic()
        if now - self._last_report >= _REPORT_SECONDS:
            self._last_report = now
            share = progress.done / max(progress.total, 1) if progress.stage == "search" else 0.0
            report = SearchReport(
                percent=100.0 * min(share, 1.0), best_deg=progress.best, stage=progress.stage
            )
            self._post("progress", (self, report))
        return self._cancelled.is_set()

    def _run(self) -> None:
        result, why = None, None
        try:
            result = self._search()
        except KneecoreError as error:
            why = str(error)
        except Exception as error:
            if not self._cancelled.is_set():
                _LOG.exception("the search failed")
                why = f"{type(error).__name__}: {error}"
        if self._cancelled.is_set():
            result, why = None, None
        self._post("search_done", (self, result, why))

    def _search(self) -> Any:
        s = self.settings
        # The exact search has neither, and refuses them.
        genetic: dict[str, Any] = {}
        if s.method == "ga":
            genetic = {"pop_size": s.pop_size, "n_generations": s.n_generations}
        return kneecore.worst_case(
            s.space,
            method=s.method,
            repair=s.repair and s.search_space == "surrogate",
            search_space=s.search_space,
            training_samples=max(50, s.space.n_free + 2),
            **genetic,
            objective=s.objective,
            seed=s.seed,
            rest_length=s.rest_length,
            solver=s.solver,
            # One core stays free for the view.
            threads=max(1, available_cores() - 1),
            callback=self._watch,
        )

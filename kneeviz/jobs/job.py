"""A long computation on a thread of its own, which reports and can be told to stop."""

import logging
import threading
import time
from collections.abc import Callable
from typing import Any, NamedTuple

from kneecore import Cancelled, KneecoreError, Progress
from kneeviz.jobs.messages import Post

_LOG = logging.getLogger(__name__)
_REPORT_SECONDS = 0.1

Watch = Callable[[Progress], bool]
"""Takes kneecore's `Progress`, returns whether to stop."""


class JobProgress(NamedTuple):
    """How far a job is."""

    job: "Job"
    percent: float
    """Of its stage."""
    stage: str
    best: float | None = None
    """A search's best objective so far, deg."""
    seconds_left: float | None = None
    """What is left to wait for at most, where it is known."""


class JobDone(NamedTuple):
    """What a job ended with."""

    job: "Job"
    result: Any
    """None if it failed or was cancelled."""
    why: str | None
    """What went wrong; None after a cancellation."""


class Job:
    """Posts what it does, and its result.

    While it runs "KEY_progress" with a `JobProgress`, at its end "KEY_done" with a `JobDone`.

    Parameters
    ----------
    key : str
        What the messages' keys begin with: "search", "study" or "comparison".
    work : callable
        Does it, with a `Watch` to be called as often as may be.
    post : callable
        Takes the messages.
    kind : str
        What is computed, for whoever takes the result.
    keeps : bool
        Whether what a cancelled work returns is worth having.
    """

    def __init__(
        self,
        key: str,
        work: Callable[[Watch], Any],
        post: Post,
        *,
        kind: str = "",
        keeps: bool = False,
    ) -> None:
        self.kind, self._key, self._keeps = kind, key, keeps
        self._work, self._post = work, post
        self._cancelled = threading.Event()
        self._last_report = 0.0
        self._thread = threading.Thread(target=self._run, name=key, daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def cancel(self) -> None:
        """Ask the work to stop; it does at its next report."""
        self._cancelled.set()

    def _watch(self, progress: Progress) -> bool:
        now = time.monotonic()
        if now - self._last_report >= _REPORT_SECONDS:
            self._last_report = now
            percent = 100.0 * min(progress.done / max(progress.total, 1), 1.0)
            left = progress.seconds_left
            report = JobProgress(self, percent, progress.stage, progress.best, left)
            self._post(f"{self._key}_progress", report)
        return self._cancelled.is_set()

    def _run(self) -> None:
        result, why = None, None
        try:
            result = self._work(self._watch)
        except Cancelled:
            self._cancelled.set()
        except KneecoreError as error:
            why = str(error)
        except Exception as error:
            _LOG.exception("the %s failed", self._key)
            why = f"{type(error).__name__}: {error}"
        if self._cancelled.is_set():
            result, why = result if self._keeps else None, None
        self._post(f"{self._key}_done", JobDone(self, result, why))

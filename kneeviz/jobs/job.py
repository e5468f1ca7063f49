"""A long computation of the study on a thread of its own, which reports and can be told to stop."""

import logging
import threading
import time
from collections.abc import Callable, Hashable
from typing import Any

from kneecore import Cancelled, KneecoreError

_LOG = logging.getLogger(__name__)
_REPORT_SECONDS = 0.1

Post = Callable[[Hashable, Any], None]
Watch = Callable[[Any], bool]
"""Takes kneecore's `Progress`, returns whether to stop."""


class StudyJob:
    """Posts what it does, and its result.

    While it runs "KEY_progress" with (job, per cent, stage), at its end "KEY_done" with (job,
    result or None, why).

    Without a result, `why` says what went wrong; it is None after a cancellation.

    Parameters
    ----------
    kind : str
        What is computed, for whoever takes the result.
    work : callable
        Does it, with a `Watch` to be called as often as may be.
    post : callable
        Takes the messages.
    key : str
        What their keys begin with.
    """

    def __init__(
        self, kind: str, work: Callable[[Watch], Any], post: Post, key: str = "study"
    ) -> None:
        self.kind, self._key = kind, key
        self._work, self._post = work, post
        self._cancelled = threading.Event()
        self._last_report = 0.0
        self._thread = threading.Thread(target=self._run, name="study", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def cancel(self) -> None:
        """Ask the work to stop; it does at its next report."""
        self._cancelled.set()

    def _watch(self, progress: Any) -> bool:
        now = time.monotonic()
        if now - self._last_report >= _REPORT_SECONDS:
            self._last_report = now
            share = progress.done / max(progress.total, 1)
            self._post(f"{self._key}_progress", (self, 100.0 * min(share, 1.0), progress.stage))
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
            _LOG.exception("the study failed")
            why = f"{type(error).__name__}: {error}"
        if self._cancelled.is_set():
            result, why = None, None
        self._post(f"{self._key}_done", (self, result, why))

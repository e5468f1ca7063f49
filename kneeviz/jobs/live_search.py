"""A thread that answers the latest of what a moving slider asks."""

import logging
import threading
import time
from typing import NamedTuple

from kneecore import Cancelled, KneecoreError
from kneeviz.jobs.live_worst_case import LiveAnswer, LiveRequest, find
from kneeviz.jobs.messages import Post
from kneeviz.jobs.worker import Actions, Worker

_LOG = logging.getLogger(__name__)

PATIENCE = 0.25
"""s that a search may go on after a later request: quick ones end, so that a slider in motion has
answers; slow ones give way to what the visitor wants now, at once if they have told a first one."""


class LiveFound(NamedTuple):
    """What the live search came to."""

    request: LiveRequest | None
    """The request; None if nothing is wanted any more."""
    answer: LiveAnswer | None
    why: str | None
    """What went wrong, if there is no answer."""


class LiveSearch:
    """Posts "live_found" with a `LiveFound` for the latest request.

    A search that takes long posts its best pair until then, again and again, and then its end. One
    that is cancelled posts nothing more: a later one is on its way.
    """

    def __init__(self, post: Post) -> None:
        self._post = post
        self._wanted: LiveRequest | None = None
        self._worker = Worker(self._step, self._failed, name="live")
        self._started = False

    def ask(self, request: LiveRequest) -> None:
        """Ask for a worst case; a request that still waits is replaced."""
        self._wanted = request
        if not self._started:
            self._started = True
            self._worker.start()
        self._worker.mailbox.post("find", request)

    def is_latest(self, request: LiveRequest | None) -> bool:
        """Tell whether nothing was asked after `request`."""
        return request is self._wanted

    def forget(self) -> None:
        """Want nothing any more; a search that takes long is cancelled."""
        self._wanted = None

    def stop(self) -> None:
        """End the thread."""
        self._worker.stop()

    def _step(self, actions: Actions) -> None:
        request: LiveRequest = actions[-1][1]
        if request is not self._wanted:
            return
        begun, told = time.monotonic(), threading.Event()

        def superseded() -> bool:
            if self._worker.mailbox.closed:
                return True
            gives_way = told.is_set() or time.monotonic() - begun > PATIENCE
            return self._wanted is not request and gives_way

        def tell(best: LiveAnswer) -> None:
            told.set()
            if self._wanted is not None:
                self._post("live_found", LiveFound(request, best, None))

        answer, why = None, None
        try:
            answer = find(request, superseded, tell)
        except Cancelled:
            return
        except KneecoreError as error:
            why = str(error)
        self._post("live_found", LiveFound(request, answer, why))

    def _failed(self, error: Exception) -> None:
        _LOG.error("the live search failed: %s", error)
        why = f"{type(error).__name__}: {error}"
        self._post("live_found", LiveFound(self._wanted, None, why))

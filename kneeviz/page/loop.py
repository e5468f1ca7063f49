"""What the loops of all kinds of pages share: the worker, the mailbox, and how a fault is told."""

import logging
from abc import ABC, abstractmethod
from collections.abc import Hashable
from typing import Any, Generic, Protocol, TypeVar

from kneeviz.jobs.messages import asked_by
from kneeviz.jobs.worker import Actions, Worker
from kneeviz.page.notices import Notices
from kneeviz.views.html.pieces import escape

_LOG = logging.getLogger(__name__)


class Looped(Protocol):
    """A page as its loop sees it."""

    target: Any
    notices: Notices

    def say(self, text: str, kind: str = "calm") -> None:
        """Write the status line."""

    def stop(self) -> None:
        """Cancel what runs."""


PageT = TypeVar("PageT", bound=Looped)


class Loop(ABC, Generic[PageT]):
    """A page and the worker that keeps it going. Whoever derives from it makes the `page`."""

    page: PageT

    def __init__(self) -> None:
        self._worker = Worker(self._step, self._failed)

    def stop(self) -> None:
        """End the worker and whatever runs for the page."""
        self.page.stop()
        self._worker.stop()

    def post(self, key: Hashable, value: Any = None) -> None:
        """Ask the worker for something; returns at once."""
        self._worker.mailbox.post(key, value)

    def reject(self, client_id: int, handle: Any, fault: str, sent: Any) -> None:
        """Note that a client's message was turned away; it is told once it stops."""
        self.post(("reject", client_id), (client_id, handle, fault, sent))

    @abstractmethod
    def start(self) -> None:
        """Start the worker."""

    @abstractmethod
    def open_as_left(self, left: Any) -> None:
        """Open the page in a state in which it was left, before `start`."""

    @abstractmethod
    def told(self, state: Any) -> str:
        """Return a state of the page as the text of a file."""

    # The worker's thread from here on.

    @abstractmethod
    def _step(self, actions: Actions) -> float | None:
        """Do what was asked; return when to step again, s of `time.monotonic`."""

    @abstractmethod
    def _act(self, key: Hashable, value: Any) -> None:
        """Do one thing."""

    def _perform(self, key: Hashable, value: Any) -> None:
        """Do one thing; if it fails, the rest goes on and whoever asked is told."""
        try:
            self._act(key, value)
        except Exception as error:
            _LOG.exception("%s failed", key)
            self._say_failed(error)
            client_id = asked_by(value)
            if client_id is not None:
                self.page.notices.tell(client_id, "That did not work", str(error)[:300])

    def _failed(self, error: Exception) -> None:
        self._say_failed(error)
        self.page.target.flush()

    def _say_failed(self, error: Exception) -> None:
        self.page.say(f"That did not work: {escape(str(error))}", "bad")

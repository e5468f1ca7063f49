"""One thread that does all the work of a view, always with the latest of what was asked.

Callbacks post a key and a value and return. A later post with the same key replaces the earlier
one, so a slider that moves faster than the model answers costs nothing but the answers in between.
"""

import logging
import threading
import time
from collections.abc import Callable, Hashable
from typing import Any

_LOG = logging.getLogger(__name__)

Actions = list[tuple[Hashable, Any]]


class Mailbox:
    """What was asked and not done yet. Any thread may post; one thread takes."""

    def __init__(self) -> None:
        self._asked: dict[Hashable, Any] = {}
        self._ready = threading.Condition()
        self._closed = False

    def post(self, key: Hashable, value: Any = None) -> None:
        """Ask for `key`; a request of the same key that still waits is replaced."""
        with self._ready:
            self._asked.pop(key, None)  # the latest request also goes last
            self._asked[key] = value
            self._ready.notify()

    def take(self, timeout: float | None) -> Actions | None:
        """Return all that was asked, in order, after waiting up to `timeout` (s).

        An empty list means that the time is up, None that the mailbox is closed.
        """
        with self._ready:
            if not self._asked and not self._closed:
                self._ready.wait(timeout)
            if self._closed:
                return None
            actions = list(self._asked.items())
            self._asked.clear()
            return actions

    @property
    def closed(self) -> bool:
        """Whether the mailbox has been closed."""
        return self._closed

    def close(self) -> None:
        """End the taking thread; later posts are dropped."""
        with self._ready:
            self._closed = True
            self._ready.notify_all()


class Worker:
    """Calls `step` with what was asked, and again when the time that it returned is due.

    Parameters
    ----------
    step : callable
        Gets the actions (none when only the time was due) and returns when it wants to be called
        next, in s of `time.monotonic`, or None to wait for a request.
    on_error : callable
        Gets an exception that `step` let through; the thread goes on.
    """

    def __init__(
        self,
        step: Callable[[Actions], float | None],
        on_error: Callable[[Exception], None],
        name: str = "view",
    ) -> None:
        self.mailbox = Mailbox()
        self._step, self._on_error = step, on_error
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self, timeout: float = 2.0) -> None:
        """End the thread and wait for it, unless it is the calling one."""
        self.mailbox.close()
        if self._thread.is_alive() and threading.current_thread() is not self._thread:
            self._thread.join(timeout)

    def _run(self) -> None:
        due: float | None = None
        while True:
            wait = None if due is None else max(due - time.monotonic(), 0.0)
            actions = self.mailbox.take(wait)
            if actions is None:
                return
            try:
                due = self._step(actions)
            except Exception as error:
                due = None
                self._report(error)

    def _report(self, error: Exception) -> None:
        if self.mailbox.closed:
            return  # the visitor has left, and his handles with him
        _LOG.exception("a step of the view failed", exc_info=error)
        try:
            self._on_error(error)
        except Exception:
            _LOG.exception("and it could not be told")

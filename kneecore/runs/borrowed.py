"""Executors of somebody else's, and what they are asked to do."""

import os
import threading
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import lazy_loader
import numpy as np
from numpy.typing import NDArray

from kneecore._threads import available_cores
from kneecore.runs.chunks import TARGET_S
from kneecore.runs.hands import Hand
from kneecore.runs.jobs import Job, Sent, sent
from kneecore.runs.part import Part, join
from kneecore.runs.work import loaded

__all__ = ["Borrowed", "run_sent"]

FloatArray = NDArray[np.float64]
threadpoolctl: Any = lazy_loader.load("threadpoolctl")

_LIMITS: list[Any] = []
_MINE = threading.local()


def run_sent(
    job: Sent, x: FloatArray, observe: bool, timeout_s: float | None, retries: int, apart: bool
) -> Part:
    """Run a work that has come from another process; it is what executors are asked to do.

    With `apart`, or where a run may take no longer than `timeout_s`, it is done by a process of its
    own: that one can be ended, and whoever works here outlives it.
    """
    if apart or timeout_s is not None:
        hand: Hand | None = getattr(_MINE, "hand", None)
        if hand is None or (hand.timeout_s, hand.retries) != (timeout_s, retries):
            if hand is not None:
                hand.close()
            hand = _MINE.hand = Hand(timeout_s, retries)
        return hand.run(job, x, observe)
    if os.getpid() != job.origin and not _LIMITS:  # one of several workers on its machine
        _LIMITS.append(threadpoolctl.threadpool_limits(1))
    work = loaded(job.digest, job.blob)
    return join(list(work.parts(x, observe=observe, patience=float("inf"))))


def _star(given: tuple[Any, ...]) -> Part:
    return run_sent(*given)


class Borrowed:
    """An executor of somebody else's: of concurrent.futures, loky, Dask, MPI."""

    target_s = TARGET_S

    def __init__(self, executor: Any, timeout_s: float | None, retries: int) -> None:
        self._executor, self._options = executor, (timeout_s, retries)
        # There is no public way to ask; the usual executors call it so.
        known = getattr(executor, "_max_workers", None)
        self.n_workers: int = known if isinstance(known, int) else available_cores()
        self._mapper: ThreadPoolExecutor | None = None
        if not callable(getattr(executor, "submit", None)):
            self._mapper = ThreadPoolExecutor(1, thread_name_prefix="kneecore-map")
            self._waiting: list[tuple[Future[Part], tuple[Any, ...]]] = []
            self._lock = threading.Lock()

    def submit(self, job: Job, x: FloatArray, observe: bool) -> "Future[Part]":
        """Hand points over."""
        given = (sent(job), x, observe, *self._options, False)
        if self._mapper is None:
            future: Future[Part] = self._executor.submit(run_sent, *given)
            return future
        future = Future()
        with self._lock:
            self._waiting.append((future, given))
        self._mapper.submit(self._map_all)
        return future

    def _map_all(self) -> None:
        """Map over all that waits: one that only maps does what came meanwhile at once."""
        with self._lock:
            waiting, self._waiting = self._waiting, []
        waiting = [(f, given) for f, given in waiting if f.set_running_or_notify_cancel()]
        try:
            for (future, _), part in zip(
                waiting, self._executor.map(_star, [given for _, given in waiting]), strict=True
            ):
                future.set_result(part)
        except BaseException as error:
            for future, _ in waiting:
                if not future.done():
                    future.set_exception(error)

    def check(self) -> None:
        """Do nothing: an executor tells by its futures."""

    def abandon(self) -> None:
        """Do nothing: what has begun cannot be ended."""

    def close(self) -> None:
        """Leave it open: it is not ours."""
        if self._mapper is not None:
            self._mapper.shutdown(wait=False, cancel_futures=True)

"""Worker processes of our own, for a hung or a crashed run takes no more than itself away.

Executors of processes break when one of theirs dies, do not say in which run, and cannot end a run
that hangs; those that can are under licences that bind whoever ships them. So each worker here is a
thread with one process (`kneecore.runs.child`) of its own, which is replaced when it has to be.
"""

import atexit
import os
import signal
import subprocess
import sys
import threading
import time
import weakref
from collections.abc import Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ModelError
from kneecore.runs.child import read_message, write_message
from kneecore.runs.chunks import TARGET_S
from kneecore.runs.jobs import Job, Sent, sent
from kneecore.runs.part import Part, Trouble, failed_part, join, with_count
from kneecore.runs.processes import end, started

__all__ = ["Hand", "Hands"]

FloatArray = NDArray[np.float64]
PATIENCE = 0.02
"""Seconds of runs that a worker keeps to itself before it tells of them."""
_ONE_THREAD = dict.fromkeys(
    (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "VECLIB_MAXIMUM_THREADS",
        "NUMBA_NUM_THREADS",
    ),
    "1",
)
_CODE = "import sys; sys.path[:] = {path!r}; from kneecore.runs.child import main; main()"


class _Ended(Exception):
    """The process is gone; kind and message as a failure has them."""


class _Child:
    """One process that runs models."""

    def __init__(self) -> None:
        self._process = started(
            [sys.executable, "-c", _CODE.format(path=sys.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=os.environ | _ONE_THREAD,
        )
        self._loaded: set[str] = set()
        self._too_late = self._heard = self._stopped = False

    def load(self, job: Sent) -> None:
        """Let it load a work; raises a `ModelError` if it cannot."""
        if job.digest in self._loaded:
            return
        try:
            self._say(("load", job.digest, job.blob))
            answer, said = read_message(self._process.stdout)  # type: ignore[arg-type]
        except (OSError, EOFError):
            told = self.stop()
            raise ModelError(f"a worker process ended while it loaded the model ({told})") from None
        if answer == "refused":
            raise ModelError(
                f"a worker process cannot load the model ({said}); what it imports must be "
                "importable there"
            )
        self._loaded.add(job.digest)

    def _say(self, message: Any) -> None:
        assert self._process.stdin is not None
        write_message(self._process.stdin, message)  # type: ignore[arg-type]

    def parts(
        self, job: Sent, x: FloatArray, observe: bool, patience: float, timeout_s: float | None
    ) -> Iterator[Part]:
        """Yield what it says of points; raises `_Ended` if it is gone, or was too slow."""
        left = len(x)
        self._heard = True
        try:
            self._say((job.digest, job.digest, x, observe, patience))
            while left:
                part = self._answer(timeout_s)
                left -= len(part)
                yield part
        except (OSError, EOFError):
            told = self.stop()
            if self._too_late:
                raise _Ended("timed out", f"took longer than {timeout_s:g} s") from None
            raise _Ended("died", f"ended its process ({told})") from None
        finally:
            self._heard = False
            self._close_ear()

    def _close_ear(self) -> None:
        """Close the pipe, when the process is gone and nobody waits for its words."""
        if self._stopped and not self._heard:
            with suppress(OSError):
                self._process.stdout.close()  # type: ignore[union-attr]

    def _answer(self, timeout_s: float | None) -> Part:
        timer = None if timeout_s is None else threading.Timer(timeout_s, self._late)
        if timer is not None:
            timer.daemon = True
            timer.start()
        try:
            _, part = read_message(self._process.stdout)  # type: ignore[arg-type]
        finally:
            if timer is not None:
                timer.cancel()
        found: Part = part
        return found

    def _late(self) -> None:
        self._too_late = True
        self.stop()

    def stop(self) -> str:
        """End the process and all that it has started; return how it ended."""
        # Its own ear hears the pipe close, and ends what runs in groups of their own as well.
        with suppress(OSError):
            self._process.stdin.close()  # type: ignore[union-attr]
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(0.5)
        code = self._process.returncode
        end(self._process)
        self._stopped = True
        self._close_ear()
        if code is None:
            return "it was ended"
        if code < 0:
            return f"signal {signal.Signals(-code).name}"
        return f"exit code {code}"


_OPEN: "weakref.WeakSet[Hand]" = weakref.WeakSet()


@atexit.register
def _close_all() -> None:
    for hand in list(_OPEN):
        hand.close()


class Hand:
    """One worker: it has a process, and a new one when that is gone."""

    def __init__(self, timeout_s: float | None, retries: int) -> None:
        self.timeout_s, self.retries = timeout_s, retries
        self._process: _Child | None = None
        self.closed = False
        _OPEN.add(self)

    def __del__(self) -> None:
        self.close()

    def run(self, job: Sent, x: FloatArray, observe: bool) -> Part:
        """Return what becomes of points, the runs that hang or crash marked as failed."""
        parts: list[Part] = []
        done = tries = unknown = 0
        exact, alone = self.timeout_s is not None, False
        while done < len(x):
            last = done + 1 if alone else len(x)
            patience = 0.0 if exact else PATIENCE
            began = time.perf_counter()
            try:
                child = self._ready(job)
                for part in child.parts(job, x[done:last], observe, patience, self.timeout_s):
                    parts.append(part if not tries else with_count(part, "retried"))
                    done += len(part)
                    tries, began = 0, time.perf_counter()
            except _Ended as gone:
                self._process = None
                if self.closed:
                    raise CancelledError from None
                if last - done > 1 and not (exact and job.by_row):
                    # Which of them it was, nobody has said: once more, so that it will be known.
                    exact, alone = True, not job.by_row
                    unknown = 1
                    continue
                tries += 1
                if tries > self.retries:
                    parts.append(self._failed(job, gone, time.perf_counter() - began, tries))
                    done, tries, unknown = done + 1, 0, 0
        if unknown:  # it has done it again without harm
            parts[-1] = with_count(parts[-1], "retried")
        return join(parts)

    def _failed(self, job: Sent, gone: _Ended, seconds: float, tries: int) -> Part:
        kind, message = gone.args
        trouble = Trouble(row=0, kind=kind, message=message, seconds=seconds, tries=tries)
        return failed_part(job.n_outputs, trouble)

    def _ready(self, job: Sent) -> _Child:
        if self.closed:
            raise CancelledError
        if self._process is None:
            self._process = _Child()
        self._process.load(job)
        return self._process

    def close(self) -> None:
        """End the process, also in the midst of a run."""
        self.closed = True
        if self._process is not None:
            self._process.stop()


class Hands:
    """Several workers on this machine, each with one process."""

    target_s = TARGET_S

    def __init__(self, n_workers: int, timeout_s: float | None, retries: int) -> None:
        self.n_workers = n_workers
        self._options = (timeout_s, retries)
        self._hands: list[Hand] = []
        self._mine = threading.local()
        self._pool = ThreadPoolExecutor(n_workers, thread_name_prefix="kneecore-run")

    def submit(self, job: Job, x: FloatArray, observe: bool) -> "Future[Part]":
        """Give points to a worker that has nothing to do."""
        return self._pool.submit(self._run, sent(job), x, observe)

    def _run(self, job: Sent, x: FloatArray, observe: bool) -> Part:
        hand: Hand | None = getattr(self._mine, "hand", None)
        if hand is None or hand.closed:
            hand = self._mine.hand = Hand(*self._options)
            self._hands.append(hand)
        return hand.run(job, x, observe)

    def check(self) -> None:
        """Nothing can be wrong with them that a run does not tell."""

    def abandon(self) -> None:
        """End all that is being done, at once; what is given afterwards is done again."""
        hands, self._hands = self._hands, []
        for hand in hands:
            hand.close()

    def close(self) -> None:
        """End all workers."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        self.abandon()

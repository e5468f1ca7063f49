"""Who does the runs: this thread, or threads; others are in modules that are loaded late."""

from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ModelError
from kneecore.runs.chunks import TARGET_S
from kneecore.runs.jobs import Job
from kneecore.runs.part import Part, join

__all__ = ["Here", "Pool", "Threads", "broken"]

FloatArray = NDArray[np.float64]


class Pool(Protocol):
    """Those who do the runs."""

    n_workers: int
    target_s: float
    """How long a chunk should take."""

    def submit(self, job: Job, x: FloatArray, observe: bool) -> "Future[Part]":
        """Give points (n, d) to one of them."""

    def check(self) -> None:
        """Raise a `ModelError` if nothing more will come from them; called now and then."""

    def abandon(self) -> None:
        """End what is being done."""

    def close(self) -> None:
        """Let them go."""


def _whole(job: Job, x: FloatArray, observe: bool) -> Part:
    return join(list(job.work.parts(x, observe=observe, patience=float("inf"))))


class Here:
    """The thread that asks."""

    n_workers = 1
    target_s = TARGET_S

    def submit(self, job: Job, x: FloatArray, observe: bool) -> "Future[Part]":
        """Do it at once."""
        future: Future[Part] = Future()
        future.set_result(_whole(job, x, observe))
        return future

    def check(self) -> None:
        """Nothing can be wrong."""

    def abandon(self) -> None:
        """Nothing is being done."""

    def close(self) -> None:
        """Nobody is there."""


class Threads:
    """Threads of this process: enough where each run is a process of its own."""

    target_s = TARGET_S

    def __init__(self, n_workers: int, stop: Callable[[], object]) -> None:
        self.n_workers, self._stop = n_workers, stop
        self._pool = ThreadPoolExecutor(n_workers, thread_name_prefix="kneecore-run")

    def submit(self, job: Job, x: FloatArray, observe: bool) -> "Future[Part]":
        """Give points to a thread that has nothing to do."""
        return self._pool.submit(_whole, job, x, observe)

    def check(self) -> None:
        """Nothing can be wrong."""

    def abandon(self) -> None:
        """End the programs."""
        self._stop()

    def close(self) -> None:
        """Let the threads end."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        self._stop()


def broken(error: BaseException) -> ModelError:
    """Return what an executor's own error means, in one line."""
    said = " ".join(f"{type(error).__name__}: {error}".split())[:300]
    if isinstance(error, BrokenExecutor):
        return ModelError(
            f"the executor is broken: a run has ended its process ({said}); with a number as "
            "`workers` such a run is marked and the others go on"
        )
    return ModelError(f"the executor cannot run the model ({said})")

"""Runs a work for points: by whom was chosen, keeping what was done, and counting what failed.

Examples
--------
>>> import numpy as np
>>> from kneecore.runs.engine import Engine
>>> from kneecore.runs.options import RunOptions
>>> from kneecore.runs.work import RowWork
>>> engine = Engine(RunOptions(), digest="of the model")
>>> work = RowWork(lambda x: 1.0 / x if x[0] else [np.nan], n_outputs=1)
>>> [done] = engine.stream(work, [np.array([[2.0], [0.0], [4.0]])])
>>> done.y.ravel()
array([0.5 ,  nan, 0.25])
>>> engine.failures[0].number, engine.failures[0].message
(2, 'returned NaN or infinity for 1 of 1 outputs')
"""

import threading
import weakref
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ModelError, ParameterError
from kneecore.runs.borrowed import Borrowed
from kneecore.runs.chunks import Cutter, Pace
from kneecore.runs.cluster import Cluster
from kneecore.runs.evaluation import Evaluation, Watch
from kneecore.runs.flow import Flow
from kneecore.runs.hands import Hands
from kneecore.runs.jobs import Job
from kneecore.runs.log import RunLog
from kneecore.runs.options import RunOptions
from kneecore.runs.part import Failure, Part, Trouble
from kneecore.runs.pool import Here, Pool, Threads
from kneecore.runs.work import Work

__all__ = ["MOST_FAILURES", "Engine"]

FloatArray = NDArray[np.float64]
MOST_FAILURES = 1000
"""Failures that are told one by one; the counts have all of them."""
HOPELESS = 3
"""First runs that all fail: then it is the model that cannot be run, and not some of its points."""


def _let_go(owned: list[Any]) -> None:
    for one in owned:
        one.close()
    owned.clear()


class Engine:
    """What a model's runs go through.

    Parameters
    ----------
    options : RunOptions
    digest : str
        What the model's runs are called in the file of runs.
    stop : callable, optional
        Ends the external programs of the model, if that is what its runs are: then threads start
        them, and no Python process stands in between.
    """

    def __init__(
        self, options: RunOptions, *, digest: str, stop: Callable[[], object] | None = None
    ) -> None:
        self.options, self._digest, self._stop = options, digest, stop
        self.failures: list[Failure] = []
        self.n_runs = 0
        self._n_good = self._n_judged = 0
        self._forget()

    def _forget(self) -> None:
        self._owned: list[Any] = []
        self._pool: Pool | None = None
        self._log: RunLog | None = None
        self._job: Job | None = None
        self._lock = threading.Lock()
        weakref.finalize(self, _let_go, self._owned)

    def __getstate__(self) -> dict[str, Any]:
        """Leave processes, files and locks behind."""
        left = ("_owned", "_pool", "_log", "_job", "_lock")
        return {k: v for k, v in vars(self).items() if k not in left}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._forget()

    def close(self) -> None:
        """End the workers, and let go of the file of runs; a later run begins anew."""
        with self._lock:
            _let_go(self._owned)
            self._pool = self._log = None

    def _dismiss(self) -> None:
        with self._lock:
            pool, self._pool = self._pool, None
            if pool is not None:
                self._owned.remove(pool)
                pool.close()

    def open(self) -> RunLog | None:
        """Return the file of runs, read; None where none are kept.

        Raises
        ------
        FileFormatError, OutputError
            If it is no such file, or cannot be written.
        """
        options = self.options
        if options.keep is None:
            return None
        with self._lock:
            if self._log is None:
                self._log = RunLog(
                    options.keep, self._digest, rerun_failures=options.rerun_failures
                )
                self._owned.append(self._log)
            return self._log

    def _workers(self) -> Pool:
        with self._lock:
            if self._pool is None:
                self._pool = self._hired()
                self._owned.append(self._pool)
            return self._pool

    def _hired(self) -> Pool:
        workers, timeout, retries = (
            self.options.workers,
            self.options.timeout_s,
            self.options.retries,
        )
        if self._stop is not None:
            timeout = None  # the programs have it
        if workers is None and timeout is None:
            return Here()
        if workers is None or isinstance(workers, int | np.integer):
            if self._stop is not None:
                return Threads(int(workers or 1), self._stop)
            return Hands(int(workers or 1), timeout, retries)
        if isinstance(workers, str):
            return Cluster(workers, timeout, retries)
        return Borrowed(workers, timeout, retries)

    def stream(
        self,
        work: Work,
        batches: Iterable[FloatArray],
        *,
        observe: bool = False,
        watch: Watch | None = None,
    ) -> Iterator[Evaluation]:
        """Yield what becomes of batches of points, in order.

        A stream that is cancelled by `watch` ends early, the last batch cut to what was done.

        Raises
        ------
        ParameterError
            If what the first run returns is no outputs, or the model cannot be sent to others.
        ModelError
            If none of the first runs succeeds, a failed run is to end everything, or nothing more
            will come from those who run it.
        """
        log = self.open() if work.keeps else None
        pool = self._workers()
        if self._job is None or self._job.work is not work:
            self._job = Job(work)
        pace = Pace(by_row=work.by_row, target_s=pool.target_s)
        whole = isinstance(pool, Here) and not work.by_row
        cutter = Cutter(batches, None if whole else pace)
        flow = Flow(
            pool, self._job, cutter, pace, log=log, observe=observe, retries=self.options.retries
        )
        first = self.n_runs
        try:
            yield from self._through(flow, first, log, watch)
        except BaseException as error:
            flow.abandon()
            if isinstance(error, ModelError):  # those who run may be of no use any more
                self._dismiss()
            raise
        finally:
            self.n_runs = first + cutter.n_rows

    def _through(
        self, flow: Flow, first: int, log: RunLog | None, watch: Watch | None
    ) -> Iterator[Evaluation]:
        while True:
            going = flow.launch()
            flow.land()
            for start, x, part in flow.in_order():
                self._judge(first + start, x, part, log)
            for done in flow.batches():
                yield self._told(done, log)
            if not going:
                return
            if watch is not None and watch(flow.n_done):
                flow.abandon()
                rest = flow.rest()
                if rest is not None:
                    yield self._told(rest, log)
                return

    @staticmethod
    def _told(done: Evaluation, log: RunLog | None) -> Evaluation:
        if log is None or "reused" in done.counts:
            return done
        return Evaluation(y=done.y, counts={**done.counts, "reused": 0}, observed=done.observed)

    def _judge(self, before: int, x: FloatArray, part: Part, log: RunLog | None) -> None:
        """Take note of what failed, and raise where that is the end."""
        for k, trouble in enumerate(part.troubles):
            number = before + trouble.row + 1
            failure = self._failure(number, x[trouble.row], trouble, log)
            good = self._n_good + trouble.row - k
            self._refuse(failure, trouble.error, n_before=self._n_judged + trouble.row, n_good=good)
        self._n_judged += len(part)
        self._n_good += len(part) - len(part.troubles)

    def _failure(self, number: int, x: FloatArray, trouble: Trouble, log: RunLog | None) -> Failure:
        files = trouble.files
        known = len(self.failures) < MOST_FAILURES
        if log is not None and known and files is None and trouble.traceback:
            files = log.write_traceback(number, trouble.traceback)
        failure = Failure(
            number=number, x=x.copy(), kind=trouble.kind, message=trouble.message,
            traceback=trouble.traceback, files=files, seconds=trouble.seconds, tries=trouble.tries,
        )  # fmt: skip
        if known:
            self.failures.append(failure)
        return failure

    def _refuse(
        self, failure: Failure, error: BaseException | None, *, n_before: int, n_good: int
    ) -> None:
        if n_good == 0 and failure.kind == "returned":
            raise error if isinstance(error, ParameterError) else ParameterError(failure.message)
        hopeless = n_good == 0 and n_before == HOPELESS - 1 and failure.kind != "nan"
        if not hopeless and self.options.on_failure != "abort":
            return
        many = f"; all of the first {HOPELESS} runs failed" if hopeless else ""
        raise ModelError(f"{failure}{many}") from error

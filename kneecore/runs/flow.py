"""One stream of points on its way through the workers, and back in order."""

import queue
from collections import deque
from collections.abc import Iterator
from concurrent.futures import CancelledError, Future
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import KneecoreError
from kneecore.runs.chunks import Cutter, Pace
from kneecore.runs.evaluation import Evaluation
from kneecore.runs.jobs import Job
from kneecore.runs.log import RunLog
from kneecore.runs.part import Part, Trouble, failed_part, join
from kneecore.runs.pool import Here, Pool, broken

__all__ = ["Flow"]

FloatArray = NDArray[np.float64]
_TICK_S = 0.1


@dataclass(eq=False)
class _Chunk:
    start: int
    x: FloatArray
    known: dict[int, Part] = field(default_factory=dict)
    """Rows that were done in an earlier study."""
    n_lost: int = 0
    """How often the worker was lost that had it."""

    @property
    def open(self) -> list[int]:
        """Rows that are to be run."""
        return [row for row in range(len(self.x)) if row not in self.known]


def _kept_part(y: FloatArray, trouble: Trouble | None) -> Part:
    counts = {"failed": int(trouble is not None), "reused": 1}
    troubles = () if trouble is None else (trouble,)
    return Part(done=Evaluation(y=y[None].copy(), counts=counts), troubles=troubles)


def _rows(part: Part) -> list[Part]:
    """Return a part as one part a row."""
    troubles = {t.row: t for t in part.troubles}
    return [
        Part(
            done=Evaluation(
                y=part.done.y[k : k + 1],
                counts={"failed": int(k in troubles)},
                observed={name: v[k : k + 1] for name, v in part.done.observed.items()},
            ),
            troubles=(troubles[k],) if k in troubles else (),
        )
        for k in range(len(part))
    ]


def _mixed(chunk: _Chunk, part: Part) -> Part:
    """Return all rows of a chunk, those that were run (`part`) among those that were known."""
    if not chunk.known:
        return part
    own = iter(_rows(part))
    rows = [chunk.known.get(k) or next(own) for k in range(len(chunk.x))]
    whole = join([_moved(row) for row in rows])
    counts = dict(whole.done.counts)
    if "retried" in part.done.counts:
        counts["retried"] = part.done.counts["retried"]
    done = Evaluation(y=whole.done.y, counts=counts, observed=whole.done.observed)
    return Part(done=done, troubles=whole.troubles, seconds=part.seconds)


def _moved(part: Part) -> Part:
    """Return the part of one row with its trouble at row 0."""
    return Part(
        done=part.done,
        troubles=tuple(Trouble(**{**vars(t), "row": 0}) for t in part.troubles),
        seconds=part.seconds,
    )


class Flow:
    """Chunks in flight, and what has come back of them.

    Parameters
    ----------
    pool : Pool
    job : Job
    cutter : Cutter
    pace : Pace
    log : RunLog, optional
    observe : bool
    retries : int
    """

    def __init__(
        self, pool: Pool, job: Job, cutter: Cutter, pace: Pace, *, log: RunLog | None,
        observe: bool, retries: int,
    ) -> None:  # fmt: skip
        self._pool, self._job, self._cutter, self._pace = pool, job, cutter, pace
        self._log, self._observe, self._retries = log, observe, retries
        self._flight: dict[Future[Part], _Chunk] = {}
        self._landed: queue.SimpleQueue[Future[Part]] = queue.SimpleQueue()
        self._ready: dict[int, tuple[_Chunk, Part]] = {}
        self._due = 0
        self._waiting: deque[Part] = deque()
        self.n_done = 0
        """Rows that have come back, in whatever order."""

    def launch(self) -> bool:
        """Send what may be sent; return whether anything is on its way or has come back."""
        n = self._pool.n_workers
        limit = 1 if isinstance(self._pool, Here) else n + max(2, n // 8)
        while len(self._flight) < limit and len(self._flight) + len(self._ready) < 4 * limit:
            cut = self._cutter.next(n)
            if cut is None:
                break
            self._send(self._chunk(*cut))
        return bool(self._flight or self._ready)

    def _chunk(self, start: int, x: FloatArray) -> _Chunk:
        chunk = _Chunk(start, x)
        if self._log is not None and len(self._log):
            for row, point in enumerate(x):
                kept = self._log.get(point)
                if kept is not None:
                    chunk.known[row] = _kept_part(kept.y, kept.trouble)
        return chunk

    def _send(self, chunk: _Chunk) -> None:
        rows = chunk.open
        if not rows:
            whole = join([chunk.known[k] for k in range(len(chunk.x))])
            self._ready[chunk.start] = chunk, whole
            self.n_done += len(chunk.x)
            return
        x = chunk.x if len(rows) == len(chunk.x) else chunk.x[rows]
        future = self._pool.submit(self._job, x, self._observe)
        self._flight[future] = chunk
        future.add_done_callback(self._landed.put)

    def land(self) -> None:
        """Take in what has come back; wait a moment if nothing has."""
        while self._flight:
            try:
                future = self._landed.get(timeout=0.0 if self._due in self._ready else _TICK_S)
            except queue.Empty:
                self._pool.check()
                return
            self._take(self._flight.pop(future), future)
            if self._landed.empty():
                return

    def _take(self, chunk: _Chunk, future: "Future[Part]") -> None:
        try:
            part = future.result()
        except KneecoreError:
            raise
        except CancelledError:
            raise self._gone() from None
        except Exception as error:
            if type(error).__name__ != "KilledWorker":  # distributed's: it is not imported here
                raise broken(error) from error
            self._lost(chunk)
            return
        self._pace.measured(len(part), part.seconds)
        if self._log is not None:
            x = chunk.x[chunk.open] if chunk.known else chunk.x
            self._log.add(x, part.done.y, {t.row: t for t in part.troubles})
        self._ready[chunk.start] = chunk, _mixed(chunk, part)
        self.n_done += len(chunk.x)

    def _gone(self) -> KneecoreError:
        gone = getattr(self._pool, "gone", None)
        error: KneecoreError = gone() if gone is not None else broken(CancelledError())
        return error

    def _lost(self, chunk: _Chunk) -> None:
        """Send the rows of a chunk again, whose workers have died again and again."""
        if len(chunk.x) > 1:
            for row in range(len(chunk.x)):
                self._send(self._chunk(chunk.start + row, chunk.x[row : row + 1]))
            return
        chunk.n_lost += 1
        if chunk.n_lost <= self._retries:
            self._send(chunk)
            return
        trouble = Trouble(
            row=0, kind="died", message="ended the workers that it was given to", tries=chunk.n_lost
        )
        part = failed_part(self._job.work.n_outputs, trouble)
        if self._log is not None:
            self._log.add(chunk.x, part.done.y, {0: trouble})
        self._ready[chunk.start] = chunk, part
        self.n_done += 1

    def in_order(self) -> Iterator[tuple[int, FloatArray, Part]]:
        """Yield (first row, points, part) of what has come back and is due."""
        while self._due in self._ready:
            chunk, part = self._ready.pop(self._due)
            yield chunk.start, chunk.x, part
            self._due += len(chunk.x)
            self._waiting.append(part)

    def batches(self) -> Iterator[Evaluation]:
        """Yield the batches that are complete."""
        lengths = self._cutter.lengths
        while lengths and sum(map(len, self._waiting)) >= lengths[0]:
            yield self._first(lengths.popleft())

    def rest(self) -> Evaluation | None:
        """Return what has come back of the next batch, from its first row on."""
        rows = sum(map(len, self._waiting))
        return self._first(rows) if rows else None

    def _first(self, rows: int) -> Evaluation:
        if not rows:
            y = np.empty((0, self._job.work.n_outputs))
            return Evaluation(y=y, counts={"failed": 0})
        parts: list[Part] = []
        while rows:  # a chunk is of one batch alone, so that they add up
            parts.append(self._waiting.popleft())
            rows -= len(parts[-1])
        return join(parts).done

    def abandon(self) -> None:
        """Let nothing more come back; where all has, the workers stay as they are."""
        if not self._flight:
            return
        for future in self._flight:
            future.cancel()
        self._pool.abandon()
        self._flight.clear()

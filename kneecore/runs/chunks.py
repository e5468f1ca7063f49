"""A stream of points, cut into what one worker is given at a time.

Chunks are sized by what a run was measured to cost: long enough that handing them over costs
little, short enough that all workers end together and that little is lost with one.
"""

from collections import deque
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

__all__ = ["Cutter", "Pace"]

FloatArray = NDArray[np.float64]
TARGET_S = 0.25
"""Wall time of a chunk."""
PER_WORKER_S = 0.004
"""Wall time of a chunk, for each worker: what one costs those who give it out, with room to spare,
so that they keep up with as many workers as there are."""
GROWTH = 8
"""How much larger than the largest measured a chunk may be: first runs are like no others."""
MOST_ROWS = 16_384
FIRST_ROWS = 16
"""Rows of the first chunks, where rows are run together."""


class Pace:
    """What a run costs, as measured.

    Parameters
    ----------
    by_row : bool
        Whether one row is run after the other.
    target_s : float
        Wall time of a chunk, at least.
    """

    def __init__(self, *, by_row: bool, target_s: float = TARGET_S) -> None:
        self._target_s = target_s
        self._first = 1 if by_row else FIRST_ROWS
        self._largest = 0
        self.cost_s: float | None = None

    def measured(self, rows: int, seconds: float) -> None:
        """Take in a chunk's time in the worker."""
        if rows == 0:
            return
        cost = max(seconds, 1e-7) / rows
        # A small chunk next to large ones says little of what rows cost together.
        weight = min(1.0, rows / max(self._largest, 1)) * 0.5
        self.cost_s = cost if self.cost_s is None or rows > self._largest else (
            (1.0 - weight) * self.cost_s + weight * cost
        )  # fmt: skip
        self._largest = max(self._largest, rows)

    def rows(self, n_workers: int, left: int | None) -> int:
        """Return how many rows the next chunk has; `left` is how many there are, where known."""
        if self.cost_s is None:
            return self._first
        target = max(self._target_s, PER_WORKER_S * n_workers)
        rows = min(target / self.cost_s, GROWTH * self._largest, MOST_ROWS)
        if left is not None and n_workers > 1:
            rows = min(rows, np.ceil(left / (2 * n_workers)))
        return max(round(rows), 1)  # two runs of half a second are a second, if barely more


class Cutter:
    """Cuts batches of points, which come one after the other, into chunks.

    No chunk reaches into the next batch: each has counts of its own.

    Parameters
    ----------
    batches : iterable of ndarray
        Points (n, d); taken as they are needed.
    pace : Pace, optional
        None gives each batch as one chunk.
    """

    def __init__(self, batches: Iterable[FloatArray], pace: Pace | None) -> None:
        self._source = iter(batches)
        self._pace = pace
        self._buffer: deque[FloatArray] = deque()
        self._n_buffered = 0
        self._ended = False
        self.lengths: deque[int] = deque()
        """Rows of the batches that were taken."""
        self.n_rows = 0
        """Rows of all chunks until now."""

    def _take(self) -> None:
        batch = next(self._source, None)
        if batch is None:
            self._ended = True
            return
        self.lengths.append(len(batch))
        if len(batch):
            self._buffer.append(batch)
            self._n_buffered += len(batch)

    def next(self, n_workers: int) -> tuple[int, FloatArray] | None:
        """Return the next chunk and the number of its first row; None if there is no more."""
        if not self._ended and not self._buffer:
            self._take()
        if self._pace is None:
            rows = len(self._buffer[0]) if self._buffer else 0
        else:
            wanted = self._pace.rows(n_workers, None)
            while not self._ended and self._n_buffered < 2 * wanted:
                self._take()
            rows = self._pace.rows(n_workers, self._n_buffered if self._ended else None)
        if not self._buffer:
            return None
        batch = self._buffer.popleft()
        x = batch[:rows]
        if len(batch) > rows:
            self._buffer.appendleft(batch[rows:])
        self._n_buffered -= len(x)
        start, self.n_rows = self.n_rows, self.n_rows + len(x)
        return start, x

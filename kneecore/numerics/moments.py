"""Mean, spread and tails of a stream of samples, in little memory."""

import math
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

COVERAGE = 99.7
"""Per cent of a normal distribution within three standard deviations, as the paper rounds it."""


class Stream:
    """Statistics of samples that come in batches and are not kept.

    Means and variances are merged after Chan, Golub & LeVeque 1983 (Am. Stat. 37:242-247), so the
    result depends on the batches in the last bits only, and on nothing else. The percentiles are
    exact: only the samples that can decide them, the extreme ones, are kept.

    Parameters
    ----------
    n_expected : int
        How many samples will come at most.
    coverage : float
        Per cent of the samples between the two percentiles.
    """

    def __init__(self, n_expected: int, coverage: float = COVERAGE) -> None:
        self._tail = 0.005 * (100.0 - coverage)
        self._n_kept = math.ceil(self._tail * n_expected) + 2
        self.n = 0
        self._mean: FloatArray | None = None
        self._squares: FloatArray | None = None
        self._low: FloatArray | None = None
        self._high: FloatArray | None = None

    def add(self, samples: FloatArray) -> None:
        """Add a batch, shape (n, ...); all its numbers must be finite."""
        n = len(samples)
        if n == 0:
            return
        mean = samples.mean(axis=0)
        squares = ((samples - mean) ** 2).sum(axis=0)
        if self._mean is None or self._squares is None or self._low is None or self._high is None:
            self._mean, self._squares = mean, squares
            low = high = samples
        else:
            shift = mean - self._mean
            total = self.n + n
            self._mean = self._mean + shift * (n / total)
            self._squares = self._squares + squares + shift**2 * (self.n * n / total)
            low = np.concatenate([self._low, samples])
            high = np.concatenate([self._high, samples])
        self.n += n
        if low is high and n > 2 * self._n_kept:  # one pass for both ends
            parted = np.partition(samples, (self._n_kept - 1, n - self._n_kept), axis=0)
            low, high = parted[: self._n_kept], parted[-self._n_kept :]
        elif len(low) > self._n_kept:
            low = np.partition(low, self._n_kept - 1, axis=0)[: self._n_kept]
            high = np.partition(high, -self._n_kept, axis=0)[-self._n_kept :]
        self._low, self._high = low, high

    @property
    def state(self) -> dict[str, FloatArray]:
        """All that is kept, by name; empty before the first sample."""
        if self._mean is None or self._squares is None or self._low is None or self._high is None:
            return {}
        return {
            "n": np.array(float(self.n)),
            "mean": self._mean,
            "squares": self._squares,
            "low": self._low,
            "high": self._high,
        }

    @state.setter
    def state(self, state: dict[str, FloatArray]) -> None:
        if state:
            self.n = int(state["n"])
            self._mean, self._squares = state["mean"], state["squares"]
            self._low, self._high = state["low"], state["high"]

    @property
    def mean(self) -> FloatArray:
        """Mean of the samples."""
        assert self._mean is not None
        return self._mean

    @property
    def sd(self) -> FloatArray:
        """Standard deviation, with n - 1."""
        assert self._squares is not None
        root: FloatArray = np.sqrt(self._squares / max(self.n - 1, 1))
        return root

    def sigma_bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return mean -+ three standard deviations."""
        return self.mean - 3.0 * self.sd, self.mean + 3.0 * self.sd

    def percentile_bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the percentiles that cut off the tails, interpolated as NumPy does."""
        assert self._low is not None
        assert self._high is not None
        position = (self.n - 1) * self._tail
        index, share = int(position), position - int(position)
        after = min(index + 1, self.n - 1)
        low, high = np.sort(self._low, axis=0), np.sort(self._high, axis=0)
        lower = (1.0 - share) * low[index] + share * low[after]
        upper = (1.0 - share) * high[-1 - index] + share * high[-1 - after]
        return lower, upper

    def column(self, k: int) -> "Stream":
        """Return the statistics of one column, to go on by itself."""
        one = Stream.__new__(Stream)
        one._tail, one._n_kept, one.n = self._tail, self._n_kept, self.n
        for name in ("_mean", "_squares", "_low", "_high"):
            value = getattr(self, name)
            setattr(one, name, None if value is None else value[..., k : k + 1])
        return one


class GappyStream:
    """Statistics of samples of which some numbers are missing: each column has its own samples.

    Parameters
    ----------
    before : Stream
        What came until now, without gaps.
    n_columns : int
    """

    def __init__(self, before: Stream, n_columns: int) -> None:
        self._columns = [before.column(k) for k in range(n_columns)]

    def add(self, samples: FloatArray) -> None:
        """Add a batch, shape (n, m); what is not finite is missing."""
        for k, column in enumerate(self._columns):
            values = samples[:, k : k + 1]
            column.add(values[np.isfinite(values[:, 0])])

    @property
    def state(self) -> dict[str, FloatArray]:
        """All that is kept, by name."""
        return {
            f"{k}/{part}": values
            for k, column in enumerate(self._columns)
            for part, values in column.state.items()
        } | {"n_columns": np.array(float(len(self._columns)))}

    @property
    def n(self) -> NDArray[np.int64]:
        """Samples of each column."""
        return np.array([column.n for column in self._columns])

    def _told(self, of: Callable[[Stream], FloatArray]) -> FloatArray:
        """Return a statistic of each column; NaN where there are less than two samples."""
        return np.array([of(c)[0] if c.n > 1 else np.nan for c in self._columns])

    @property
    def mean(self) -> FloatArray:
        """Mean of the samples."""
        return self._told(lambda column: column.mean)

    @property
    def sd(self) -> FloatArray:
        """Standard deviation, with n - 1."""
        return self._told(lambda column: column.sd)

    def sigma_bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return mean -+ three standard deviations."""
        return self.mean - 3.0 * self.sd, self.mean + 3.0 * self.sd

    def percentile_bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the percentiles that cut off the tails."""
        return (
            self._told(lambda column: column.percentile_bounds()[0]),
            self._told(lambda column: column.percentile_bounds()[1]),
        )


def restored(n_expected: int, state: Mapping[str, FloatArray]) -> Stream | GappyStream:
    """Return what had a `state`."""
    before = Stream(n_expected)
    if "n_columns" not in state:
        before.state = dict(state)
        return before
    gappy = GappyStream(before, int(state["n_columns"]))
    for k, column in enumerate(gappy._columns):
        mark = f"{k}/"
        column.state = {
            part.removeprefix(mark): v for part, v in state.items() if part.startswith(mark)
        }
    return gappy

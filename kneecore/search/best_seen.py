"""The best pair among the models that a search has evaluated so far: an answer before the answer.

The two models whose weighted sums of outputs lie farthest apart. Where one of the worst curves is
above the other everywhere, that is the pair that the search will end with; where they cross, it may
be a lesser one.
"""

import numpy as np
from numpy.typing import NDArray

__all__ = ["BestSeen"]

FloatArray = NDArray[np.float64]


class BestSeen:
    """Takes in evaluated models, and keeps the two at the ends.

    Parameters
    ----------
    weights : ndarray, shape (m,)
        Weight of each output's difference.
    """

    def __init__(self, weights: FloatArray) -> None:
        self._weights = weights
        self.n_models = self.n_failed = 0
        self._sums = [-np.inf, -np.inf]
        self._ends: list[tuple[FloatArray, FloatArray] | None] = [None, None]

    def take(self, u: FloatArray, y: FloatArray) -> None:
        """Take in models (n, d) in the unit cube with their outputs (n, m); NaN is a failure."""
        sums = y @ self._weights
        self.n_models += len(u)
        self.n_failed += int(np.count_nonzero(~np.isfinite(sums)))
        for k, signed in enumerate((sums, -sums)):
            reached = np.where(np.isfinite(signed), signed, -np.inf)
            best = int(np.argmax(reached))
            if reached[best] > self._sums[k]:
                self._sums[k] = float(reached[best])
                self._ends[k] = u[best].copy(), y[best].copy()

    @property
    def value(self) -> float:
        """The pair's f; minus infinity before there is one."""
        high, low = self._ends
        if high is None or low is None:
            return -np.inf
        return float((self._weights * np.abs(high[1] - low[1])).sum())

    @property
    def pair(self) -> tuple[FloatArray, FloatArray] | None:
        """The two models, shape (2, d), and their outputs, shape (2, m); None before any."""
        high, low = self._ends
        if high is None or low is None:
            return None
        return np.stack([high[0], low[0]]), np.stack([high[1], low[1]])

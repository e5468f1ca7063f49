"""Runs that failed in some of their outputs: those outputs alone are lost."""

from collections.abc import MutableMapping

import numpy as np
from numpy.typing import NDArray

__all__ = ["count_partial"]

FloatArray = NDArray[np.float64]


def count_partial(counts: MutableMapping[str, int], y: FloatArray) -> int:
    """Count runs (n, m) that gave some outputs as "partial", which were counted as "failed".

    Returns how many there are; without any, `counts` gets no such name.
    """
    finite = np.isfinite(y)
    n = int(np.count_nonzero(finite.any(axis=1) & ~finite.all(axis=1)))
    if n:
        counts["failed"] -= n
        counts["partial"] = counts.get("partial", 0) + n
    return n

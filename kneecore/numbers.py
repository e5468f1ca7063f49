"""Numbers as JSON holds them."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

DIGITS = 10
"""Decimals that are kept in display units: reading and writing again then changes no byte."""


def plain(values: ArrayLike, factor: float = 1.0) -> Any:
    """Return numbers times `factor` as (nested lists of) floats, None where they are not finite."""
    # Adding 0 turns -0 into 0.
    array = np.round(np.asarray(values, dtype=np.float64) * factor, DIGITS) + 0.0
    held = np.array(array, dtype=object)
    held[~np.isfinite(array)] = None
    return held.tolist()


def exact(values: ArrayLike) -> Any:
    """Return numbers as (nested lists of) floats with all their digits, None if not finite."""
    array = np.asarray(values, dtype=np.float64) + 0.0
    held = np.array(array, dtype=object)
    held[~np.isfinite(array)] = None
    return held.tolist()

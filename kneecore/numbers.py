"""Numbers as JSON holds them."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

DIGITS = 10
"""Decimals of a knee's numbers in display units: reading and writing again changes no byte."""


def plain(values: ArrayLike, factor: float = 1.0, digits: int | None = DIGITS) -> Any:
    """Return numbers times `factor` as (nested lists of) floats, None where they are not finite.

    They have `digits` decimals; None keeps them whole.
    """
    array = np.asarray(values, dtype=np.float64) * factor
    # Adding 0 turns -0 into 0.
    array = (array if digits is None else np.round(array, digits)) + 0.0
    held = np.array(array, dtype=object)
    held[~np.isfinite(array)] = None
    return held.tolist()


def exact(values: ArrayLike) -> Any:
    """Return numbers as (nested lists of) floats with all their digits, None if not finite."""
    return plain(values, digits=None)

"""What running a model gives, as the model tells it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

__all__ = ["Evaluation", "Watch"]

FloatArray = NDArray[np.float64]
Watch = Callable[[int], object]
"""Gets the number of runs done, in whatever order; a true result cancels."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Evaluation:
    """What running a model for n points has given."""

    y: FloatArray
    """Outputs, shape (n, m); a row that is not finite is a failed run."""
    counts: Mapping[str, int]
    """Runs by what became of them; "failed" is always there."""
    observed: Mapping[str, FloatArray] = field(default_factory=dict)
    """Further quantities by name, shape (n, ...), where they were asked for."""

"""What a measure has found: numbers, and what else a reader must know of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Finding"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Finding:
    """Our values for a claim, where numbers alone do not say all."""

    values: NDArray[np.float64]
    """One, one for each seed, or one for each pair: the exact optimum first, then the seeds."""
    indifferent: bool = False
    """Whether what speaks against the claim hardly moves f, so that chance decides it."""
    told: str = ""
    """A sentence for the verdict's reasons."""

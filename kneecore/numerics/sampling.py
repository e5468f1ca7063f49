"""Points of the unit cube, the same for the same seed."""

from collections.abc import Iterator
from typing import get_args

import numpy as np
import scipy  # its subpackages are loaded when they are used: plain sampling needs none
from numpy.typing import NDArray

from kneecore._arguments import choice
from kneecore.numerics.sampling_options import Sampling, check_count, check_seed

__all__ = ["batches", "n_drawn", "uniform"]

FloatArray = NDArray[np.float64]


def uniform(n_samples: int, n_dimensions: int, seed: int) -> FloatArray:
    """Return independent uniform points, shape (n_samples, n_dimensions).

    The first rows do not depend on how many are asked for.
    """
    return np.random.default_rng(check_seed(seed)).random((n_samples, n_dimensions))


def _checked(sampling: Sampling) -> Sampling:
    allowed = get_args(Sampling)
    return choice("sampling", sampling, allowed, f"{', '.join(allowed)} are allowed")


def n_drawn(n_samples: int, sampling: Sampling) -> int:
    """Return how many points `batches` gives: for Sobol' the next power of two."""
    n_samples = check_count("n_samples", n_samples)
    if _checked(sampling) == "sobol":
        return int(2 ** int(np.ceil(np.log2(n_samples))))
    return n_samples


def batches(
    n_samples: int, n_dimensions: int, seed: int, *, sampling: Sampling = "uniform", size: int
) -> Iterator[FloatArray]:
    """Yield points in batches of at most `size`; the points do not depend on the size.

    Parameters
    ----------
    n_samples : int
        How many points are wanted; `n_drawn` tells how many come.
    sampling : {"uniform", "latin-hypercube", "sobol"}
        Independent points; a Latin hypercube (drawn at once: 8 bytes a coordinate); or a
        scrambled Sobol' sequence, whose balance needs a power of two.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    left = n_drawn(n_samples, sampling)
    rng = np.random.default_rng(check_seed(seed))
    if sampling == "uniform":
        while left > 0:
            yield rng.random((min(size, left), n_dimensions))
            left -= size
        return

    if sampling == "latin-hypercube":
        # Its columns are independent: drawn one by one they take half the room.
        points = np.empty((left, n_dimensions))
        for column in range(n_dimensions):
            points[:, column] = scipy.stats.qmc.LatinHypercube(1, rng=rng).random(left)[:, 0]
        for first in range(0, left, size):
            yield points[first : first + size]
        return
    engine = scipy.stats.qmc.Sobol(n_dimensions, rng=rng)
    # Sobol' batches keep the sequence's balance if they are powers of two.
    size = 2 ** int(np.log2(min(size, left)))
    for _ in range(left // size):
        yield engine.random(size)

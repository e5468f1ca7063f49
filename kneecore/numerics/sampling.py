"""Points of the unit cube, the same for the same seed."""

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ParameterError


def check_count(name: str, value: int) -> int:
    """Return `value` checked: a whole number of at least 1.

    Raises
    ------
    ParameterError
        If it is anything else; the message calls it `name`.
    """
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise ParameterError(f"`{name}` is {value!r}; a whole number of at least 1 is allowed")
    return int(value)


def check_seed(seed: int) -> int:
    """Return `seed` checked: a whole number from 0 to 2^63 - 1.

    Raises
    ------
    ParameterError
        If it is anything else.
    """
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or not 0 <= seed < 2**63:
        raise ParameterError(f"`seed` is {seed!r}; a whole number from 0 to 2^63 - 1 is allowed")
    return int(seed)


def uniform(n_samples: int, n_dimensions: int, seed: int) -> NDArray[np.float64]:
    """Return independent uniform points, shape (n_samples, n_dimensions).

    The first rows do not depend on how many are asked for.
    """
    return np.random.default_rng(check_seed(seed)).random((n_samples, n_dimensions))

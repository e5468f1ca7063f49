"""Arrays that somebody else hands over, checked: apart from `_arguments`, which needs no NumPy."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore.errors import ParameterError

__all__ = ["numbers"]


def numbers(name: str, values: ArrayLike, said: str = "numbers are allowed") -> NDArray[np.float64]:
    """Return `values` as an array of float64: whole or real numbers, never texts or booleans.

    Raises
    ------
    ParameterError
        If they are anything else.
    """
    if isinstance(values, np.ndarray) and values.dtype == np.float64:
        return values
    try:
        array = np.asarray(values)
        # Objects are whole numbers of more than 64 bits, fractions, None, or nothing of the kind.
        if array.dtype.kind not in "iufO":
            raise TypeError
        if array.dtype.kind == "O" and any(isinstance(v, str | bool) for v in array.flat):
            raise TypeError
        return np.asarray(array, dtype=np.float64)
    except (TypeError, ValueError, OverflowError, RecursionError, AttributeError):
        raise ParameterError(f"`{name}` is not an array of numbers; {said}") from None

"""What can be read from a knee's angles: one number for each knee."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._arguments import shown
from kneecore.errors import ParameterError
from kneecore.knee.response import LARGEST_EXTENSION, MOMENT

__all__ = ["DEFICIT", "READINGS", "deficit_deg", "over_extension_deg", "reading"]

FloatArray = NDArray[np.float64]

DEFICIT = "extension deficit"
"""How far a knee stays bent under the largest extending moment, deg; 0 if it becomes straight."""
READINGS = (DEFICIT, *(f"{m:+g} N m" for m in MOMENT[np.argsort(-MOMENT)]))
"""What can be read from 12 angles: the deficit, or the angle at a load."""


def reading(flexion_deg: ArrayLike, name: str) -> FloatArray:
    """Return one number for each knee, shape (..., 12) -> (...,), deg.

    Parameters
    ----------
    flexion_deg : array_like, shape (..., 12)
        Angles at the 12 loads, deg.
    name : str
        One of `READINGS`.

    Raises
    ------
    ParameterError
        If there is no such reading.
    """
    angles = np.asarray(flexion_deg, dtype=np.float64)
    if name not in READINGS:
        raise ParameterError(f"`name` is {shown(name)}; {', '.join(READINGS)} are allowed")
    if name == DEFICIT:
        return np.maximum(angles[..., LARGEST_EXTENSION], 0.0)
    load = next(k for k, m in enumerate(MOMENT) if f"{m:+g} N m" == name)
    return np.asarray(angles[..., load])


def deficit_deg(pair_deg: FloatArray) -> FloatArray:
    """Return what the second knee of pairs (n, 2) at the largest extension lacks of straight."""
    return np.maximum(pair_deg[:, 1], 0.0)


def over_extension_deg(pair_deg: FloatArray) -> FloatArray:
    """Return how far the first knee of pairs (n, 2) at the largest extension over-extends."""
    return np.maximum(-pair_deg[:, 0], 0.0)

"""What a model of the user's own has returned, checked: nothing but real numbers is cast."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ParameterError

__all__ = ["all_outputs", "numbers", "one_output"]

FloatArray = NDArray[np.float64]


def numbers(what: str, given: Any) -> FloatArray:
    """Return what a model returned as floats; nothing but real numbers is cast."""
    if np.ma.isMaskedArray(given):
        raise ParameterError(f"`{what}` returned a masked array; NaN marks a failed run")
    try:
        values = np.asarray(given)
    except ValueError:
        raise ParameterError(
            f"`{what}` returned a ragged array; numbers in rows are allowed"
        ) from None
    if values.dtype.kind == "c":
        raise ParameterError(f"`{what}` returned complex numbers; real numbers are allowed")
    if values.dtype.kind not in "iuf":
        raise ParameterError(f"`{what}` returned something other than an array of numbers")
    return np.asarray(values, dtype=np.float64)


def all_outputs(given: Any, n_points: int, n_outputs: int) -> FloatArray:
    """Return what a batched model returned, checked to be (n, m)."""
    values = numbers("run", given)
    if values.shape == (n_points, n_outputs):
        return values
    hint = ""
    if values.ndim < 2:
        hint = "; a function of one point at a time needs batched=False"
        if values.shape == (n_points,) and n_outputs == 1:
            hint = "; one output still needs its own axis: y[:, None]"
    elif len(values) == n_points:
        hint = f"; `outputs` names {n_outputs} numbers"
    raise ParameterError(
        f"`run` returned shape {values.shape} for {n_points} points; ({n_points}, {n_outputs}) is "
        f"allowed{hint}"
    )


def one_output(given: Any, n_outputs: int) -> FloatArray:
    """Return what a model returned for one point, checked to be (m,) or one number."""
    values = numbers("run", given)
    if values.shape == (n_outputs,) or (values.ndim == 0 and n_outputs == 1):
        return values
    hint = "; a function of many points at once needs batched=True" if values.ndim == 2 else ""
    raise ParameterError(
        f"`run` returned shape {values.shape} for one point; ({n_outputs},) is allowed{hint}"
    )

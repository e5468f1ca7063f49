"""What a model of the user's own returns, checked: nothing but real numbers is cast."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._arguments import shown
from kneecore.errors import ParameterError
from kneecore.shape import Shape

__all__ = ["jacobian_of", "run_all", "run_one", "shapes_of"]

FloatArray = NDArray[np.float64]
Function = Callable[[FloatArray], ArrayLike]

_ONE_POINT = "; a function of one point at a time needs batched=False"
_MANY_POINTS = "; a function of many points at once needs batched=True"


def _numbers(what: str, given: Any) -> FloatArray:
    """Return what a function returned as floats; nothing but real numbers is cast."""
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
        raise ParameterError(f"`{what}` returned {shown(given)}; an array of numbers is allowed")
    return np.asarray(values, dtype=np.float64)


def _misunderstood(error: Exception, points: FloatArray, need: str) -> ParameterError:
    """Return the error of a function that may not be made for an argument of such a shape."""
    said = " ".join(str(error).split())
    return ParameterError(
        f"`run` raised {type(error).__name__} ({said}) for an array of shape {points.shape}; "
        f"a function of {need}"
    )


def run_all(run: Function, x: FloatArray, n_outputs: int) -> FloatArray:
    """Run a batched model for points (n, d); its outputs, checked to be (n, m)."""
    try:
        given = run(x.copy())
    except (TypeError, IndexError, ValueError) as error:
        raise _misunderstood(error, x, "one point at a time needs batched=False") from error
    values = _numbers("run", given)
    n = len(x)
    if values.shape == (n, n_outputs):
        return values
    hint = ""
    if values.ndim < 2:
        hint = _ONE_POINT
        if values.shape == (n,) and n_outputs == 1:
            hint = "; one output still needs its own axis: y[:, None]"
    elif len(values) == n:
        hint = f"; `outputs` names {n_outputs}"
    raise ParameterError(
        f"`run` returned shape {values.shape} for {n} points; ({n}, {n_outputs}) is allowed{hint}"
    )


def run_one(run: Function, point: FloatArray, n_outputs: int) -> FloatArray:
    """Run a model for one point (d,); its outputs, checked, shape (m,) or one number."""
    try:
        given = run(point.copy())
    except (TypeError, IndexError) as error:
        raise _misunderstood(error, point, "many points at once needs batched=True") from error
    values = _numbers("run", given)
    if values.shape == (n_outputs,) or (values.ndim == 0 and n_outputs == 1):
        return values
    hint = _MANY_POINTS if values.ndim == 2 else f"; `outputs` names {n_outputs}"
    raise ParameterError(
        f"`run` returned shape {values.shape} for one point; ({n_outputs},) is allowed{hint}"
    )


def jacobian_of(gradient: Function, x: FloatArray, n_outputs: int) -> FloatArray:
    """Return the derivatives at points (n, d), checked to be (n, m, d)."""
    values = _numbers("gradient", gradient(x.copy()))
    wanted = (len(x), n_outputs, x.shape[1])
    if values.shape != wanted:
        raise ParameterError(
            f"`gradient` returned shape {values.shape}; {wanted} (n, m, d) is allowed"
        )
    return values


def shapes_of(draw: Callable[[FloatArray], Sequence[Shape]], x: FloatArray) -> tuple[Shape, ...]:
    """Return the picture of a point (d,), checked to be made of shapes."""
    given: Any = draw(x.copy())
    if not isinstance(given, Sequence) or not all(isinstance(one, Shape) for one in given):
        raise ParameterError(f"`draw` returned {shown(given)}; a list of kneecore.Shape is allowed")
    return tuple(given)

"""Inputs that are measured together, and bounds that are narrowed input by input."""

from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._arrays import numbers
from kneecore.errors import ParameterError
from kneecore.inputs import Input

__all__ = ["Measured", "held"]

FloatArray = NDArray[np.float64]


def held(values: Sequence[float]) -> FloatArray:
    """Return numbers as an array that cannot be written to."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


class Measured:
    """The part of a `Model` that tells which of its inputs are measured at once, and how well."""

    inputs: tuple[Input, ...]
    lower: FloatArray
    upper: FloatArray
    free: NDArray[np.bool_]
    proxy: Any

    @property
    def measurements(self) -> Mapping[str, str]:
        """Which measurement tells each input, by name: one knows all its inputs equally well."""
        return {one.name: one.name for one in self.inputs}

    def stated_tolerance(self, name: str) -> tuple[float, str]:
        """Return how far an input may be from the middle of its bounds, and the unit of that."""
        one = next(i for i in self.inputs if i.name == name)
        if one.tolerance_percent is not None:
            return one.tolerance_percent, "%"
        return one.shown(0.5 * (one.upper - one.lower)), one.label

    def with_widths(self, factors: ArrayLike) -> Self:
        """Return the model with bounds `factors` times as wide, (d,), around the nominal point.

        Raises
        ------
        ParameterError
            If they are not d numbers of at least 0, or no input is left to vary.
        """
        model = self._copy()
        shares = self._checked_factors(factors).tolist()
        model.inputs = tuple(i.widened(f) for i, f in zip(self.inputs, shares, strict=True))
        model.lower = held([i.lower for i in model.inputs])
        model.upper = held([i.upper for i in model.inputs])
        model.free = model.upper > model.lower
        model.free.setflags(write=False)
        if not model.free.any():
            raise ParameterError("`factors` leave no input to vary; one above 0 is needed")
        if self.proxy is not None:
            model.proxy = self.proxy.with_widths(factors)
        return model

    def _checked_factors(self, factors: ArrayLike) -> FloatArray:
        n = len(self.inputs)
        values = numbers("factors", factors)
        if values.shape != (n,) or not (np.isfinite(values) & (values >= 0.0)).all():
            raise ParameterError(
                f"`factors` has shape {values.shape}; ({n},) finite numbers of at least 0 are "
                "allowed"
            )
        return values

    def _copy(self) -> Self:
        raise NotImplementedError

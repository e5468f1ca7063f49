"""What comes out of a model: names, units, axes.

Examples
--------
>>> from kneecore import Output
>>> Output("gain", unit="dB", axis=[1, 10, 100], axis_unit="Hz").n_columns
3
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kneecore._arguments import number, one_line, shown
from kneecore._arrays import numbers
from kneecore.errors import ParameterError
from kneecore.inputs import LONGEST, named

__all__ = ["Column", "Output", "scales_of", "weights_of"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Output:
    """One output: a number, or a curve over an axis.

    Raises
    ------
    ParameterError
        If the axis is not a row of finite numbers, or `scale` is not above 0.
    """

    name: str
    unit: str = field(default="", kw_only=True)
    axis: tuple[float, ...] | None = field(default=None, kw_only=True)
    """Where the curve is known, one value a number that the model returns; None for one number."""
    axis_name: str = field(default="", kw_only=True)
    axis_unit: str = field(default="", kw_only=True)
    scale: float | None = field(default=None, kw_only=True)
    """Difference, in `unit`, that counts as 1; needed where outputs have different units."""

    def __post_init__(self) -> None:
        named("Output", self.name)
        for name in ("unit", "axis_name", "axis_unit"):
            one_line(f"{name} of {self.name}", getattr(self, name), LONGEST)
        if self.axis is not None:
            object.__setattr__(self, "axis", self._checked_axis())
        if self.scale is not None:
            scale = number(f"scale of {self.name}", self.scale)
            if scale <= 0.0:
                raise ParameterError(f"`scale of {self.name}` is {scale:g}; above 0 is allowed")
            object.__setattr__(self, "scale", scale)

    def _checked_axis(self) -> tuple[float, ...]:
        try:
            axis = np.asarray(self.axis)
            usable = axis.dtype.kind in "iuf" and axis.ndim == 1 and axis.size > 0
        except ValueError:
            usable = False
        if not (usable and np.isfinite(axis).all()):
            raise ParameterError(
                f"`axis of {self.name}` is {shown(self.axis)}; a row of finite numbers is allowed"
            )
        return tuple(float(v) for v in axis)

    @property
    def n_columns(self) -> int:
        """How many of the model's numbers belong to this output."""
        return 1 if self.axis is None else len(self.axis)


@dataclass(frozen=True)
class Column:
    """One number among a model's outputs."""

    output: Output
    at: float | None
    """Place on the output's axis."""
    alone: bool
    """Whether there is no other output, so that the place says enough."""

    @property
    def label(self) -> str:
        """The column in words, such as `+5 N m` or `gain at 10 Hz`."""
        if self.at is None:
            return self.output.name
        signed = self.output.axis is not None and min(self.output.axis) < 0.0 < max(
            self.output.axis
        )
        place = f"{self.at:{'+' if signed else ''}g} {self.output.axis_unit}".rstrip()
        return place if self.alone else f"{self.output.name} at {place}"

    @property
    def title(self) -> str:
        """The column with its output's name, such as `flexion at +5 N m`."""
        alone_on_axis = self.alone and self.at is not None
        return f"{self.output.name} at {self.label}" if alone_on_axis else self.label


def scales_of(outputs: Sequence[Output]) -> list[float]:
    """Return the difference that counts as 1 for each number of a model's outputs.

    Raises
    ------
    ParameterError
        If outputs of different units have none.
    """
    units = {output.unit for output in outputs}
    unscaled = [output.name for output in outputs if output.scale is None]
    if len(units) > 1 and unscaled:
        raise ParameterError(
            f"`outputs` have different units ({', '.join(sorted(u or 'none' for u in units))}) "
            f"and {unscaled[0]!r} has no `scale`; give each the difference that counts as 1, "
            "such as Output('gain', unit='dB', scale=3)"
        )
    columns = [output.scale for output in outputs for _ in range(output.n_columns)]
    return [1.0 if scale is None else scale for scale in columns]


def weights_of(counting: FloatArray, given: Sequence[float] | None) -> FloatArray:
    """Return the weights of what counts, (m,), times those that are given.

    Raises
    ------
    ParameterError
        If those are not m numbers, or nothing is left that counts.
    """
    weights = counting
    if given is not None:
        own = numbers("weights", given)
        if own.shape != counting.shape:
            raise ParameterError(
                f"`weights` has shape {own.shape}; ({len(counting)},) is needed, one for each "
                "number that the model returns"
            )
        weights = counting * own
    if not weights.any():
        raise ParameterError(
            "`weights` are all 0 where the objective counts; one above 0 is needed"
        )
    return weights

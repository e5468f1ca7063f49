"""What goes into a model and what comes out of it: names, bounds, units, axes.

Examples
--------
>>> from kneecore import Input, Output
>>> stiffness = Input("k", nominal=100.0, tolerance_percent=10, unit="N/mm")
>>> stiffness.lower, stiffness.upper
(90.0, 110.0)
>>> Output("gain", unit="dB", axis=[1, 10, 100], axis_unit="Hz").n_columns
3
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from kneecore._arguments import number, one_line, shown
from kneecore.errors import ParameterError

__all__ = ["Column", "Input", "Output", "all_of", "scales_of"]

_LONGEST = 200  # characters of a name or a unit


def _named(kind: str, value: Any) -> str:
    if not isinstance(value, str) or not value.strip():
        raise ParameterError(f"`name` of an {kind} is {shown(value)}; a text is needed")
    return one_line(f"name of an {kind}", value, _LONGEST)


@dataclass(frozen=True)
class Input:
    """One uncertain input: what it is called, and how far it may be from its nominal value.

    The uncertainty is given in one of three ways: `tolerance_percent`, `half_range`, or `lower` and
    `upper`. An input without width is held.

    Raises
    ------
    ParameterError
        If a value is not one finite number, or the uncertainty is given in no way or in two.
    """

    name: str
    nominal: float | None = field(default=None, kw_only=True)
    """The value that is expected, in `unit`; the middle of the bounds if not given."""
    tolerance_percent: float | None = field(default=None, kw_only=True)
    """Half-range in per cent of the nominal value."""
    half_range: float | None = field(default=None, kw_only=True)
    """Half-range around the nominal value, in `unit`."""
    lower: float = field(default=None, kw_only=True)  # type: ignore[assignment]
    """Least value, in `unit`."""
    upper: float = field(default=None, kw_only=True)  # type: ignore[assignment]
    """Largest value, in `unit`."""
    unit: str = field(default="", kw_only=True)
    """Unit of the values that the model gets."""
    shown_unit: str | None = field(default=None, kw_only=True)
    """Unit for tables and axes, where it is another."""
    shown_scale: float = field(default=1.0, kw_only=True)
    """One `shown_unit` in `unit`s."""
    measurement: str | None = field(default=None, kw_only=True)
    """What it is measured with, by name, together with others of the same; by itself if not
    given. `accuracy_allocation` tells how good each measurement must be."""

    def __post_init__(self) -> None:
        _named("Input", self.name)
        for name in ("nominal", "tolerance_percent", "half_range", "lower", "upper"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, number(f"{name} of {self.name}", value))
        for name in ("unit", *(("shown_unit",) if self.shown_unit is not None else ())):
            one_line(f"{name} of {self.name}", getattr(self, name), _LONGEST)
        if self.measurement is not None:
            name = f"measurement of {self.name}"
            if not one_line(name, self.measurement, _LONGEST):
                raise ParameterError(f"`{name}` is {shown(self.measurement)}; a text is needed")
        if number(f"shown_scale of {self.name}", self.shown_scale) <= 0.0:
            raise ParameterError(
                f"`shown_scale of {self.name}` is {self.shown_scale:g}; above 0 is allowed"
            )
        lower, upper = self._bounds()
        if not (np.isfinite(lower) and np.isfinite(upper) and np.isfinite(upper - lower)):
            raise ParameterError(f"the bounds of `{self.name}` are too wide for numbers")
        if lower > upper:
            raise ParameterError(
                f"`lower of {self.name}` is {lower:g}, above its `upper`, {upper:g}"
            )
        object.__setattr__(self, "lower", lower)
        object.__setattr__(self, "upper", upper)
        if self.nominal is None:
            object.__setattr__(self, "nominal", lower + 0.5 * (upper - lower))

    def _bounds(self) -> tuple[float, float]:
        """Return (lower, upper) from the one way in which they are given."""
        ways = (self.tolerance_percent, self.half_range, self.lower)
        if sum(way is not None for way in ways) != 1 or (self.lower is None) != (
            self.upper is None
        ):
            raise ParameterError(
                f"the bounds of `{self.name}` are given in no way, or in several; one is needed: "
                "`tolerance_percent`, `half_range`, or `lower` and `upper`"
            )
        if self.lower is not None:
            return self.lower, self.upper
        if self.nominal is None:
            raise ParameterError(
                f"`nominal of {self.name}` is None; a number is needed with a tolerance or a "
                "half-range"
            )
        name, half = "half_range", self.half_range
        if self.tolerance_percent is not None:
            name, half = "tolerance_percent", self.tolerance_percent
        if half is None or half < 0.0:
            raise ParameterError(f"`{name} of {self.name}` is {half:g}; at least 0 is allowed")
        if self.tolerance_percent is not None:
            half = 0.01 * self.tolerance_percent * abs(self.nominal)
        return self.nominal - half, self.nominal + half

    def widened(self, factor: float) -> Self:
        """Return the input with bounds `factor` times as far from its nominal value."""
        assert self.nominal is not None
        return replace(
            self,
            tolerance_percent=None,
            half_range=None,
            lower=self.nominal - factor * (self.nominal - self.lower),
            upper=self.nominal + factor * (self.upper - self.nominal),
        )

    @property
    def label(self) -> str:
        """The unit for tables and axes."""
        return self.unit if self.shown_unit is None else self.shown_unit

    def shown(self, value: float) -> float:
        """Return a value in the unit for tables and axes."""
        return value / self.shown_scale


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
        _named("Output", self.name)
        for name in ("unit", "axis_name", "axis_unit"):
            one_line(f"{name} of {self.name}", getattr(self, name), _LONGEST)
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


def all_of(kind: type[Any], argument: str, given: Any) -> tuple[Any, ...]:
    """Return a list of inputs or outputs checked: at least one, each with its own name."""
    if isinstance(given, str | kind | Mapping) or not isinstance(given, Sequence):
        raise ParameterError(
            f"`{argument}` is {shown(given)}; a list of kneecore.{kind.__name__} is allowed"
        )
    wrong = next((item for item in given if not isinstance(item, kind)), None)
    if wrong is not None or not given:
        raise ParameterError(
            f"`{argument}` has {shown(wrong)} in it; kneecore.{kind.__name__}s are allowed"
            if given
            else f"`{argument}` is empty; at least one kneecore.{kind.__name__} is needed"
        )
    names = [item.name for item in given]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ParameterError(f"`{argument}` has the name {twice!r} twice; each needs its own")
    return tuple(given)

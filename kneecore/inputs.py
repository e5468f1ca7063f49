"""What goes into a model: names, bounds, units, and how likely the values are.

Examples
--------
>>> from kneecore import Input
>>> stiffness = Input("k", nominal=100.0, tolerance_percent=10, unit="N/mm")
>>> stiffness.lower, stiffness.upper
(90.0, 110.0)
>>> Input("teeth", lower=17, upper=21, integer=True).allowed
(17.0, 18.0, 19.0, 20.0, 21.0)
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from kneecore._arguments import choice, flag, number, one_line, shown
from kneecore.distributions import (
    KINDS,
    USUAL_DEVIATIONS,
    WITH_DEVIATIONS,
    Distribution,
    Kind,
)
from kneecore.errors import ParameterError
from kneecore.grid import Grid, choices_of, whole_within

__all__ = ["LONGEST", "Input", "all_of", "named"]

LONGEST = 200
"""Characters of a name or a unit."""
_NUMBERS = (
    "nominal", "tolerance_percent", "half_range", "lower", "upper", "deviations", "mode", "least",
    "most", "quantile",
)  # fmt: skip


def named(kind: str, value: Any) -> str:
    """Return the name of an input or an output, checked."""
    if not isinstance(value, str) or not value.strip():
        raise ParameterError(f"`name` of an {kind} is {shown(value)}; a text is needed")
    return one_line(f"name of an {kind}", value, LONGEST)


@dataclass(frozen=True)
class Input:
    """One uncertain input: what it is called, and how far it may be from its nominal value.

    The uncertainty is given in one of four ways: `tolerance_percent`, `half_range`, `lower` and
    `upper`, or `choices`. An input without width is held.

    A search for the worst case looks between the bounds, whatever the distribution, unless there is
    a `quantile`. Sampling and influence draw from the distribution.

    Raises
    ------
    ParameterError
        If a value is not one finite number, the uncertainty is given in no way or in two, or an
        option of one distribution is given with another.
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
    integer: bool = field(default=False, kw_only=True)
    """Whether only the whole numbers between the bounds are allowed."""
    choices: tuple[float, ...] | None = field(default=None, kw_only=True)
    """The only values that are allowed, in the place of bounds: numbers, kept in ascending order.
    Between whole numbers or choices, each is as likely as another."""
    distribution: Kind = field(default="uniform", kw_only=True)
    """How samples are drawn: uniform, normal, truncated-normal (cut off at the bounds), log-normal,
    or triangular with its peak at `mode`."""
    deviations: float | None = field(default=None, kw_only=True)
    """How many standard deviations the bounds are from the mean of a normal or truncated normal
    distribution, which is in their middle; of a log-normal one, the same of the logarithms. 3 if
    not given: the bounds hold 99.7 % of the values."""
    mode: float | None = field(default=None, kw_only=True)
    """Most likely value of a triangular distribution; the nominal one if not given."""
    least: float | None = field(default=None, kw_only=True)
    """Value below which nothing is possible: bounds and distribution end there."""
    most: float | None = field(default=None, kw_only=True)
    """Value above which nothing is possible, likewise."""
    quantile: float | None = field(default=None, kw_only=True)
    """Share of the distribution, in its middle, that a search looks at in the place of what is
    between the bounds: 0.95 leaves out 2.5 % on each side."""
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
        named("Input", self.name)
        for name in _NUMBERS:
            value = getattr(self, name)
            if value is not None:
                self._set(name, number(f"{name} of {self.name}", value))
        for name in ("unit", *(("shown_unit",) if self.shown_unit is not None else ())):
            one_line(f"{name} of {self.name}", getattr(self, name), LONGEST)
        if self.measurement is not None:
            name = f"measurement of {self.name}"
            if not one_line(name, self.measurement, LONGEST):
                raise ParameterError(f"`{name}` is {shown(self.measurement)}; a text is needed")
        if number(f"shown_scale of {self.name}", self.shown_scale) <= 0.0:
            raise ParameterError(
                f"`shown_scale of {self.name}` is {self.shown_scale:g}; above 0 is allowed"
            )
        self._set("integer", flag(f"integer of {self.name}", self.integer))
        if self.choices is not None:
            self._set("choices", choices_of(self.name, self.choices))
            if self.integer:
                raise ParameterError(
                    f"`integer of {self.name}` is True; it has `choices`, which say all"
                )
        lower, upper = self._bounds()
        if not (np.isfinite(lower) and np.isfinite(upper) and np.isfinite(upper - lower)):
            raise ParameterError(f"the bounds of `{self.name}` are too wide for numbers")
        if lower > upper:
            raise ParameterError(
                f"`lower of {self.name}` is {lower:g}, above its `upper`, {upper:g}"
            )
        if self.integer:
            lower, upper = whole_within(self.name, lower, upper)
        self._set("lower", lower)
        self._set("upper", upper)
        self._set("nominal", self._checked_nominal())
        self._check_distribution()

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    def _bounds(self) -> tuple[float, float]:
        """Return (lower, upper) from the one way in which they are given."""
        ways = (self.tolerance_percent, self.half_range, self.lower, self.choices)
        if sum(way is not None for way in ways) != 1 or (self.lower is None) != (
            self.upper is None
        ):
            raise ParameterError(
                f"the bounds of `{self.name}` are given in no way, or in several; one is needed: "
                "`tolerance_percent`, `half_range`, `lower` and `upper`, or `choices`"
            )
        if self.choices is not None:
            return self.choices[0], self.choices[-1]
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

    def _checked_nominal(self) -> float:
        """Return the nominal value, of an input with few values one of these."""
        middle = self.lower + 0.5 * (self.upper - self.lower)
        if not self.is_discrete:
            return middle if self.nominal is None else self.nominal
        allowed = np.array(self.allowed)
        if self.nominal is None:
            return float(allowed[np.argmin(np.abs(allowed - middle))])
        if self.nominal not in allowed:
            which = "a whole number between its bounds" if self.integer else "one of its choices"
            raise ParameterError(
                f"`nominal of {self.name}` is {self.nominal:g}; {which} is allowed"
            )
        return self.nominal

    def _check_distribution(self) -> None:
        """Check what belongs to the distribution, and fill in what is usual."""
        name = self.name
        self._set("distribution", choice(f"distribution of {name}", self.distribution, KINDS))
        kind = self.distribution
        self._refuse_of_discrete()
        if kind in WITH_DEVIATIONS:
            k = USUAL_DEVIATIONS if self.deviations is None else self.deviations
            self._set("deviations", k)
        self._refuse_unless("deviations", kind in WITH_DEVIATIONS, self.deviations)
        self._refuse_unless("mode", kind == "triangular", self.mode)
        if self.deviations is not None and self.deviations <= 0.0:
            raise ParameterError(
                f"`deviations of {name}` is {self.deviations:g}; above 0 is allowed"
            )
        if kind == "log-normal" and self.lower <= 0.0:
            raise ParameterError(
                f"`distribution of {name}` is 'log-normal' and its lower bound {self.lower:g}; "
                "above 0 is needed"
            )
        if self.quantile is not None and not 0.0 < self.quantile < 1.0:
            raise ParameterError(
                f"`quantile of {name}` is {self.quantile:g}; above 0 and below 1 is allowed"
            )
        self._check_order()

    def _refuse_of_discrete(self) -> None:
        for option in ("distribution", "quantile", "least", "most") if self.is_discrete else ():
            value = getattr(self, option)
            if value not in (None, "uniform"):
                raise ParameterError(
                    f"`{option} of {self.name}` is {value!r}; whole numbers and choices have none: "
                    "each is as likely as another"
                )

    def _refuse_unless(self, option: str, fits: bool, value: Any) -> None:
        if value is not None and not fits:
            raise ParameterError(
                f"`{option} of {self.name}` is {value:g}; a {self.distribution} distribution has "
                "none"
            )

    def _check_order(self) -> None:
        """Check that something is possible between the bounds, the peak of a triangle included."""
        lower, upper = self._possible
        if lower > upper or (lower == upper and self.lower < self.upper):
            raise ParameterError(
                f"`least` and `most` of {self.name} leave nothing between its bounds, "
                f"{self.lower:g} and {self.upper:g}"
            )
        if self.distribution != "triangular":
            return
        self._set("mode", self.nominal if self.mode is None else self.mode)
        if not lower <= self.mode <= upper:  # type: ignore[operator]  # it is set above
            raise ParameterError(
                f"`mode of {self.name}` is {self.mode:g}; a value from {lower:g} to {upper:g} is "
                "allowed"
            )

    @property
    def is_discrete(self) -> bool:
        """Whether only whole numbers or some choices are allowed."""
        return self.integer or self.choices is not None

    @property
    def allowed(self) -> tuple[float, ...] | None:
        """The values that are allowed, ascending; None where all between the bounds are."""
        if self.integer:
            return tuple(np.arange(self.lower, self.upper + 1.0).tolist())
        return self.choices

    @property
    def grid(self) -> Grid | None:
        """The allowed values where there are few, and more than one."""
        values = self.allowed
        return None if values is None or len(values) < 2 else Grid(np.array(values))

    @property
    def whole(self) -> bool:
        """Whether all its values are whole numbers, and are written so."""
        return self.integer or (
            self.choices is not None and all(v == np.floor(v) for v in self.choices)
        )

    @property
    def drawn(self) -> Distribution:
        """The distribution of its samples."""
        assert self.nominal is not None
        return Distribution(
            kind=self.distribution,
            lower=self.lower,
            upper=self.upper,
            mode=self.nominal if self.mode is None else self.mode,
            deviations=USUAL_DEVIATIONS if self.deviations is None else self.deviations,
            least=-np.inf if self.least is None else self.least,
            most=np.inf if self.most is None else self.most,
        )

    @property
    def box(self) -> tuple[float, float]:
        """Between which values a search looks: the bounds, or the ends of the quantile."""
        if self.quantile is None or self.lower == self.upper:
            return self._possible
        return self.drawn.interval(self.quantile)

    @property
    def _possible(self) -> tuple[float, float]:
        """The bounds, as far as they are possible."""
        return (
            self.lower if self.least is None else max(self.lower, self.least),
            self.upper if self.most is None else min(self.upper, self.most),
        )

    def with_quantile(self, quantile: float | None) -> Self:
        """Return the input with another `quantile`; whole numbers and choices stay as they are."""
        if self.is_discrete:
            return self
        as_stated = self.tolerance_percent is None and self.half_range is None
        ways = {} if as_stated else {"lower": None, "upper": None}
        return replace(self, quantile=quantile, **ways)  # type: ignore[arg-type]

    def with_distribution(self, kind: Kind, deviations: float | None = None) -> Self:
        """Return the input with samples drawn in another way; whole numbers and choices stay."""
        if self.is_discrete:
            return self
        as_stated = self.tolerance_percent is None and self.half_range is None
        ways: dict[str, Any] = {} if as_stated else {"lower": None, "upper": None}
        mode = self.mode if kind == "triangular" else None
        return replace(self, distribution=kind, deviations=deviations, mode=mode, **ways)

    def widened(self, factor: float) -> Self:
        """Return the input with bounds `factor` times as far from its nominal value.

        Of whole numbers and choices those stay, or of whole numbers come, that are within.
        """
        assert self.nominal is not None
        nominal, mode = self.nominal, self.mode
        ends = tuple(nominal + factor * (bound - nominal) for bound in (self.lower, self.upper))
        ways: dict[str, Any] = {"lower": ends[0], "upper": ends[1]}
        if self.choices is not None:
            within = tuple(v for v in self.choices if ends[0] <= v <= ends[1])
            ways = {"lower": None, "upper": None, "choices": within}
        if mode is not None:
            ways["mode"] = nominal + factor * (mode - nominal)
        return replace(self, tolerance_percent=None, half_range=None, **ways)

    @property
    def label(self) -> str:
        """The unit for tables and axes."""
        return self.unit if self.shown_unit is None else self.shown_unit

    def shown(self, value: float) -> float:
        """Return a value in the unit for tables and axes."""
        return value / self.shown_scale


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

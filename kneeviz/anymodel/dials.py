"""Inputs as sliders show them: in a unit with few digits, exact at the bounds and at home."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kneecore import Input, Model

_FEW = 10
"""Inputs that need no folders."""
_FOLDER = 8
_STEPS = 500
"""Steps of a slider, at least."""
_SMALL, _LARGE = 1e-2, 1e6
_RAISED = str.maketrans(
    "-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079"
)


@dataclass(frozen=True, kw_only=True)
class Dial:
    """How one input is shown and set; `low`, `high`, `home` and `step` in the unit shown."""

    index: int
    """Place among the model's inputs."""
    name: str
    unit: str
    scale: float
    """One of the unit shown, in the model's."""
    digits: int
    low: float
    high: float
    home: float
    lower: float
    upper: float
    nominal: float
    """Bounds and nominal value, in the model's unit, exact."""
    allowed: tuple[float, ...] | None = None
    """The only values, where these are few."""
    drawn: str = "uniform"
    """How samples are drawn, in words."""

    @property
    def step(self) -> float:
        """The slider's step."""
        return float(10.0**-self.digits)

    @property
    def even(self) -> bool:
        """Whether its values are a continuum, or equally far from one another."""
        return self.allowed is None or len(set(np.diff(self.allowed).round(12))) == 1

    @property
    def label(self) -> str:
        """Name and unit."""
        return f"{self.name} ({self.unit})" if self.unit else self.name

    def shown(self, value: float) -> float:
        """Return a value of the model's as the slider shows it."""
        rounded = round(value / self.scale, self.digits)
        return float(min(max(rounded, self.low), self.high))

    def value(self, shown: float) -> float:
        """Return the value that a slider's place stands for; its ends and home are exact."""
        if shown == self.home:
            return self.nominal
        if self.allowed is not None:
            return min(self.allowed, key=lambda value: abs(value - shown * self.scale))
        if shown <= self.low:
            return self.lower
        return self.upper if shown >= self.high else shown * self.scale

    def text(self, value: float) -> str:
        """Return a value of the model's with its unit."""
        return f"{value / self.scale:.{max(self.digits, 0)}f} {self.unit}".rstrip()


def _unit(one: Input) -> tuple[float, str]:
    """Return (scale, unit) such that numbers are neither tiny nor huge."""
    if one.allowed is not None:
        return one.shown_scale, one.label
    size = max(abs(one.lower), abs(one.upper)) / one.shown_scale
    if _SMALL <= size < _LARGE:
        return one.shown_scale, one.label
    power = 3 * int(np.floor(np.log10(size) / 3.0))
    ten = "10" + str(power).translate(_RAISED)
    return one.shown_scale * 10.0**power, f"{ten} {one.label}".rstrip()


def dial(index: int, one: Input) -> Dial:
    """Return how an input that varies is shown."""
    assert one.nominal is not None
    scale, unit = _unit(one)
    digits = 0
    if not one.integer:
        digits = int(np.ceil(-np.log10((one.upper - one.lower) / scale / _STEPS)))
    return Dial(
        index=index,
        name=one.name,
        unit=unit,
        scale=scale,
        digits=digits,
        low=round(one.lower / scale, digits),
        high=round(one.upper / scale, digits),
        home=round(one.nominal / scale, digits),
        lower=one.lower,
        upper=one.upper,
        nominal=one.nominal,
        allowed=one.allowed,
        drawn=one.drawn.words,
    )


def dials(model: Model) -> tuple[Dial, ...]:
    """Return the inputs of a model that vary."""
    return tuple(dial(i, one) for i, one in enumerate(model.inputs) if model.free[i])


def folders(all_: Sequence[Dial]) -> list[tuple[str, Sequence[Dial]]]:
    """Return dials in folders, (title, dials) each; a few stand without a folder, titled ''."""
    if len(all_) <= _FEW:
        return [("", all_)]
    parts = [all_[first : first + _FOLDER] for first in range(0, len(all_), _FOLDER)]
    return [(f"{p[0].name} to {p[-1].name}" if len(p) > 1 else p[0].name, p) for p in parts]

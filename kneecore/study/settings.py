"""How to study a model: the one list of each study's options."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from kneecore._arguments import number, shown
from kneecore.errors import ParameterError
from kneecore.numerics.sampling_options import Sampling, check_count, check_seed
from kneecore.options import check_choices, option

__all__ = [
    "AccuracyAllocationSettings",
    "BoundSweepSettings",
    "InfluenceSettings",
    "NeededAccuracySettings",
    "SamplingSettings",
    "SurrogateQualitySettings",
    "TrainingSweepSettings",
]


def _check_counts(settings: Any, *names: str) -> None:
    for name in names:
        object.__setattr__(settings, name, check_count(name, getattr(settings, name)))


def _check_seed(settings: Any) -> None:
    object.__setattr__(settings, "seed", check_seed(settings.seed))


def _row(argument: str, values: Any) -> tuple[Any, ...]:
    """Return a row of values as a tuple; a `ParameterError` if it is none or is empty."""
    if isinstance(values, str) or not isinstance(values, Sequence | np.ndarray):
        raise ParameterError(f"`{argument}` is {shown(values)}; a row of numbers is allowed")
    if len(values) == 0:
        raise ParameterError(f"`{argument}` is empty; at least one number is needed")
    return tuple(values)


def _size(argument: str, value: Any) -> float:
    size = number(argument, value)
    if size <= 0.0:
        raise ParameterError(f"`{argument}` is {size:g}; a number above 0 is allowed")
    return size


@dataclass(frozen=True, kw_only=True)
class SamplingSettings:
    """How to sample a model within its bounds.

    Raises
    ------
    ParameterError
        If a value is not allowed.
    """

    n_samples: int = option(10_000, key="samples")
    """Monte-Carlo samples; Sobol' sampling rounds up to a power of two."""
    sampling: Sampling = option("uniform")
    """How the samples are drawn."""
    seed: int = option(0)
    """The same seed gives the same result, on any number of threads."""

    def __post_init__(self) -> None:
        check_choices(self)
        _check_counts(self, "n_samples")
        _check_seed(self)


@dataclass(frozen=True, kw_only=True)
class InfluenceSettings:
    """How to find the inputs that decide.

    Raises
    ------
    ParameterError
        If a value is not allowed.
    """

    n_base: int = option(1024, key="base_samples")
    """Base rows of the indices, a power of two; the model is run for each free parameter and
    twice more."""
    intervals: bool = option(True)
    """Bootstrap 95 % intervals of the indices."""
    seed: int = option(0)
    """The same seed gives the same result, on any number of threads."""

    def __post_init__(self) -> None:
        _check_counts(self, "n_base")
        if not isinstance(self.intervals, bool):
            raise ParameterError(
                f"`intervals` is {shown(self.intervals)}; True or False is allowed"
            )
        _check_seed(self)


@dataclass(frozen=True, kw_only=True)
class BoundSweepSettings:
    """Which bounds to find the worst case for.

    Raises
    ------
    ParameterError
        If a value is not allowed.
    """

    sizes: tuple[float, ...] | None = option(None, key="bounds_mm", metavar="MM [MM ...]")
    """How wide the bounds are, in the model's measure: for knees the half-ranges of every length
    and coordinate, mm. Unset: the model's own, 0.25 to 2.5 mm for knees."""
    seed: int = option(0)
    """The same seed gives the same result, on any number of threads."""

    def __post_init__(self) -> None:
        if self.sizes is not None:
            object.__setattr__(
                self, "sizes", tuple(_size("sizes", s) for s in _row("sizes", self.sizes))
            )
        _check_seed(self)


@dataclass(frozen=True, kw_only=True)
class NeededAccuracySettings:
    """How good is good enough, and where to look for the bounds that give it.

    Raises
    ------
    ParameterError
        If a value is not allowed.
    """

    within: float | None = option(None, key="within_deg", metavar="FLOAT")
    """Largest value of the watched output that is good enough: for knees the flexion that may be
    left at +5 N m, deg. Unset: the model's own, 5 deg for knees."""
    largest: float | None = option(None, key="largest_mm", metavar="MM")
    """Widest bounds to look at. Unset: the widest that the model's sweeps go through, 2.5 mm for
    knees."""
    tolerance: float = option(0.005, key="tolerance_mm", metavar="MM")
    """How closely the answer is bracketed."""
    seed: int = option(0)
    """The same seed gives the same result, on any number of threads."""

    def __post_init__(self) -> None:
        if self.within is not None:
            object.__setattr__(self, "within", number("within", self.within))
        if self.largest is not None:
            object.__setattr__(self, "largest", _size("largest", self.largest))
        object.__setattr__(self, "tolerance", _size("tolerance", self.tolerance))
        _check_seed(self)


@dataclass(frozen=True, kw_only=True)
class AccuracyAllocationSettings:
    """How good is good enough, and what accuracy costs.

    Raises
    ------
    ParameterError
        If a value is not allowed.
    """

    within: float | None = option(None, key="within_deg", metavar="FLOAT")
    """Largest value of the watched output that is good enough: for knees the flexion that may be
    left at +5 N m, deg. Unset: the model's own, 5 deg for knees."""
    costs: dict[str, float] | None = option(None, metavar="NAME NUMBER [NAME NUMBER ...]")
    """What a measurement costs that is as good as its stated bound, by name, such as acl_femur 2;
    half the tolerance costs twice as much. Unset ones: 1."""
    tolerance: float = option(0.005, key="tolerance_mm", metavar="MM")
    """How closely the one tolerance for all is bracketed."""
    seed: int = option(0)
    """The same seed gives the same result, on any number of threads."""

    def __post_init__(self) -> None:
        if self.within is not None:
            object.__setattr__(self, "within", number("within", self.within))
        if self.costs is not None:
            object.__setattr__(self, "costs", _costs(self.costs))
        object.__setattr__(self, "tolerance", _size("tolerance", self.tolerance))
        _check_seed(self)
        check_seed(self.seed + 3)  # those of the checks


def _costs(given: Any) -> dict[str, float]:
    if not isinstance(given, Mapping) or not all(isinstance(name, str) for name in given):
        raise ParameterError(f"`costs` is {shown(given)}; a mapping of names to numbers is allowed")
    return {name: _size(f"costs[{name!r}]", cost) for name, cost in given.items()}


@dataclass(frozen=True, kw_only=True)
class TrainingSweepSettings:
    """Which numbers of training runs to compare.

    Raises
    ------
    ParameterError
        If a value is not allowed.
    """

    sizes: tuple[int, ...] = option((30, 40, 50, 75, 100, 150, 200, 300, 400))
    """Training samples; at least one more than free parameters."""
    n_seeds: int = option(5, key="seeds")
    """Repetitions with other training samples."""
    method: Literal["ga", "exact"] = option("ga")
    """How each surrogate is searched: the paper's main run, or exactly."""
    seed: int = option(0)
    """The same seed gives the same result, on any number of threads."""

    def __post_init__(self) -> None:
        check_choices(self)
        sizes = tuple(check_count("sizes", s) for s in _row("sizes", self.sizes))
        object.__setattr__(self, "sizes", sizes)
        _check_counts(self, "n_seeds")
        _check_seed(self)
        check_seed(self.seed + self.n_seeds - 1)


@dataclass(frozen=True, kw_only=True)
class SurrogateQualitySettings:
    """How to judge a model's surrogate.

    Raises
    ------
    ParameterError
        If a value is not allowed.
    """

    training_samples: int = option(50)
    """Model runs that the surrogate is fitted to; at least one more than free parameters."""
    n_test: int = option(1000, key="test_points")
    """Model runs, new to the surrogate, that it is held against; at least 4."""
    seed: int = option(0)
    """The same seed gives the same result, on any number of threads."""

    def __post_init__(self) -> None:
        _check_counts(self, "training_samples", "n_test")
        if self.n_test < 4:
            raise ParameterError(f"`n_test` is {self.n_test}; at least 4 are needed to rank pairs")
        _check_seed(self)

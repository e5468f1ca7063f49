"""The space that the uncertainty of the parameters spans: a box around a knee.

Examples
--------
>>> from kneecore import ParameterSpace
>>> space = ParameterSpace(case="geometry", geometry_bound_mm=0.5)
>>> space.n_free
22
>>> width = space.upper - space.lower
>>> round(1e3 * float(width[space.names.index("condyle_radius")]), 6)  # mm
1.0
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, Self, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._arguments import choice, number, one_line, shown, shown_name, text
from kneecore._arrays import numbers
from kneecore.errors import ParameterError
from kneecore.knee.file import LONGEST_TEXT, dump_knee, packaged_knee, read_knee
from kneecore.knee.likely import POISSON_LIMIT, KneeDistribution, Likely, inputs_of
from kneecore.knee.parameters import (
    ALL_NAMES,
    N_PARAMETERS,
    NAMES,
    REST_LENGTH_NAMES,
    STRUCTURE,
    check_physical,
    named_half_ranges,
    widened,
)
from kneecore.knee.physics.pose import constants, rest_lengths

__all__ = ["CASES", "Around", "Case", "ParameterSpace", "check_space"]

Case = Literal["both", "geometry", "material"]
Around = Literal["baseline", "current"]
CASES: tuple[Case, ...] = get_args(Case)

FloatArray = NDArray[np.float64]

_IS_GEOMETRY = np.array([row[2] == "geometry" for row in STRUCTURE])
_IS_MATERIAL = np.array([row[2] == "material" for row in STRUCTURE])
_IS_SLOPE = np.array([name == "plateau_slope" for name in ALL_NAMES])
_CHANGES = slice(N_PARAMETERS, len(ALL_NAMES))
_POISSON = NAMES.index("poissons_ratio")


def _one_knee(name: str, values: ArrayLike) -> FloatArray:
    knee = check_physical(values, name)
    if knee.ndim != 1:
        raise ParameterError(f"`{name}` has shape {knee.shape}; (28,) is allowed")
    return knee


def _with_last_axis(name: str, values: ArrayLike, size: int) -> FloatArray:
    array = numbers(name, values)
    if array.ndim == 0 or array.shape[-1] != size:
        raise ParameterError(f"`{name}` has shape {array.shape}; (..., {size}) is allowed")
    return array


def _held(array: NDArray[Any]) -> NDArray[Any]:
    """Return a copy that nobody can change."""
    own = array.copy()  # the caller's, and the centre is often the baseline
    own.setflags(write=False)
    return own


@dataclass(frozen=True, eq=False)
class ParameterSpace:
    """The box of knees that the uncertainty allows.

    Raises
    ------
    ParameterError
        If a bound is negative or not finite, if the baseline or a bound is not a possible knee, or
        if nothing is free to vary.
    """

    case: Case = "both"
    """Which parameters vary: `both`, only the `geometry` or only the `material` (the four
    stiffnesses, E and nu). The others are held at the centre."""
    geometry_bound_mm: float = 1.0
    """Half-range of every length and coordinate, mm."""
    slope_bound_deg: float = 1.0
    """Half-range of the plateau's slope, deg."""
    material_bound_percent: float = 10.0
    """Half-range of every material parameter, per cent of its value at the centre."""
    rest_length_bound_mm: float = 0.0
    """Half-range of every ligament's rest length, mm. Above 0 the four rest lengths are uncertain
    parameters too, in every case: the space has 32 dimensions."""
    rest_length_bound_percent: float = 0.0
    """The same in per cent of the centre's rest lengths; one of the two is given."""
    half_ranges: Mapping[str, float] | None = None
    """Half-ranges (SI) by parameter name; they take the place of the bounds above."""
    baseline: FloatArray = None  # type: ignore[assignment]
    """Baseline knee, shape (28,), SI; the packaged one if not given. (32,) with changes of the rest
    lengths."""
    title: str = "Packaged baseline"
    """Name of the baseline, for reports."""
    note: str | None = None
    """What a reader of results must know about the baseline; the packaged one's for None."""
    distribution: KneeDistribution = "uniform"
    """How samples are drawn: uniform within the bounds; normal, with its mean in their middle and
    them `deviations` standard deviations away; truncated-normal, cut off at the bounds; or
    triangular, with its peak at the centre."""
    deviations: float | None = None
    """How many standard deviations the half-ranges are; 3 if not given."""
    quantile: float | None = None
    """Share of each distribution, in its middle, that a search looks at in the place of what is
    within the bounds."""
    sources: tuple[str, ...] | None = None
    """Where each baseline value is from; the packaged ones for the packaged baseline."""
    centre: FloatArray = None  # type: ignore[assignment]
    """The knee in the middle of the box, shape as the baseline's, SI; the baseline if not given. It
    is still the baseline that fixes the load-free pose."""

    lower: FloatArray = field(init=False, repr=False)
    """Lower bounds of a search, shape (28,) or (32,), SI."""
    upper: FloatArray = field(init=False, repr=False)
    """Upper bounds, same shape, SI; Poisson's ratio is clipped to 0.499."""
    stated: tuple[FloatArray, FloatArray] = field(init=False, repr=False)
    """The bounds as stated, from which they differ where there is a `quantile`."""
    free: NDArray[np.bool_] = field(init=False, repr=False)
    """Which parameters vary, same shape."""

    def __post_init__(self) -> None:
        choice("case", self.case, CASES, f"{', '.join(CASES)} are allowed")
        self._check_bounds()
        for name, value in self.likely.checked()._asdict().items():
            object.__setattr__(self, name, value)
        self._check_texts()
        packaged = packaged_knee()
        given = packaged.baseline if self.baseline is None else self.baseline
        baseline = _one_knee("baseline", given)
        centre = baseline if self.centre is None else _one_knee("centre", self.centre)
        if self._has_rest_lengths(baseline) or self._has_rest_lengths(centre):
            baseline, centre = (widened(x, len(ALL_NAMES)) for x in (baseline, centre))
        with np.errstate(over="ignore"):  # a bound of 10^308 is found out below
            half = self._half_ranges_of(centre)
        half[~self._varies()[: len(centre)]] = 0.0
        lower, upper = centre - half, centre + half
        if upper[_POISSON] > POISSON_LIMIT and half[_POISSON] > 0.0:
            upper[_POISSON] = max(POISSON_LIMIT, centre[_POISSON])
        self._check_possible(centre, lower, upper)
        stated = lower, upper
        if self.quantile is not None:
            inputs = inputs_of(baseline, centre, lower, upper, self.likely)
            lower, upper = (np.array([one.box[side] for one in inputs]) for side in (0, 1))
            self._check_possible(centre, lower, upper)
        free = upper > lower
        if not free.any():
            raise ParameterError(
                f"all bounds of case {self.case!r} have zero width; at least one above 0 is needed"
            )
        if self.baseline is None:
            kept = {"note": packaged.note, "sources": packaged.sources}
            for name, value in kept.items():
                if getattr(self, name) is None:
                    object.__setattr__(self, name, value)
        held = {"baseline": baseline, "centre": centre, "lower": lower, "upper": upper}
        for name, array in (*held.items(), ("free", free)):
            object.__setattr__(self, name, _held(array))
        object.__setattr__(self, "stated", tuple(map(_held, stated)))

    @property
    def likely(self) -> Likely:
        """How likely its knees are."""
        return Likely(self.distribution, self.deviations, self.quantile)

    def _check_possible(self, centre: FloatArray, lower: FloatArray, upper: FloatArray) -> None:
        for name, bound in (("lower", lower), ("upper", upper)):
            try:
                check_physical(bound, f"{name} bound")
                if len(bound) > N_PARAMETERS:
                    self._rest_lengths(np.concatenate([centre[:N_PARAMETERS], bound[_CHANGES]]))
            except ParameterError as error:
                raise ParameterError(f"the bounds are too wide: {error}") from None

    def _varies(self) -> NDArray[np.bool_]:
        held = {"both": None, "geometry": _IS_MATERIAL, "material": _IS_GEOMETRY}[self.case]
        return np.ones(len(ALL_NAMES), dtype=bool) if held is None else ~held

    def _has_rest_lengths(self, centre: FloatArray) -> bool:
        return (
            max(self.rest_length_bound_mm, self.rest_length_bound_percent) > 0.0
            or any(name in REST_LENGTH_NAMES for name in self.half_ranges or {})
            or len(centre) > N_PARAMETERS
        )

    def _half_ranges_of(self, centre: FloatArray) -> FloatArray:
        n = len(centre)
        length = 1e-3 * self.geometry_bound_mm
        share = 0.01 * self.material_bound_percent
        half = np.where(_IS_GEOMETRY[:n], length, share * np.abs(centre))
        half[_IS_SLOPE[:n]] = np.deg2rad(self.slope_bound_deg)
        if n > N_PARAMETERS:
            half[_CHANGES] = 1e-3 * self.rest_length_bound_mm
            if self.rest_length_bound_percent > 0.0:
                half[_CHANGES] = 0.01 * self.rest_length_bound_percent * self._rest_lengths(centre)
        for name, value in (self.half_ranges or {}).items():
            half[ALL_NAMES.index(name)] = value
        return half

    @staticmethod
    def _rest_lengths(x: FloatArray) -> FloatArray:
        lengths: FloatArray = rest_lengths(constants(x[None], x, False))[0]
        return lengths

    def _check_bounds(self) -> None:
        """Check the bounds that were given, and keep them as plain floats."""
        for name, unit in (
            ("geometry_bound_mm", "mm"),
            ("slope_bound_deg", "deg"),
            ("material_bound_percent", "%"),
            ("rest_length_bound_mm", "mm"),
            ("rest_length_bound_percent", "%"),
        ):
            object.__setattr__(self, name, number(name, getattr(self, name), unit=unit, least=0.0))
        if self.slope_bound_deg >= 90.0:
            raise ParameterError(
                f"`slope_bound_deg` is {self.slope_bound_deg:g} deg; less than 90 is allowed"
            )
        if self.rest_length_bound_mm > 0.0 and self.rest_length_bound_percent > 0.0:
            raise ParameterError(
                f"`rest_length_bound_mm` is {self.rest_length_bound_mm:g} mm and "
                f"`rest_length_bound_percent` is {self.rest_length_bound_percent:g} %; "
                "one of the two is allowed"
            )
        if self.half_ranges is None:
            return
        kept = named_half_ranges(self.half_ranges)
        object.__setattr__(self, "half_ranges", kept)

    def _check_texts(self) -> None:
        object.__setattr__(self, "title", one_line("title", self.title, LONGEST_TEXT))
        if self.note is not None:
            text("note", self.note, LONGEST_TEXT)
        if self.sources is None:
            return
        if not isinstance(self.sources, tuple | list):
            raise ParameterError(f"`sources` is {shown(self.sources)}; texts are allowed")
        for i, source in enumerate(self.sources):
            text(f"sources[{i}]", source, LONGEST_TEXT)

    @classmethod
    def from_file(
        cls,
        path: str | Path,
        *,
        case: Case = "both",
        around: Around = "baseline",
        geometry_bound_mm: float | None = None,
        slope_bound_deg: float | None = None,
        material_bound_percent: float | None = None,
        rest_length_bound_mm: float | None = None,
        rest_length_bound_percent: float | None = None,
        distribution: KneeDistribution | None = None,
        deviations: float | None = None,
        quantile: float | None = None,
    ) -> Self:
        """Return the space of a knee file; what is given takes the place of the file's.

        `around` chooses the box's centre: the file's baseline or its current knee.

        Raises
        ------
        FileFormatError
            If the file cannot be read as a knee.
        ParameterError
            As for the class, or if the file has no current knee to be around.
        """
        choice("around", around, get_args(Around))
        knee = read_knee(path)
        centre = knee.baseline if around == "baseline" else knee.current
        if centre is None:
            raise ParameterError(
                f"`around` is 'current', and {shown_name(str(path))} has no [current] knee; "
                "'baseline' is allowed"
            )
        own = Likely(knee.distribution, knee.deviations)
        in_mm, in_percent = rest_length_bound_mm, rest_length_bound_percent
        given = {
            "geometry": geometry_bound_mm,
            "material": material_bound_percent,
            "rest length": in_percent if in_mm is None else in_mm,
        }
        kept = {}
        for row, half in zip(STRUCTURE, knee.half_ranges.tolist(), strict=False):
            bound = slope_bound_deg if row[0] == "plateau_slope" else given[row[2]]
            if bound is None:
                kept[row[0]] = half
        return cls(
            case=case,
            geometry_bound_mm=1.0 if geometry_bound_mm is None else geometry_bound_mm,
            slope_bound_deg=1.0 if slope_bound_deg is None else slope_bound_deg,
            material_bound_percent=10.0
            if material_bound_percent is None
            else material_bound_percent,
            rest_length_bound_mm=0.0 if in_mm is None else in_mm,
            rest_length_bound_percent=0.0 if in_percent is None else in_percent,
            half_ranges=kept,
            baseline=knee.baseline,
            title=knee.title,
            note=knee.note,
            **own.but(distribution, deviations, quantile)._asdict(),
            sources=knee.sources,
            centre=centre,
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the 28 (or 32) parameters, in the order of every vector."""
        return ALL_NAMES[: len(self.lower)]

    @property
    def n_free(self) -> int:
        """Number of parameters that vary."""
        return int(np.count_nonzero(self.free))

    def to_unit(self, x: ArrayLike) -> FloatArray:
        """Map SI values, shape (..., 28), to the unit cube; parameters that are held map to 0.5.

        In a space of 32 dimensions, knees of 28 entries have unchanged rest lengths.
        """
        values = numbers("x", x)
        if values.ndim > 0 and values.shape[-1] in (N_PARAMETERS, len(ALL_NAMES)):
            values = widened(values, len(self.lower))
        values = _with_last_axis("x", values, len(self.lower))
        width = np.where(self.free, self.upper - self.lower, 1.0)
        with np.errstate(over="ignore"):
            return np.where(self.free, (values - self.lower) / width, 0.5)

    def from_unit(self, u: ArrayLike) -> FloatArray:
        """Map points of the unit cube, shape (..., 28), to SI values within the bounds."""
        unit = _with_last_axis("u", u, len(self.lower))
        with np.errstate(over="ignore"):
            values = self.lower + unit * (self.upper - self.lower)
        return np.clip(values, self.lower, self.upper)

    def from_free_unit(self, u: ArrayLike) -> FloatArray:
        """Map points of the free parameters' unit cube, shape (..., n_free), to SI, (..., 28)."""
        unit = _with_last_axis("u", u, self.n_free)
        full = np.full((*unit.shape[:-1], len(self.lower)), 0.5)
        full[..., self.free] = unit
        return self.from_unit(full)

    def at_bounds(self, x: ArrayLike, *, tolerance: float = 1e-3) -> NDArray[np.int8]:
        """Tell which values lie on a bound: -1 lower, +1 upper, 0 neither (or held).

        `tolerance` is a share of the parameter's range.
        """
        share = number("tolerance", tolerance, least=0.0, most=0.5)
        unit = self.to_unit(x)
        side = np.where(unit <= share, -1, np.where(unit >= 1.0 - share, 1, 0))
        return np.where(self.free, side, 0).astype(np.int8)

    @property
    def is_around_baseline(self) -> bool:
        """Whether the box is that around the baseline."""
        return bool(np.array_equal(self.centre, self.baseline))

    def to_toml(self, current: ArrayLike | None = None) -> str:
        """Return this space as a knee file, with `current` (28,) as its current knee.

        Without one, the centre is the current knee where it is not the baseline.
        """
        if current is None and not self.is_around_baseline:
            current = self.centre
        return dump_knee(
            baseline=self.baseline,
            half_ranges=self._half_ranges_of(self.centre),
            sources=self.sources,
            current=current,
            title=self.title,
            note=self.note,
            distribution=self.distribution,
            deviations=self.deviations,
        )


def check_space(space: ParameterSpace, name: str = "space") -> ParameterSpace:
    """Return `space`, which is a `ParameterSpace`.

    Raises
    ------
    ParameterError
        If it is anything else.
    """
    if isinstance(space, ParameterSpace):
        return space
    raise ParameterError(f"`{name}` is {shown(space)}; a ParameterSpace is allowed")

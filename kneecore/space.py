"""The space that the uncertainty of the parameters spans: a box around the baseline knee.

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
from numbers import Real
from pathlib import Path
from typing import Literal, Self, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore.errors import ParameterError
from kneecore.knee_file import dump_knee, packaged_knee, read_knee
from kneecore.parameters import N_PARAMETERS, NAMES, STRUCTURE, check_physical

__all__ = ["CASES", "POISSON_LIMIT", "Case", "ParameterSpace"]

Case = Literal["both", "geometry", "material"]
CASES: tuple[Case, ...] = get_args(Case)
POISSON_LIMIT = 0.499
"""Upper bound of Poisson's ratio: at 0.5 the material is incompressible."""

FloatArray = NDArray[np.float64]

_IS_GEOMETRY = np.array([row[2] == "geometry" for row in STRUCTURE])
_IS_SLOPE = np.array([name == "plateau_slope" for name in NAMES])
_POISSON = NAMES.index("poissons_ratio")


def _checked_bound(name: str, value: float, unit: str) -> float:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ParameterError(f"`{name}` is {value!r}; a number in {unit} of at least 0 is allowed")
    number = float(value)
    if not (np.isfinite(number) and number >= 0.0):
        raise ParameterError(
            f"`{name}` is {number:g} {unit}; a finite number of at least 0 is allowed"
        )
    return number


def _with_last_axis(name: str, values: ArrayLike, size: int) -> FloatArray:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != size:
        raise ParameterError(f"`{name}` has shape {array.shape}; (..., {size}) is allowed")
    return array


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
    stiffnesses, E and nu). The others are held at the baseline."""
    geometry_bound_mm: float = 1.0
    """Half-range of every length and coordinate, mm."""
    slope_bound_deg: float = 1.0
    """Half-range of the plateau's slope, deg."""
    material_bound_percent: float = 10.0
    """Half-range of every material parameter, per cent of its baseline."""
    half_ranges: Mapping[str, float] | None = None
    """Half-ranges (SI) by parameter name; they take the place of the three bounds above."""
    baseline: FloatArray = None  # type: ignore[assignment]
    """Baseline knee, shape (28,), SI; the packaged one if not given."""
    title: str = "Packaged baseline"
    """Name of the baseline, for reports."""
    note: str | None = None
    """What a reader of results must know about the baseline; the packaged one's for None."""
    sources: tuple[str, ...] | None = None
    """Where each baseline value is from; the packaged ones for the packaged baseline."""

    lower: FloatArray = field(init=False, repr=False)
    """Lower bounds, shape (28,), SI."""
    upper: FloatArray = field(init=False, repr=False)
    """Upper bounds, shape (28,), SI; Poisson's ratio is clipped to 0.499."""
    free: NDArray[np.bool_] = field(init=False, repr=False)
    """Which parameters vary, shape (28,)."""

    def __post_init__(self) -> None:
        if self.case not in CASES:
            raise ParameterError(f"`case` is {self.case!r}; {', '.join(CASES)} are allowed")
        self._check_bounds()
        packaged = packaged_knee()
        given = packaged.baseline if self.baseline is None else self.baseline
        centre = check_physical(given, "baseline")
        if centre.ndim != 1:
            raise ParameterError(f"`baseline` has shape {centre.shape}; (28,) is allowed")
        half = self._half_ranges_of(centre)
        half[~self._varies()] = 0.0
        lower, upper = centre - half, centre + half
        if upper[_POISSON] > POISSON_LIMIT and half[_POISSON] > 0.0:
            upper[_POISSON] = max(POISSON_LIMIT, centre[_POISSON])
        for name, bound in (("lower", lower), ("upper", upper)):
            try:
                check_physical(bound, f"{name} bound")
            except ParameterError as error:
                raise ParameterError(f"the bounds are too wide: {error}") from None
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
        for name, array in (
            ("baseline", centre),
            ("lower", lower),
            ("upper", upper),
            ("free", free),
        ):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def _varies(self) -> NDArray[np.bool_]:
        if self.case == "both":
            return np.ones(N_PARAMETERS, dtype=bool)
        return _IS_GEOMETRY if self.case == "geometry" else ~_IS_GEOMETRY

    def _half_ranges_of(self, centre: FloatArray) -> FloatArray:
        length = 1e-3 * self.geometry_bound_mm
        slope = np.deg2rad(self.slope_bound_deg)
        share = 0.01 * self.material_bound_percent
        half = np.where(_IS_GEOMETRY, length, share * np.abs(centre))
        half[_IS_SLOPE] = slope
        for name, value in (self.half_ranges or {}).items():
            half[NAMES.index(name)] = value
        return half

    def _check_bounds(self) -> None:
        """Check the bounds that were given, and keep them as plain floats."""
        for name, unit in (
            ("geometry_bound_mm", "mm"),
            ("slope_bound_deg", "deg"),
            ("material_bound_percent", "%"),
        ):
            object.__setattr__(self, name, _checked_bound(name, getattr(self, name), unit))
        if self.slope_bound_deg >= 90.0:
            raise ParameterError(
                f"`slope_bound_deg` is {self.slope_bound_deg:g} deg; less than 90 is allowed"
            )
        if self.half_ranges is None:
            return
        if not isinstance(self.half_ranges, Mapping):
            raise ParameterError(
                f"`half_ranges` is {self.half_ranges!r}; a mapping of names to numbers is allowed"
            )
        kept = {}
        for name, value in self.half_ranges.items():
            if name not in NAMES:
                raise ParameterError(
                    f"`half_ranges` names {name!r}; allowed are the parameters' names, "
                    f"{NAMES[0]} to {NAMES[-1]}"
                )
            kept[name] = _checked_bound(f"half_ranges[{name!r}]", value, "(SI)")
        object.__setattr__(self, "half_ranges", kept)

    @classmethod
    def from_file(
        cls,
        path: str | Path,
        *,
        case: Case = "both",
        geometry_bound_mm: float | None = None,
        slope_bound_deg: float | None = None,
        material_bound_percent: float | None = None,
    ) -> Self:
        """Return the space of a knee file; a bound that is given takes the place of the file's.

        Raises
        ------
        FileFormatError
            If the file cannot be read as a knee.
        ParameterError
            As for the class.
        """
        knee = read_knee(path)
        kept = dict(zip(NAMES, knee.half_ranges.tolist(), strict=True))
        for name, is_geometry in zip(NAMES, _IS_GEOMETRY, strict=True):
            if name == "plateau_slope":
                given = slope_bound_deg
            else:
                given = geometry_bound_mm if is_geometry else material_bound_percent
            if given is not None:
                del kept[name]
        return cls(
            case=case,
            geometry_bound_mm=1.0 if geometry_bound_mm is None else geometry_bound_mm,
            slope_bound_deg=1.0 if slope_bound_deg is None else slope_bound_deg,
            material_bound_percent=10.0
            if material_bound_percent is None
            else material_bound_percent,
            half_ranges=kept,
            baseline=knee.baseline,
            title=knee.title,
            note=knee.note,
            sources=knee.sources,
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the 28 parameters, in the order of every vector."""
        return NAMES

    @property
    def n_free(self) -> int:
        """Number of parameters that vary."""
        return int(np.count_nonzero(self.free))

    def to_unit(self, x: ArrayLike) -> FloatArray:
        """Map SI values, shape (..., 28), to the unit cube; parameters that are held map to 0.5."""
        values = _with_last_axis("x", x, N_PARAMETERS)
        width = np.where(self.free, self.upper - self.lower, 1.0)
        return np.where(self.free, (values - self.lower) / width, 0.5)

    def from_unit(self, u: ArrayLike) -> FloatArray:
        """Map points of the unit cube, shape (..., 28), to SI values within the bounds."""
        unit = _with_last_axis("u", u, N_PARAMETERS)
        values = self.lower + unit * (self.upper - self.lower)
        return np.clip(values, self.lower, self.upper)

    def from_free_unit(self, u: ArrayLike) -> FloatArray:
        """Map points of the free parameters' unit cube, shape (..., n_free), to SI, (..., 28)."""
        unit = _with_last_axis("u", u, self.n_free)
        full = np.full((*unit.shape[:-1], N_PARAMETERS), 0.5)
        full[..., self.free] = unit
        return self.from_unit(full)

    def at_bounds(self, x: ArrayLike, *, tolerance: float = 1e-3) -> NDArray[np.int8]:
        """Tell which values lie on a bound: -1 lower, +1 upper, 0 neither (or held).

        `tolerance` is a share of the parameter's range.
        """
        unit = self.to_unit(x)
        side = np.where(unit <= tolerance, -1, np.where(unit >= 1.0 - tolerance, 1, 0))
        return np.where(self.free, side, 0).astype(np.int8)

    def to_toml(self, current: ArrayLike | None = None) -> str:
        """Return this space as a knee file's text, with `current` (28,) as its current knee."""
        return dump_knee(
            baseline=self.baseline,
            half_ranges=self._half_ranges_of(self.baseline),
            sources=self.sources,
            current=current,
            title=self.title,
            note=self.note,
        )

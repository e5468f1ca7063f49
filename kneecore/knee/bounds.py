"""Bounds of a space of knees, changed or told."""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ParameterError
from kneecore.knee.parameters import STRUCTURE, widened
from kneecore.knee.space import ParameterSpace
from kneecore.knee.units import si_factor
from kneecore.numbers import DIGITS

__all__ = [
    "half_ranges",
    "measurement_of",
    "needs_file",
    "stated_tolerance",
    "with_geometry_bound",
    "with_narrower",
]

FloatArray = NDArray[np.float64]

_GEOMETRIC = frozenset(row[0] for row in STRUCTURE if row[2] == "geometry")


def with_geometry_bound(space: ParameterSpace, bound_mm: float) -> ParameterSpace:
    """Return `space` with another bound on the geometry.

    The slope's bound changes in proportion; half-ranges by name of geometric parameters make way.
    The material's and the rest lengths' bounds stay.
    """
    if not space.geometry_bound_mm > 0.0:
        raise ParameterError(
            f"`geometry_bound_mm` is {space.geometry_bound_mm:g} mm; above 0 is needed to vary it"
        )
    if space.case == "material":
        raise ParameterError("`case` is 'material'; 'both' or 'geometry' varies the geometry")
    kept = {
        name: half for name, half in (space.half_ranges or {}).items() if name not in _GEOMETRIC
    }
    return dataclasses.replace(
        space,
        geometry_bound_mm=bound_mm,
        slope_bound_deg=space.slope_bound_deg * bound_mm / space.geometry_bound_mm,
        half_ranges=kept or None,
    )


def half_ranges(space: ParameterSpace) -> FloatArray:
    """Return the half-range of each parameter, SI; that of Poisson's ratio before it is clipped."""
    lower, upper = space.stated
    wider: FloatArray = np.maximum(upper - space.centre, space.centre - lower)
    return wider


def with_narrower(space: ParameterSpace, factors: FloatArray) -> ParameterSpace:
    """Return `space` with each half-range times its factor."""
    narrower = dict(zip(space.names, (factors * half_ranges(space)).tolist(), strict=True))
    return dataclasses.replace(space, half_ranges=narrower)


def measurement_of(name: str) -> str:
    """Return what a parameter is measured with: the two coordinates of a point are one."""
    point = name.removesuffix("_x").removesuffix("_y")
    return {"condyle": "condyle_centre", "plateau": "plateau_point"}.get(point, point)


def stated_tolerance(space: ParameterSpace, name: str) -> tuple[float, str]:
    """Return a half-range and its unit: of geometry in mm or deg, of material in per cent."""
    k = space.names.index(name)
    half, row = float(half_ranges(space)[k]), STRUCTURE[k]
    if row[2] == "material":
        return round(100.0 * half / abs(float(space.centre[k])), DIGITS), "%"
    return round(half / si_factor(row[3]), DIGITS), row[3]  # the bounds' own rounding is in it


def needs_file(space: ParameterSpace) -> bool:
    """Tell whether a space can only be given as a knee file."""
    packaged = ParameterSpace()
    own = not np.array_equal(space.baseline, widened(packaged.baseline, len(space.baseline)))
    return (
        own
        or not space.is_around_baseline
        or space.half_ranges is not None
        or space.title != packaged.title
    )

"""Bounds of a space of knees, changed or told."""

import dataclasses

import numpy as np

from kneecore.errors import ParameterError
from kneecore.knee.parameters import STRUCTURE, widened
from kneecore.knee.space import ParameterSpace

__all__ = ["needs_file", "with_geometry_bound"]

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

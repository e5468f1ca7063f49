"""How far the parameters may be from the baseline, and the parameters' order, kinds and units."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kneecore import NAMES, KneeFile, ParameterSpace, packaged_knee, parameter_table
from kneecore.knee.parameters import widened
from kneecore.knee.space import Case

RestLength = Any  # kneecore's literal: "recomputed" or "fixed"

_TABLE = parameter_table(rest_lengths=True)
WIDTH = len(_TABLE)
"""Entries of the visitor's knee: the changes of its rest lengths are always among them."""
GEOMETRY = np.array([row.kind == "geometry" for row in _TABLE[: len(NAMES)]])
SLOPE = np.array([row.name == "plateau_slope" for row in _TABLE[: len(NAMES)]])
SCALE = np.array([row.scale for row in _TABLE])


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """How far the parameters may be from the baseline. None keeps the knee file's half-ranges."""

    case: Case = "both"
    geometry_mm: float | None = None
    slope_deg: float | None = None
    material_percent: float | None = None
    rest_length_mm: float | None = None
    rest_length: RestLength = "recomputed"

    def space(self, knee: KneeFile) -> ParameterSpace:
        """Return the space around a knee file's baseline."""
        given = (self.geometry_mm, self.slope_deg, self.material_percent, self.rest_length_mm)
        geometry, slope, material, rest = (
            default if value is None else value
            for value, default in zip(given, (1.0, 1.0, 10.0, 0.0), strict=True)
        )
        if knee is packaged_knee():  # then no file is needed to name the space
            return ParameterSpace(
                case=self.case,
                geometry_bound_mm=geometry,
                slope_bound_deg=slope,
                material_bound_percent=material,
                rest_length_bound_mm=rest,
            )
        kept = {
            row.name: float(half)
            for i, (row, half) in enumerate(zip(_TABLE, knee.half_ranges, strict=False))
            if given[_bound_of(i)] is None
        }
        return ParameterSpace(
            case=self.case,
            geometry_bound_mm=geometry,
            slope_bound_deg=slope,
            material_bound_percent=material,
            rest_length_bound_mm=rest,
            half_ranges=kept,
            baseline=knee.baseline,
            title=knee.title,
            note=knee.note,
            distribution=knee.distribution,
            deviations=knee.deviations,
            sources=knee.sources,
        )


def _bound_of(index: int) -> int:
    if index >= len(NAMES):
        return 3
    if not GEOMETRY[index]:
        return 2
    return 1 if SLOPE[index] else 0


def shown_bounds(knee: KneeFile) -> tuple[float, float, float, float]:
    """Return the largest half-ranges of a knee file: (mm, deg, % of the value, mm at rest)."""
    all_halves = widened(knee.half_ranges, WIDTH)
    half, rest = all_halves[: len(NAMES)], all_halves[len(NAMES) :]
    size = np.maximum(np.abs(knee.baseline[: len(NAMES)]), 1e-30)
    length = GEOMETRY & ~SLOPE
    return (
        float(1e3 * half[length].max()),
        float(np.degrees(half[SLOPE].max())),
        float(100.0 * (half / size)[~GEOMETRY].max()),
        float(1e3 * rest.max()),
    )


def with_bound(bounds: Bounds, name: str, value: Any) -> Bounds:
    """Return `bounds` with one of its fields replaced."""
    return replace(bounds, **{name: value})

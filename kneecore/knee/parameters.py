"""The 28 parameters of the knee: names, groups, units, and what values the mechanics can take.

Four more may follow them, which the paper leaves out: how much longer (or, negative, shorter) than
in the load-free pose each ligament is at rest. A vector has 28 entries, or 32 with these; without
them they are zero.

Lengths are in m, angles in rad, stiffnesses in N/m^2, moduli in Pa: SI inside, other units only at
the border (files, command line, screen). The order of the table is the order of every vector. The
values, half-ranges and sources are in the packaged ``baseline.toml`` (see `kneecore.knee.file`).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._arguments import number, shown
from kneecore._arrays import numbers
from kneecore.errors import ParameterError
from kneecore.knee import units

__all__ = [
    "ALL_NAMES",
    "LIGAMENTS",
    "NAMES",
    "N_PARAMETERS",
    "REST_LENGTH_NAMES",
    "Parameter",
    "check_physical",
    "display_values",
    "named_half_ranges",
    "widened",
]

LIGAMENTS = ("acl", "pcl", "mcl", "lcl")

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One row of the parameter table."""

    name: str
    """Name, as in files and on the command line."""
    group: str
    """acl, pcl, mcl, lcl, condyle, plateau or material."""
    kind: str
    """geometry or material: what the cases of those names choose by; rest length: neither."""
    unit: str
    """Unit for people (mm, deg, N/mm^2, MPa, -)."""
    meaning: str
    """One phrase, with its frame."""
    baseline: float
    """Baseline value, SI."""
    half_range: float
    """Half-range of the uncertainty, SI."""
    source: str
    """Where the baseline value is from."""

    @property
    def scale(self) -> float:
        """SI value of one display unit."""
        return units.si_factor(self.unit)


def _structure() -> tuple[tuple[str, str, str, str, str], ...]:
    """Return (name, group, kind, unit, meaning) for each parameter, in the order of all vectors."""
    ends = (
        ("femur", "femoral attachment, femur frame"),
        ("tibia", "tibial attachment, tibia frame"),
    )
    axes = (("x", "anterior"), ("y", "proximal"))
    rows = [
        (f"{lig}_{end}_{axis}", lig, "geometry", "mm", f"{lig.upper()} {where}, {direction}")
        for lig in LIGAMENTS
        for end, where in ends
        for axis, direction in axes
    ]
    rows += [
        (
            "condyle_x",
            "condyle",
            "geometry",
            "mm",
            "centre of the condylar circle, femur frame, anterior",
        ),
        (
            "condyle_y",
            "condyle",
            "geometry",
            "mm",
            "centre of the condylar circle, femur frame, proximal",
        ),
        ("condyle_radius", "condyle", "geometry", "mm", "radius of the condylar circle"),
        (
            "plateau_x",
            "plateau",
            "geometry",
            "mm",
            "point of the plateau line, tibia frame, anterior",
        ),
        (
            "plateau_y",
            "plateau",
            "geometry",
            "mm",
            "point of the plateau line, tibia frame, proximal",
        ),
        (
            "plateau_slope",
            "plateau",
            "geometry",
            "deg",
            "slope of the plateau line, falling posteriorly",
        ),
    ]
    rows += [
        (f"{lig}_stiffness", "material", "material", "N/mm^2", f"{lig.upper()} quadratic stiffness")
        for lig in LIGAMENTS
    ]
    rows += [
        ("youngs_modulus", "material", "material", "MPa", "Young's modulus of both cartilages"),
        ("poissons_ratio", "material", "material", "-", "Poisson's ratio of both cartilages"),
    ]
    rows += [
        (
            f"{lig}_rest_length_change",
            lig,
            "rest length",
            "mm",
            f"what the {lig.upper()} is longer at rest than in the load-free pose",
        )
        for lig in LIGAMENTS
    ]
    return tuple(rows)


STRUCTURE = _structure()
ALL_NAMES: tuple[str, ...] = tuple(row[0] for row in STRUCTURE)
REST_LENGTH_NAMES = ALL_NAMES[-len(LIGAMENTS) :]
NAMES: tuple[str, ...] = ALL_NAMES[: -len(LIGAMENTS)]
N_PARAMETERS = len(NAMES)
_UNITS = tuple(row[3] for row in STRUCTURE)
_STIFFNESS = np.array([name.endswith("_stiffness") for name in ALL_NAMES])
_POSITIVE = np.array([name in ("condyle_radius", "youngs_modulus") for name in ALL_NAMES])
_POISSON = NAMES.index("poissons_ratio")
# What no knee of man or beast comes near, but a number in the wrong unit does: half a metre, a
# plateau that stands upright, 10^7 N/mm^2, the modulus of diamond; the condyle of a mouse, a jelly.
_LARGEST_BY_UNIT = {"mm": 0.5, "deg": math.radians(90.0), "N/mm^2": 1e13, "MPa": 1e12, "-": 1.0}
LARGEST = np.array([_LARGEST_BY_UNIT[unit] for unit in _UNITS])
"""Largest size of each parameter's value that is taken for a knee's, SI, shape (32,)."""
SMALLEST = np.array(
    [{"condyle_radius": 1e-4, "youngs_modulus": 1e3}.get(n, 0.0) for n in ALL_NAMES]
)
"""Smallest size, likewise; a ligament may be torn: its stiffness is 0."""
SMALLEST.setflags(write=False)
LARGEST.setflags(write=False)


def in_display_unit(index: int, value: float) -> str:
    """Return parameter `index` at SI `value` as text in its display unit."""
    unit = _UNITS[index]
    return f"{float(value) / units.si_factor(unit):.6g}" + ("" if unit == "-" else f" {unit}")


def _first_fault(values: FloatArray) -> tuple[int, int, str] | None:
    """Return (row, column, what is allowed) of the first value that the mechanics cannot take."""
    width = values.shape[1]
    poisson = values[:, _POISSON]
    incompressible = np.zeros(values.shape, dtype=bool)
    incompressible[:, _POISSON] = (poisson <= -1.0) | (poisson >= 0.5)
    rules = (
        (~np.isfinite(values), "a finite number is allowed"),
        (_STIFFNESS[:width] & (values < 0.0), "a stiffness of at least 0 is allowed"),
        (_POSITIVE[:width] & (values <= 0.0), "a value above 0 is allowed"),
        (incompressible, "a value above -1 and below 0.5 is allowed"),
    )
    for broken, allowed in rules:
        if broken.any():
            row, column = np.unravel_index(int(np.argmax(broken)), broken.shape)
            return int(row), int(column), allowed
    return _first_absurd(values)


def _first_absurd(values: FloatArray) -> tuple[int, int, str] | None:
    """Return the same of the first value that is too large or too small for a knee."""
    width = values.shape[1]
    size = np.abs(values)
    absurd = (size > LARGEST[:width]) | (size < SMALLEST[:width])
    if not absurd.any():
        return None
    row, column = (int(i) for i in np.unravel_index(int(np.argmax(absurd)), absurd.shape))
    limit, which = LARGEST[column], "at most"
    if size[row, column] < SMALLEST[column]:
        limit, which = SMALLEST[column], "at least"
    return (
        row,
        column,
        f"a size of {which} {in_display_unit(column, limit)} is allowed (which unit?)",
    )


def check_physical(values: ArrayLike, argument: str = "x") -> FloatArray:
    """Return `values` as a vector of 28 (or 32) or an array of such rows, checked and copied.

    Parameters
    ----------
    values : array_like, shape (28,) or (n, 28)
        Parameter values, SI, in the table's order; (32,) or (n, 32) with the changes of the rest
        lengths.
    argument : str
        Name for the message.

    Raises
    ------
    ParameterError
        For a wrong shape, a value that is not finite, a negative stiffness, a radius or a Young's
        modulus that is not positive, a Poisson's ratio outside (-1, 0.5), or a value of a size that
        no knee has (`LARGEST`, `SMALLEST`), such as mm written as m.
    """
    said = f"{N_PARAMETERS} numbers a model are allowed"
    array = np.array(numbers(argument, values, said), order="C")
    if array.ndim not in (1, 2) or array.shape[-1] not in (N_PARAMETERS, len(ALL_NAMES)):
        raise ParameterError(
            f"`{argument}` has shape {array.shape}; "
            f"({N_PARAMETERS},) or (n, {N_PARAMETERS}) is allowed"
            f" ({len(ALL_NAMES)} with the changes of the rest lengths)"
        )
    fault = _first_fault(np.atleast_2d(array))
    if fault is not None:
        row, column, allowed = fault
        value = array[column] if array.ndim == 1 else array[row, column]
        where = "" if array.ndim == 1 else f"[{row}]"
        raise ParameterError(
            f"`{argument}`{where}: `{ALL_NAMES[column]}` is {in_display_unit(column, value)}; "
            f"{allowed}"
        )
    return array


def named_half_ranges(given: Any) -> dict[str, float]:
    """Return half-ranges (SI) by parameter name, checked.

    Raises
    ------
    ParameterError
        If they are no mapping of parameters' names to numbers of at least 0.
    """
    if not isinstance(given, Mapping):
        raise ParameterError(
            f"`half_ranges` is {shown(given)}; a mapping of names to numbers is allowed"
        )
    for name in given:
        if name not in ALL_NAMES:
            raise ParameterError(
                f"`half_ranges` names {shown(name)}; allowed are the parameters' names, "
                f"{NAMES[0]} to {NAMES[-1]}, and {', '.join(REST_LENGTH_NAMES)}"
            )
    return {
        name: number(f"half_ranges[{name!r}]", value, unit="(SI)", least=0.0)
        for name, value in given.items()
    }


def display_values(x: Sequence[float] | FloatArray) -> list[float]:
    """Return SI values as numbers in each parameter's display unit."""
    return [float(v) / units.si_factor(u) for v, u in zip(x, _UNITS[: len(x)], strict=True)]


def widened(x: ArrayLike, width: int) -> FloatArray:
    """Return a copy of knees, (..., 28) or (..., 32), with `width` entries: changes of 0 added.

    Entries are cut off only if they are 0.

    Raises
    ------
    ParameterError
        If `x` is something else, or if a rest length that is changed would be left out.
    """
    values = numbers("x", x)
    if values.ndim == 0 or values.shape[-1] not in (N_PARAMETERS, len(ALL_NAMES)):
        raise ParameterError(
            f"`x` has shape {values.shape}; (..., {N_PARAMETERS}) or (..., {len(ALL_NAMES)}) "
            "is allowed"
        )
    missing = width - values.shape[-1]
    if missing > 0:
        return np.concatenate([values, np.zeros((*values.shape[:-1], missing))], axis=-1)
    if values[..., width:].any():
        raise ParameterError(
            "`x` changes rest lengths; the space has no rest lengths among its parameters"
        )
    return np.array(values[..., :width])

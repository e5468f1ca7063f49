"""The units that files, command line and screen use, and their SI values."""

import math

from kneecore._arguments import shown
from kneecore.errors import FileFormatError

_UNITS: dict[str, tuple[str, float]] = {
    "mm": ("length", 1e-3),
    "m": ("length", 1.0),
    "deg": ("angle", math.pi / 180.0),
    "rad": ("angle", 1.0),
    "N/mm^2": ("stiffness", 1e6),
    "N/m^2": ("stiffness", 1.0),
    "MPa": ("modulus", 1e6),
    "Pa": ("modulus", 1.0),
    "-": ("ratio", 1.0),
}


def si_factor(unit: str, like: str | None = None) -> float:
    """Return the SI value of one `unit`.

    Parameters
    ----------
    unit : str
        The unit's symbol.
    like : str, optional
        A unit of the kind that is expected.

    Raises
    ------
    FileFormatError
        If the unit is unknown or of another kind than `like`.
    """
    kind, factor = _UNITS.get(unit, ("", 0.0))
    wanted = _UNITS[like][0] if like is not None else kind
    if not kind or kind != wanted:
        allowed = [u for u, (k, _) in _UNITS.items() if like is None or k == wanted]
        raise FileFormatError(
            f"unit {shown(unit)} is not known here; allowed: {', '.join(allowed)}"
        )
    return factor


def si_unit(unit: str) -> str:
    """Return the SI unit of the same kind as `unit`."""
    kind = _UNITS[unit][0]
    return next(u for u, (k, factor) in _UNITS.items() if k == kind and factor == 1.0)

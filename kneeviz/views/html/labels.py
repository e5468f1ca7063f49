"""Names for people: parameters, loads, and what the landscape can show upright."""

import numpy as np

from kneecore import LIGAMENTS, MOMENT, READINGS
from kneecore.knee.parameters import STRUCTURE
from kneecore.knee.readings import DEFICIT

_UNITS = {row[0]: row[3].replace("^2", "²").replace("deg", "°") for row in STRUCTURE}


def parameter_label(name: str) -> str:
    """Return a parameter's name for people."""
    words = name.split("_")
    lead = words[0].upper() if words[0] in LIGAMENTS else words[0].capitalize()
    return (
        " ".join([lead, *words[1:]])
        .replace("Poissons", "Poisson's")
        .replace("Youngs", "Young's")
        .replace("rest length change", "rest length")
    )


def moment_words(moment: float) -> str:
    """Return what a moment does."""
    if abs(moment) < 5e-3:
        return "no load"
    return "extending" if moment > 0.0 else "flexing"


def unit_of(name: str) -> str:
    """Return a parameter's unit as it stands behind its number, with the gap; nothing for none."""
    unit = _UNITS[name]
    if unit == "-":
        return ""
    return unit if unit == "°" else f" {unit}"


def with_unit(name: str) -> str:
    """Return a parameter's name for people, with its unit."""
    unit = _UNITS[name]
    label = parameter_label(name)
    return label if unit == "-" else f"{label} ({unit})"


def load_label(moment: float) -> str:
    """Return a load for people: "+5 N·m, extending"."""
    sign = "+" if moment > 0.0 else "\u2212"
    return f"{sign}{abs(moment):g} N·m, {moment_words(moment)}"


LOADS = {load_label(float(m)): float(m) for m in MOMENT[np.argsort(-MOMENT)]}
"""The 12 loads by their label, from extension to flexion."""


def _reading_label(name: str) -> str:
    return "Extension deficit" if name == DEFICIT else f"Angle at {load_label(float(name[:-4]))}"


HEIGHTS = {_reading_label(name): name for name in READINGS}
"""kneecore's readings by their label."""


def height_title(name: str) -> str:
    """Return the upright axis's title for one of kneecore's readings."""
    if name == DEFICIT:
        return "Extension deficit (°)"
    return f"Knee angle at {load_label(float(name[:-4])).split(',')[0]} (°)"

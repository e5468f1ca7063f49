"""The knees to start from: a list with the baseline, telling ones and the two worst cases."""

import numpy as np
from numpy.typing import NDArray

from kneecore import NAMES, ParameterSpace

FloatArray = NDArray[np.float64]

OWN_KNEE = "My own"
BASELINE = "Baseline"
RANDOM = "Random, within bounds"
WORST = ("Worst case, model 1", "Worst case, model 2")

PRESETS: dict[str, dict[str, float]] = {
    "ACL 1 bound further forward": {"acl_femur_x": 1.0},
    "ACL 1 bound lower on the femur": {"acl_femur_y": -1.0},
    "Steeper plateau": {"plateau_slope": 1.0},
    "Flatter plateau": {"plateau_slope": -1.0},
    "Larger condyle": {"condyle_radius": 1.0},
    "Everything soft": {name: -1.0 for name in NAMES if name.endswith(("stiffness", "modulus"))},
    "Everything stiff": {name: 1.0 for name in NAMES if name.endswith(("stiffness", "modulus"))},
}
"""Telling knees, as shares of the half-range away from the baseline."""


def preset_knee(name: str, space: ParameterSpace) -> FloatArray:
    """Return a preset's parameters within a space."""
    x = np.array(space.baseline)
    for parameter, share in PRESETS[name].items():
        i = NAMES.index(parameter)
        edge = space.upper[i] if share > 0.0 else space.lower[i]
        x[i] += abs(share) * (edge - x[i])
    return x


def random_knee(space: ParameterSpace, rng: np.random.Generator) -> FloatArray:
    """Return a knee drawn uniformly from a space."""
    return space.from_unit(rng.random(len(space.lower)))

"""Our quantity beside each claim of the paper: one small function each.

A measure returns one number, one for each seed of a repeated search, or one for each pair (the
exact optimum, then the seeds), in the unit that `assets/paper.toml` names. What a failed model
leaves unknown is NaN.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kneecore.paper.experiments import Experiments
from kneecore.paper.finding import Finding
from kneecore.paper.measures import curves, figure_2, knees, searches

__all__ = ["MEASURES", "Measure"]

Measure = Callable[[Experiments], float | NDArray[np.float64] | Finding]
_NO_MEASURES = ("ap_slopes", "tension_at")
MEASURES: dict[str, Measure] = {
    name: getattr(module, name)
    for module in (knees, curves, figure_2, searches)
    for name in module.__all__
    if name not in _NO_MEASURES
}
"""By the names that `assets/paper.toml` uses."""

"""What the charts show: curves, the sampling band behind them, and the poses marked on them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore import MonteCarloResult
from kneeviz.geometry.mechanism import Pose
from kneeviz.geometry.sweep import Sweep
from kneeviz.state.origin import Origin, of_found

FloatArray = NDArray[np.float64]

KNEES = ("baseline", "current", "model_1", "model_2")
"""The knees of every chart, in the order in which they are drawn."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Band:
    """Where 99.7 % of sampled knees lie, load by load."""

    lower_deg: FloatArray
    """Shape (12,), in the response's order of loads."""
    upper_deg: FloatArray
    """Shape (12,)."""
    text: str
    """What was sampled and how, for people: "2,000 samples, settled"."""
    origin: Origin


def band_of(sampled: MonteCarloResult, text: str) -> Band:
    """Return the band of a sampling; `text` says what was sampled."""
    spread = sampled.y
    return Band(
        lower_deg=spread.percentile_lower,
        upper_deg=spread.percentile_upper,
        text=text,
        origin=of_found(sampled),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Shown:
    """What the charts show now. A missing knee is None."""

    sweeps: tuple[Sweep | None, ...]
    """Baseline, the visitor's knee, worst case 1 and 2."""
    flexion: FloatArray | None
    """The visitor's knee's 12 angles, rad."""
    predicted: FloatArray | None
    """The surrogate's 12 angles for the visitor's knee, rad."""
    training: FloatArray | None
    """The surrogate's training curves, shape (n, 12), rad."""
    strain_free: bool
    """Whether all knees share the load-free pose."""
    band: Band | None = None
    """The sampling band behind the curves."""
    ghosts: tuple[Sweep, ...] = ()
    """The visitor's earlier knees."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Markers:
    """The poses on screen: the visitor's knee, worst case 1 and 2."""

    poses: tuple[Pose | None, Pose | None, Pose | None]

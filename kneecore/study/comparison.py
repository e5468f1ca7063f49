"""The worst case held against sampling: how far outside of the sampled band it lies."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ParameterError
from kneecore.knee.response import MOMENT
from kneecore.knee.space import ParameterSpace
from kneecore.numbers import plain
from kneecore.search.result import SearchResult
from kneecore.study.monte_carlo import MonteCarloResult

__all__ = ["Comparison", "compare_with_sampling"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Comparison:
    """Two worst-case knees beside the 99.7 % band (percentiles) of a Monte-Carlo study."""

    excess_deg: FloatArray
    """How far each knee's angle lies outside of the band, shape (2, 12), deg; 0 inside."""
    excess_share: FloatArray
    """The same as a share of the band's width."""
    below: FloatArray | None
    """Share of the samples below each knee's angle, shape (2, 12), where the study counted it."""

    def share_outside(self, direction: str) -> FloatArray:
        """Return the share of a direction's six loads at which each knee is outside, shape (2,).

        Parameters
        ----------
        direction : {"extension", "flexion"}
        """
        if direction not in ("extension", "flexion"):
            raise ParameterError(
                f"`direction` is {direction!r}; 'extension' or 'flexion' is allowed"
            )
        chosen = (MOMENT > 0) == (direction == "extension")
        share: FloatArray = (self.excess_deg[:, chosen] > 0.0).mean(axis=1)
        return share

    def to_dict(self) -> dict[str, Any]:
        """Return the comparison as JSON-ready values."""
        return {
            "excess_deg": {
                "model_1": plain(self.excess_deg[0]),
                "model_2": plain(self.excess_deg[1]),
            },
            "excess_share": {
                "model_1": plain(self.excess_share[0]),
                "model_2": plain(self.excess_share[1]),
            },
            "share_of_loads_outside": {
                name: plain(self.share_outside(name)) for name in ("extension", "flexion")
            },
            "share_of_samples_below": None if self.below is None else plain(self.below),
        }


def check_comparable(
    worst: SearchResult, space: ParameterSpace, rest_length: str, solver: str
) -> None:
    """Raise a `ParameterError` if a worst case is not of the bounds and responses of samples."""
    same = np.array_equal(worst.space.lower, space.lower) and np.array_equal(
        worst.space.upper, space.upper
    )
    if not same or worst.rest_length != rest_length:
        raise ParameterError(
            "`result` and the samples have other bounds or rest lengths; the same are needed to "
            "compare them"
        )
    if worst.solver != solver:
        raise ParameterError(
            f"`result` has the solver {worst.solver!r} and the samples {solver!r}; the same is "
            "needed to compare them"
        )


def compare_with_sampling(worst: SearchResult, study: MonteCarloResult) -> Comparison:
    """Hold a worst case against a Monte-Carlo study of the same bounds.

    Raises
    ------
    ParameterError
        If the two were not made with the same bounds, rest lengths and solver.
    """
    check_comparable(worst, study.space, study.rest_length, study.solver)
    angles = np.degrees([worst.model_1.flexion, worst.model_2.flexion])
    lower, upper = study.flexion_deg.percentile_lower, study.flexion_deg.percentile_upper
    excess = np.maximum(np.maximum(lower - angles, angles - upper), 0.0)
    return Comparison(excess_deg=excess, excess_share=excess / (upper - lower), below=study.below)

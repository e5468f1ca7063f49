"""The worst case held against sampling: how far outside of the sampled band it lies."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore._arguments import shown
from kneecore.errors import ParameterError
from kneecore.model import Model
from kneecore.presented import Presented
from kneecore.search.result import SearchResult
from kneecore.study.monte_carlo import MonteCarloResult

__all__ = ["Comparison", "check_comparable", "compare_with_sampling"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Comparison(Presented):
    """Two worst-case models beside the 99.7 % band (percentiles) of a Monte-Carlo study."""

    model: Model
    excess: FloatArray
    """How far each model's output lies outside of the band, shape (2, m); 0 inside."""
    excess_share: FloatArray
    """The same as a share of the band's width; not finite where it has none."""
    below: FloatArray | None
    """Share of the samples below each model's output, shape (2, m), where the study counted it."""

    def share_outside(self, objective: str) -> FloatArray:
        """Return the share of an objective's outputs at which each model is outside, shape (2,).

        Parameters
        ----------
        objective : str
            A name of `Model.objectives`, such as the knee's "extension" or "flexion".
        """
        choices = self.model.objectives
        if objective not in choices:
            raise ParameterError(
                f"`objective` is {shown(objective)}; {', '.join(choices)} is allowed"
            )
        chosen = choices[objective] > 0.0
        share: FloatArray = (self.excess[:, chosen] > 0.0).mean(axis=1)
        return share


def _same_bounds(one: Model, other: Model) -> bool:
    return (
        one.names == other.names
        and [c.label for c in one.columns] == [c.label for c in other.columns]
        and np.array_equal(one.lower, other.lower)
        and np.array_equal(one.upper, other.upper)
    )


def check_comparable(worst: SearchResult, model: Model) -> None:
    """Raise a `ParameterError` if a worst case is not of the model that is sampled."""
    if not _same_bounds(worst.model, model):
        raise ParameterError(
            "`result` and the samples have other bounds; the same are needed to compare them"
        )
    found, sampled = worst.model.computed, model.computed
    for name in sampled:
        if found.get(name) != sampled[name]:
            raise ParameterError(
                f"`result` has the {name} {found.get(name)!r} and the samples {sampled[name]!r}; "
                "the same is needed to compare them"
            )


def compare_with_sampling(worst: SearchResult, study: MonteCarloResult) -> Comparison:
    """Hold a worst case against a Monte-Carlo study of the same bounds.

    Raises
    ------
    ParameterError
        If the two were not made with the same bounds, and computed in the same way.
    """
    check_comparable(worst, study.model)
    lower, upper = study.y.percentile_lower, study.y.percentile_upper
    excess = np.maximum(np.maximum(lower - worst.y, worst.y - upper), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):  # an output that does not vary
        share = excess / (upper - lower)
    return Comparison(model=study.model, excess=excess, excess_share=share, below=study.below)

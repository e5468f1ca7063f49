"""What is searched, and what a search has found, on the unit cube of a model's free inputs."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore.progress import Callback
from kneecore.search.result import Evidence, Repair, Verdict
from kneecore.search.settings import SearchSettings
from kneecore.search.training import Training
from kneecore.unit_model import UnitModel

__all__ = ["Found", "Outcome", "Problem", "pair_value", "verified"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Problem:
    """Two points of a model's unit cube are wanted whose outputs differ most."""

    model: UnitModel
    weights: FloatArray
    """Weight of each output's difference, shape (m,)."""
    settings: SearchSettings
    callback: Callback | None = None
    """Gets `Progress`; a true result cancels. A cancelled search returns the best pair so far."""
    result_of: Callable[["Outcome", UnitModel], Any] | None = None
    """Makes the search's result of what it has found until now, with the counts until now."""

    @property
    def n_dimensions(self) -> int:
        """Dimensions of the unit cube, d."""
        return self.model.model.n_free

    @property
    def order(self) -> Sequence[int]:
        """The outputs in the order in which neighbours change together."""
        return self.model.model.order

    @property
    def threads(self) -> int | None:
        """Threads that share a search in the surrogate; all available cores for None."""
        return self.model.model.threads


@dataclass(frozen=True, kw_only=True, eq=False)
class Found:
    """The best pair of one search, in the space that was searched."""

    u: FloatArray
    """The two models, shape (2, d), unit cube."""
    run_values: tuple[float, ...]
    """Best f of each run."""
    best_run: int
    history: FloatArray
    """Best f in the course of the best run."""
    n_evaluations: int
    """Pairs evaluated by the genetic algorithm, all runs."""
    stop_reason: str
    evidence: Evidence | None = None

    @property
    def value(self) -> float:
        """F of the pair."""
        return self.run_values[self.best_run]


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """What was found, with the true model's own word on it."""

    found: Found
    y: FloatArray
    """The true model's outputs, shape (2, m); NaN where it failed."""
    y_surrogate: FloatArray | None
    """The surrogate's outputs, shape (2, m)."""
    objective_surrogate: float | None
    """f by the surrogate; of one that was repaired, the largest that it still promises."""
    objective_model: float | None
    """f in the true model; None if it failed there."""
    training: Training | None
    seconds: Mapping[str, float]
    repair: Repair | None = None
    verdict: Verdict | None = None


def pair_value(y: FloatArray, weights: FloatArray) -> float:
    """Return f of a pair's outputs, shape (2, m); NaN if one of the two has failed."""
    return float((np.abs(y[0] - y[1]) * weights).sum())


def verified(problem: Problem, found: Found, training: Training | None, begun: float) -> Outcome:
    """Return what was found, computed again in the true model.

    `begun` is when the search began, by `time.perf_counter`.
    """
    searched = time.perf_counter()
    y = problem.model(found.u)
    f = pair_value(y, problem.weights)
    return Outcome(
        found=found,
        y=y,
        y_surrogate=training.surrogate(found.u) if training else None,
        objective_surrogate=found.value if training else None,
        objective_model=f if np.isfinite(f) else None,
        training=training,
        seconds={
            "sampling": training.seconds_sampling if training else 0.0,
            "fit": training.seconds_fit if training else 0.0,
            "search": searched - begun,
            "verify": time.perf_counter() - searched,
        },
    )

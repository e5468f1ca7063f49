"""The worst-case search for any batched model: sample, fit, search the pair, recompute.

Everything here lives in the unit cube of the free inputs; `kneecore.search.worst_case` maps it to
a user's bounds or to the knee's parameters.
"""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ParameterError
from kneecore.numerics.genetic import GeneticResult, maximize
from kneecore.numerics.pair import ModelPair, SurrogatePair
from kneecore.progress import Callback, Progress
from kneecore.search.repair_history import Repair
from kneecore.search.settings import PairSettings
from kneecore.search.sign_climb import Evidence
from kneecore.search.training import Training, UnitModel, outputs_of, train

__all__ = [
    "Found",
    "PairOutcome",
    "checked_weights",
    "find_pair",
    "gap_percent",
    "pair_value",
    "search_pair",
    "verified",
]

FloatArray = NDArray[np.float64]


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
class PairOutcome:
    """The best pair found, in the unit cube, with the model's own word on it."""

    u: FloatArray
    """The two models, shape (2, d)."""
    y: FloatArray
    """The true model's outputs, shape (2, m); NaN where it failed."""
    y_surrogate: FloatArray | None
    """The surrogate's outputs, shape (2, m)."""
    objective_surrogate: float | None
    """f by the surrogate; of one that was repaired, the largest that it still promises."""
    objective_model: float | None
    """f in the true model; None if it failed there."""
    training: Training | None
    run_values: tuple[float, ...]
    """Best f of each run, in the space searched."""
    best_run: int
    history: FloatArray
    """Best f after each generation of the best run."""
    n_evaluations: int
    """Pairs evaluated by the genetic algorithm, all runs."""
    stop_reason: str
    seconds: dict[str, float]
    evidence: Evidence | None = None
    """What an exact search says about how good the pair is."""
    repair: Repair | None = None
    """How the surrogate was repaired."""

    @property
    def gap_percent(self) -> float | None:
        """100 (surrogate - model) / surrogate; None without both."""
        return gap_percent(self.objective_surrogate, self.objective_model)


def pair_value(y: FloatArray, weights: FloatArray) -> float:
    """Return f of a pair's outputs, shape (2, m); NaN if one of the two has failed."""
    return float((np.abs(y[0] - y[1]) * weights).sum())


def gap_percent(surrogate: float | None, model: float | None) -> float | None:
    """Return 100 (surrogate - model) / surrogate; None without both."""
    if surrogate is None or model is None or surrogate == 0.0:
        return None
    return 100.0 * (1.0 - model / surrogate)


def checked_weights(weights: FloatArray | None, n_values: int) -> FloatArray:
    """Return the outputs' weights checked; ones for None."""
    if weights is None:
        return np.ones(n_values)
    if weights.shape != (n_values,) or not np.isfinite(weights).all():
        raise ParameterError(
            f"`weights` has shape {weights.shape}; ({n_values},) of finite numbers is allowed"
        )
    return weights


def _run_all(
    objective: ModelPair | SurrogatePair,
    n_dimensions: int,
    settings: PairSettings,
    callback: Callback | None,
) -> list[GeneticResult]:
    """Run the genetic algorithm `n_runs` times, fewer if cancelled."""
    per_run = settings.n_generations
    results: list[GeneticResult] = []
    for run in range(settings.n_runs):

        def watch(generation: int, best: float, run: int = run) -> object:
            if callback is None:
                return False
            return callback(
                Progress(
                    stage="search",
                    done=run * per_run + generation,
                    total=settings.n_runs * per_run,
                    best=best if np.isfinite(best) else None,
                    run=run,
                )
            )

        results.append(
            maximize(
                objective,
                np.zeros(2 * n_dimensions),
                np.ones(2 * n_dimensions),
                pop_size=settings.pop_size,
                n_generations=per_run,
                options=settings.options,
                seed=settings.run_seed(run),
                callback=watch,
            )
        )
        if results[-1].stop_reason == "cancelled":
            break
    return results


def search_pair(
    objective: ModelPair | SurrogatePair,
    n_dimensions: int,
    settings: PairSettings,
    callback: Callback | None = None,
) -> Found:
    """Find the best pair for `objective` by the genetic algorithm."""
    results = _run_all(objective, n_dimensions, settings, callback)
    values = [r.value for r in results]
    if isinstance(objective, SurrogatePair):
        values = [objective.exact(r.x) for r in results]
    best_run = int(np.argmax(values))
    return Found(
        u=results[best_run].x.reshape(2, n_dimensions),
        run_values=tuple(values),
        best_run=best_run,
        history=results[best_run].history,
        n_evaluations=sum(r.n_evaluations for r in results),
        stop_reason=results[-1].stop_reason,
    )


def verified(
    model: UnitModel, found: Found, training: Training | None, weights: FloatArray, begun: float
) -> PairOutcome:
    """Return what was found, computed again in the true model.

    `begun` is when the search began, by `time.perf_counter`.
    """
    searched = time.perf_counter()
    y = outputs_of(model, found.u)
    f = pair_value(y, weights)
    return PairOutcome(
        u=found.u,
        y=y,
        y_surrogate=training.surrogate(found.u) if training else None,
        objective_surrogate=found.value if training else None,
        objective_model=f if np.isfinite(f) else None,
        training=training,
        run_values=found.run_values,
        best_run=found.best_run,
        history=found.history,
        n_evaluations=found.n_evaluations,
        stop_reason=found.stop_reason,
        seconds={
            "sampling": training.seconds_sampling if training else 0.0,
            "fit": training.seconds_fit if training else 0.0,
            "search": searched - begun,
            "verify": time.perf_counter() - searched,
        },
        evidence=found.evidence,
    )


def find_pair(
    model: UnitModel,
    n_dimensions: int,
    weights: FloatArray | None,
    settings: PairSettings,
    callback: Callback | None = None,
    threads: int | None = None,
) -> PairOutcome:
    """Find the two points of the unit cube whose outputs differ most.

    Parameters
    ----------
    model : callable
        Maps (n, d) in the unit cube to outputs (n, m); a row of NaN is a failure.
    n_dimensions : int
        d
    weights : ndarray, shape (m,), optional
        Weight of each output's difference; ones for None.
    settings : PairSettings
    callback : callable, optional
        Gets `Progress`; a true result cancels. A cancelled search returns the best pair so far.
    threads : int, optional
        Threads that share a search in the surrogate; all available cores for None.

    Raises
    ------
    Cancelled
        If it was cancelled before the genetic algorithm had begun.
    """
    training = None
    objective: ModelPair | SurrogatePair
    if settings.search_space == "surrogate":
        training = train(model, n_dimensions, settings, callback)
        wanted = checked_weights(weights, training.surrogate.n_values)
        objective = SurrogatePair(training.surrogate, wanted, threads)
    else:
        n_values = outputs_of(model, np.full((1, n_dimensions), 0.5)).shape[1]
        wanted = checked_weights(weights, n_values)
        objective = ModelPair(lambda u: outputs_of(model, u, n_values), wanted)
    begun = time.perf_counter()
    found = search_pair(objective, n_dimensions, settings, callback)
    if callback is not None:
        callback(Progress(stage="verify", done=0, total=2, best=found.value, run=found.best_run))
    return verified(model, found, training, wanted, begun)

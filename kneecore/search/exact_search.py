"""The exact search in the place of the genetic algorithm: the same outcome, with its evidence."""

import time

import numpy as np
from numpy.typing import NDArray

from kneecore.numerics.box_climb import Slopes
from kneecore.numerics.surrogate import Surrogate
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.exact_model import exact_pair
from kneecore.search.problem import Found, Outcome, Problem, verified
from kneecore.search.sign_climb import ExactSettings, climb_pair
from kneecore.search.training import train

__all__ = ["climb_surrogate", "exact_in_model", "exact_in_surrogate", "slopes_of"]

FloatArray = NDArray[np.float64]


def slopes_of(surrogate: Surrogate) -> Slopes:
    """Return the surrogate as climbs see it."""

    def slopes(u: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        y = surrogate(u)
        return (w * y).sum(axis=1), surrogate.weighted_gradient(u, w), y

    return slopes


class _Watch:
    """Turns the search's reports into `Progress`, and remembers whether they cancelled."""

    def __init__(self, callback: Callback | None) -> None:
        self._callback = callback
        self.history: list[float] = []
        self.cancelled = False

    def __call__(self, best: float, n_models: int) -> bool:
        known = bool(np.isfinite(best))
        if known and (not self.history or best > self.history[-1]):
            self.history.append(best)
        if self._callback is not None:
            told = best if known else None
            report = Progress(stage="search", done=0, total=1, best=told, n_models=n_models)
            self.cancelled = bool(self._callback(report))
        return self.cancelled

    def begin(self) -> None:
        if self._callback is not None and self._callback(Progress(stage="search", done=0, total=1)):
            raise Cancelled

    @property
    def stop_reason(self) -> str:
        return "cancelled" if self.cancelled else "converged"


def climb_surrogate(
    problem: Problem, surrogate: Surrogate, callback: Callback | None = None
) -> Found:
    """Find the most different pair of a surrogate by climbs with its exact gradient."""
    watch = _Watch(callback)
    found = climb_pair(
        slopes_of(surrogate),
        surrogate.n_dimensions,
        problem.weights,
        order=problem.order,
        settings=ExactSettings(seed=problem.settings.seed),
        report=watch,
    )
    return Found(
        u=found.u,
        run_values=(found.value,),
        best_run=0,
        history=np.array([*watch.history, found.value]),
        n_evaluations=0,
        stop_reason=watch.stop_reason,
        evidence=found.evidence,
    )


def exact_in_surrogate(problem: Problem) -> Outcome:
    """Find the most different pair of a surrogate, and compute it again in the true model."""
    training = train(problem.model, problem.settings, problem.callback)
    begun = time.perf_counter()
    found = climb_surrogate(problem, training.surrogate, problem.callback)
    return verified(problem, found, training, begun)


def exact_in_model(problem: Problem) -> Outcome:
    """Find the most different pair in the true model."""
    watch = _Watch(problem.callback)
    watch.begin()
    begun = time.perf_counter()
    pair = exact_pair(
        problem.model.model,
        problem.weights,
        settings=ExactSettings(seed=problem.settings.seed, thorough=problem.settings.thorough),
        report=watch,
    )
    evidence = pair.evidence
    problem.model.n_simulated += evidence.n_evaluations + evidence.n_models
    problem.model.counts["failed"] += evidence.n_failed
    return Outcome(
        found=Found(
            u=pair.u,
            run_values=(pair.objective,),
            best_run=0,
            history=np.array([*watch.history, pair.objective]),
            n_evaluations=0,
            stop_reason=watch.stop_reason,
            evidence=evidence,
        ),
        y=pair.y,
        y_surrogate=None,
        objective_surrogate=None,
        objective_model=pair.objective,
        training=None,
        seconds={
            "sampling": 0.0,
            "fit": 0.0,
            "search": time.perf_counter() - begun,
            "verify": 0.0,
        },
    )

"""The exact search in the place of the genetic algorithm: the same outcome, with its evidence."""

import contextlib
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore.numerics.box_climb import Slopes
from kneecore.numerics.surrogate import Surrogate
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.best_seen import BestSeen
from kneecore.search.bound_evidence import bound_evidence
from kneecore.search.discrete import polished_pair
from kneecore.search.exact_model import exact_pair
from kneecore.search.problem import Found, Outcome, Problem, verified
from kneecore.search.result import Evidence
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

    def __init__(
        self,
        callback: Callback | None,
        so_far: Callable[[], Callable[[], Any] | None] | None = None,
    ) -> None:
        self._callback, self._so_far = callback, so_far
        self.history: list[float] = []
        self.cancelled = False

    def __call__(self, best: float, n_models: int) -> bool:
        known = bool(np.isfinite(best))
        if known and (not self.history or best > self.history[-1]):
            self.history.append(best)
        if self._callback is not None:
            told = best if known else None
            report = Progress(
                stage="search",
                done=0,
                total=1,
                best=told,
                n_models=n_models,
                so_far=None if self._so_far is None else self._so_far(),
            )
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
    u, value = found.u, found.value
    history = [*watch.history, value]
    evidence: Evidence | None = found.evidence
    box = problem.model.model
    if box.grids:  # what was climbed on the way there is between allowed values
        u, value = polished_pair(surrogate, problem.weights, u, box)
        history, evidence = [value], None
    return Found(
        u=u,
        run_values=(value,),
        best_run=0,
        history=np.array(history),
        n_evaluations=0,
        stop_reason=watch.stop_reason,
        evidence=evidence,
    )


def exact_in_surrogate(problem: Problem) -> Outcome:
    """Find the most different pair of a surrogate, and compute it again in the true model."""
    training = train(problem.model, problem.settings, problem.callback)
    begun = time.perf_counter()
    found = climb_surrogate(problem, training.surrogate, problem.callback)
    return verified(problem, found, training, begun)


def _until_now(problem: Problem, seen: BestSeen, begun: float) -> Callable[[], Any] | None:
    """Return what makes a result of the best pair that was seen, or None before there is one."""
    found, result_of = seen.pair, problem.result_of
    if found is None or result_of is None:
        return None
    (u, y), f = found, seen.value
    counted = problem.model.copy()
    counted.n_simulated += seen.n_models
    counted.counts["failed"] += seen.n_failed
    return lambda: result_of(_outcome(u, y, f, [f], begun, "cancelled"), counted)


def _outcome(
    u: FloatArray,
    y: FloatArray,
    value: float,
    history: list[float],
    begun: float,
    stop_reason: str,
    evidence: Evidence | None = None,
) -> Outcome:
    """Return a pair of the true model as a search's outcome."""
    return Outcome(
        found=Found(
            u=u,
            run_values=(value,),
            best_run=0,
            history=np.array(history),
            n_evaluations=0,
            stop_reason=stop_reason,
            evidence=evidence,
        ),
        y=y,
        y_surrogate=None,
        objective_surrogate=None,
        objective_model=value,
        training=None,
        seconds={
            "sampling": 0.0,
            "fit": 0.0,
            "search": time.perf_counter() - begun,
            "verify": 0.0,
        },
    )


def exact_in_model(problem: Problem) -> Outcome:
    """Find the most different pair in the true model."""
    begun = time.perf_counter()
    seen = BestSeen(problem.weights) if problem.callback is not None else None
    so_far = None if seen is None else lambda: _until_now(problem, seen, begun)
    watch = _Watch(problem.callback, so_far)
    watch.begin()
    pair = exact_pair(
        problem.model.model,
        problem.weights,
        settings=ExactSettings(seed=problem.settings.seed, thorough=problem.settings.thorough),
        report=watch,
        seen=seen,
    )
    evidence = pair.evidence
    problem.model.n_simulated += evidence.n_evaluations + evidence.n_models
    problem.model.counts["failed"] += evidence.n_failed
    if problem.settings.bound and not watch.cancelled:
        evidence = _bounded(problem, evidence, pair.objective)
    history = [*watch.history, pair.objective]
    return _outcome(pair.u, pair.y, pair.objective, history, begun, watch.stop_reason, evidence)


def _bounded(problem: Problem, evidence: Evidence, best: float) -> Evidence:
    """Return the evidence with what slopes say; as it was if that is cancelled."""

    def tell(share: float) -> None:
        report = Progress(stage="bound", done=round(100 * share), total=100, best=best)
        if problem.callback is not None and problem.callback(report):
            raise Cancelled

    model, seed = problem.model.model, problem.settings.seed
    with contextlib.suppress(Cancelled):  # the pair is found, and is worth keeping
        bound = bound_evidence(model, problem.weights, evidence, seed=seed, tell=tell)
        return replace(evidence, bound=bound)
    return evidence

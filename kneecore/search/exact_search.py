"""The exact search in the place of the genetic algorithm: the same outcome, with its evidence."""

import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ParameterError
from kneecore.knee.model import KneeModel, Objective
from kneecore.numerics.box_climb import Slopes
from kneecore.numerics.surrogate import Surrogate
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.exact_model import exact_worst_case
from kneecore.search.genetic_search import Found, PairOutcome, checked_weights, verified
from kneecore.search.settings import PairSettings
from kneecore.search.sign_climb import ExactSettings, climb_pair
from kneecore.search.training import UnitModel, train

__all__ = ["climb_surrogate", "exact_in_knee", "exact_in_surrogate"]

FloatArray = NDArray[np.float64]


def _slopes(surrogate: Surrogate) -> Slopes:
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
    surrogate: Surrogate,
    weights: FloatArray,
    settings: PairSettings,
    callback: Callback | None = None,
    order: Sequence[int] | None = None,
) -> Found:
    """Find the most different pair of a surrogate by climbs with its exact gradient.

    `order` is that of `kneecore.search.sign_climb.sign_patterns`.
    """
    if weights.min() < 0.0:
        raise ParameterError(
            f"`weights` has {weights.min():g}; the method 'exact' takes numbers of at least 0"
        )
    watch = _Watch(callback)
    found = climb_pair(
        _slopes(surrogate),
        surrogate.n_dimensions,
        weights,
        order=order,
        settings=ExactSettings(seed=settings.seed),
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


def exact_in_surrogate(
    model: UnitModel,
    n_dimensions: int,
    weights: FloatArray | None,
    settings: PairSettings,
    callback: Callback | None = None,
    order: Sequence[int] | None = None,
) -> PairOutcome:
    """Find the most different pair of a surrogate; the arguments are those of `find_pair`.

    `order` is that of `climb_surrogate`.
    """
    training = train(model, n_dimensions, settings, callback)
    wanted = checked_weights(weights, training.surrogate.n_values)
    begun = time.perf_counter()
    found = climb_surrogate(training.surrogate, wanted, settings, callback, order)
    return verified(model, found, training, wanted, begun)


def exact_in_knee(
    model: KneeModel, objective: Objective, settings: PairSettings, callback: Callback | None = None
) -> PairOutcome:
    """Find the most different pair of knees in the true model, in the response of `model`."""
    watch = _Watch(callback)
    watch.begin()
    begun = time.perf_counter()
    found = exact_worst_case(
        model.space,
        objective=objective,
        solver=model.solver,
        rest_length=model.rest_length,
        seed=settings.seed,
        threads=model.threads,
        report=watch,
    )
    evidence = found.evidence
    model.n_simulated += evidence.n_evaluations + evidence.n_in_motion
    model.n_failed += evidence.n_lost
    return PairOutcome(
        u=found.u,
        y=found.flexion_deg,
        y_surrogate=None,
        objective_surrogate=None,
        objective_model=found.objective,
        training=None,
        run_values=(found.objective,),
        best_run=0,
        history=np.array([*watch.history, found.objective]),
        n_evaluations=0,
        stop_reason=watch.stop_reason,
        seconds={
            "sampling": 0.0,
            "fit": 0.0,
            "search": time.perf_counter() - begun,
            "verify": 0.0,
        },
        evidence=evidence,
    )

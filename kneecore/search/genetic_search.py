"""The worst case by the paper's genetic algorithm, in a surrogate or in the model itself."""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from kneecore.numerics.genetic import GeneticResult, maximize
from kneecore.numerics.pair import ModelPair, SurrogatePair
from kneecore.progress import Callback, Progress
from kneecore.record import Arrays, KeptStep, kept_step, recording
from kneecore.search.discrete import OnGrids
from kneecore.search.problem import Found, Outcome, Problem, verified
from kneecore.search.settings import SearchSettings
from kneecore.search.training import Training, train
from kneecore.unit_model import UnitModel

__all__ = ["find_pair", "search_pair"]


def run_seed(seed: int, run: int) -> int:
    """Return the seed of one of several runs; the first is the seed itself."""
    if run == 0:
        return seed
    state = np.random.SeedSequence([seed, run]).generate_state(1, np.uint64)
    return int(state[0] >> np.uint64(1))


class _KeptRun:
    """The state of a run in the model, with the model's counts and the time in it."""

    def __init__(self, step: KeptStep, model: UnitModel) -> None:
        self._step, self._model = step, model
        self._seconds, self._start = 0.0, time.perf_counter()

    def load(self) -> Arrays | None:
        """Return the state in which the run was left, and set the counts as they were."""
        state = self._step.load()
        if state is not None:
            self._seconds = float(state["seconds"])
            self._model.seconds_before += self._seconds
            self._model.n_simulated = int(state["n_simulated"])
            for name, count in zip(self._model.counts, state["counts"], strict=True):
                self._model.counts[name] = int(count)
        return state

    def save(self, state: Callable[[], Arrays], *, now: bool = False) -> None:
        """Keep a state of the genetic algorithm."""
        model = self._model

        def whole() -> Arrays:
            return {
                **state(),
                "n_simulated": np.array(model.n_simulated),
                "counts": np.array(list(model.counts.values())),
                "seconds": np.array(self._seconds + time.perf_counter() - self._start),
            }

        self._step.save(whole, now=now)


def _maximized(
    objective: ModelPair | SurrogatePair, settings: SearchSettings, run: int, **arguments: Any
) -> GeneticResult:
    """Run the genetic algorithm once; in a model its state is kept, not the single runs."""
    if isinstance(objective, ModelPair) and isinstance(objective.model, UnitModel):
        model = objective.model
        weights = objective.weights.tolist()
        step = kept_step("genetic", model.model.identity, settings, weights, run)
        if step is not None:
            with recording(None):
                return maximize(objective, kept=_KeptRun(step, model), **arguments)
    return maximize(objective, **arguments)


def _run_all(
    objective: ModelPair | SurrogatePair,
    n_dimensions: int,
    settings: SearchSettings,
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
            _maximized(
                objective,
                settings,
                run,
                lower=np.zeros(2 * n_dimensions),
                upper=np.ones(2 * n_dimensions),
                pop_size=settings.pop_size,
                n_generations=per_run,
                options=settings.options,
                seed=run_seed(settings.seed, run),
                callback=watch,
            )
        )
        if results[-1].stop_reason == "cancelled":
            break
    return results


def search_pair(
    objective: ModelPair | SurrogatePair,
    n_dimensions: int,
    settings: SearchSettings,
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


def _surrogate_pair(problem: Problem, training: Training) -> ModelPair | SurrogatePair:
    model, surrogate = problem.model.model, training.surrogate
    if model.grids:
        return ModelPair(OnGrids(surrogate, model), problem.weights)
    return SurrogatePair(surrogate, problem.weights, problem.threads)


def find_pair(problem: Problem) -> Outcome:
    """Find the two points of the unit cube whose outputs differ most.

    Raises
    ------
    Cancelled
        If it was cancelled before the genetic algorithm had begun.
    """
    settings, callback = problem.settings, problem.callback
    training = None
    objective: ModelPair | SurrogatePair = ModelPair(problem.model, problem.weights)
    if settings.search_space == "surrogate":
        training = train(problem.model, settings, callback)
        objective = _surrogate_pair(problem, training)
    begun = time.perf_counter()
    found = search_pair(objective, problem.n_dimensions, settings, callback)
    found = replace(found, u=problem.model.model.snapped(found.u))
    begun -= problem.model.seconds_before  # before it was stopped, if it was
    if callback is not None:
        callback(Progress(stage="verify", done=0, total=2, best=found.value, run=found.best_run))
    return verified(problem, found, training, begun)

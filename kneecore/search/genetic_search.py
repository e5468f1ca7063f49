"""The worst case by the paper's genetic algorithm, in a surrogate or in the model itself."""

import time

import numpy as np

from kneecore.numerics.genetic import GeneticResult, maximize
from kneecore.numerics.pair import ModelPair, SurrogatePair
from kneecore.progress import Callback, Progress
from kneecore.search.problem import Found, Outcome, Problem, verified
from kneecore.search.settings import SearchSettings
from kneecore.search.training import train

__all__ = ["find_pair", "search_pair"]


def run_seed(seed: int, run: int) -> int:
    """Return the seed of one of several runs; the first is the seed itself."""
    if run == 0:
        return seed
    state = np.random.SeedSequence([seed, run]).generate_state(1, np.uint64)
    return int(state[0] >> np.uint64(1))


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
            maximize(
                objective,
                np.zeros(2 * n_dimensions),
                np.ones(2 * n_dimensions),
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
        objective = SurrogatePair(training.surrogate, problem.weights, problem.threads)
    begun = time.perf_counter()
    found = search_pair(objective, problem.n_dimensions, settings, callback)
    if callback is not None:
        callback(Progress(stage="verify", done=0, total=2, best=found.value, run=found.best_run))
    return verified(problem, found, training, begun)

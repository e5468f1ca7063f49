"""The search's methods side by side: the best f found against the models that it took.

Every f is the true model's own; where a method searched a surrogate, what that had promised stands
beside it.

Examples
--------
>>> from kneecore import ParameterSpace
>>> from kneecore.search.compare import compare_methods
>>> found = compare_methods(ParameterSpace(case="material"), solver="equilibrium")
>>> best = max(m.objective[-1] for m in found.values())
>>> bool(found["exact"].shortfall_percent(best) < 0.01)
True
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore.knee.model import Objective
from kneecore.knee.response import RestLength, Solver
from kneecore.knee.space import ParameterSpace
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.result import SearchResult
from kneecore.search.rival import Rival
from kneecore.search.worst_case import worst_case

__all__ = ["MethodTrace", "compare_methods", "with_rivals"]

FloatArray = NDArray[np.float64]

VALIDATION = 100
"""Pairs and generations of the genetic algorithm in the true model: the paper's validation runs."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MethodTrace:
    """How one method came to its worst case."""

    n_models: FloatArray
    """True models run by then, rising, shape (k,)."""
    objective: FloatArray
    """Best f by then, by the true model, deg, shape (k,)."""
    result: SearchResult

    def shortfall_percent(self, best: float) -> float:
        """Return by how much the method's f falls short of `best`, per cent."""
        return 100.0 * (1.0 - float(self.objective[-1]) / best)


def _trace(points: list[tuple[float, float | None]], result: SearchResult) -> MethodTrace:
    best: dict[float, float] = {}  # the last f of each number of models
    for n, f in points:
        if f is not None and np.isfinite(f):
            best[n] = max(f, *best.values()) if best else f
    return MethodTrace(
        n_models=np.array([*best.keys()]), objective=np.array([*best.values()]), result=result
    )


def _genetic(search: Callable[..., SearchResult], callback: Callback) -> MethodTrace:
    """Run the genetic algorithm in the true model; each generation runs as many models."""
    found = search(
        search_space="model", pop_size=VALIDATION, n_generations=VALIDATION, callback=callback
    )
    later = (found.counts["pairs_evaluated"] - VALIDATION) / max(len(found.history) - 1, 1)
    n_models = 2.0 * (VALIDATION + later * np.arange(len(found.history)))
    return _trace(list(zip(n_models.tolist(), found.history.tolist(), strict=True)), found)


def _in_surrogate(search: Callable[..., SearchResult], callback: Callback) -> MethodTrace:
    """Run the paper's main search: the true model knows nothing of it but its end."""
    found = search(search_space="surrogate", callback=callback)
    return _trace([(found.counts["models_simulated"], found.objective_model)], found)


def _repaired(search: Callable[..., SearchResult], callback: Callback) -> MethodTrace:
    """Let the surrogate repair itself: the true f of its optimum after each round."""
    found = search(repair=True, callback=callback)
    assert found.repair is not None
    first = found.training_samples
    points: list[tuple[float, float | None]] = [
        (first + r.n_models, r.objective_model) for r in found.repair.rounds
    ]
    end = (found.counts["models_simulated"], found.objective_model)
    return _trace([*_risen(points), end], found)


def _exact(search: Callable[..., SearchResult], callback: Callback) -> MethodTrace:
    points: list[tuple[float, float | None]] = []

    def watch(report: Progress) -> object:
        if report.best is not None and report.n_models is not None:
            points.append((report.n_models, report.best))
        return callback(report)

    found = search(method="exact", callback=watch)
    evidence = found.evidence
    assert evidence is not None
    if found.solver == "dynamics":  # f at rest is another f
        points = [(evidence.n_evaluations, evidence.objective_before_climb)]
    n_models = evidence.n_evaluations + evidence.n_in_motion
    return _trace([*_risen(points), (n_models, found.objective_model)], found)


def _risen(points: list[tuple[float, float | None]]) -> list[tuple[float, float | None]]:
    """Leave out what tells no better f."""
    kept: list[tuple[float, float | None]] = []
    for n, f in points:
        if f is not None and (not kept or f > (kept[-1][1] or -np.inf)):
            kept.append((n, f))
    return kept


_METHODS: dict[str, Callable[[Callable[..., SearchResult], Callback], MethodTrace]] = {
    "ga_surrogate": _in_surrogate,
    "repair": _repaired,
    "exact": _exact,
    "ga": _genetic,
}


def compare_methods(
    space: ParameterSpace | None = None,
    *,
    objective: Objective = "all",
    solver: Solver = "dynamics",
    rest_length: RestLength = "recomputed",
    seed: int = 0,
    threads: int | None = None,
    callback: Callback | None = None,
) -> Mapping[str, MethodTrace]:
    """Search the same space by all methods.

    Parameters
    ----------
    space, objective, solver, rest_length, seed, threads
        As for `worst_case`.
    callback : callable, optional
        Gets `Progress` over all methods together; a true result cancels.

    Returns
    -------
    mapping of str to MethodTrace
        "ga_surrogate" (the paper's main search, 200 x 800), "repair" (the same in a surrogate that
        repairs itself), "exact" and "ga" (the paper's validation, 100 x 100 in the true model).

    Raises
    ------
    Cancelled
        If the callback cancelled.
    ParameterError, ModelError
        As for `worst_case`.
    """
    space = space or ParameterSpace()
    shared: dict[str, Any] = {
        "objective": objective,
        "solver": solver,
        "rest_length": rest_length,
        "seed": seed,
        "threads": threads,
        "training_samples": max(50, space.n_free + 2),
    }
    done, found = 0, {}
    for k, (name, run) in enumerate(_METHODS.items()):

        def watch(report: Progress, k: int = k) -> bool:
            nonlocal done
            working = report.stage in ("search", "repair")
            share = report.done / max(report.total, 1) if working else 0.0
            done = max(done, round(100 * (k + min(share, 1.0))))
            together = Progress(stage="search", done=done, total=100 * len(_METHODS))
            if callback is not None and callback(together):
                raise Cancelled
            return False

        found[name] = run(lambda **options: worst_case(space, **shared, **options), watch)
    return found


def with_rivals(result: SearchResult, callback: Callback | None = None) -> SearchResult:
    """Return a result with what all methods find in its space beside it.

    The arguments of the methods are the result's: space, loads, solver, rest lengths, seed.

    Raises
    ------
    Cancelled, ParameterError, ModelError
        As for `compare_methods`.
    """
    found = compare_methods(
        result.space,
        objective=result.objective,
        solver=result.solver,
        rest_length=result.rest_length,
        seed=result.seed,
        threads=result.threads,
        callback=callback,
    )
    rivals = tuple(
        Rival(
            method=name,
            promised=trace.result.objective_surrogate,
            n_models=tuple(trace.n_models.tolist()),
            objective=tuple(trace.objective.tolist()),
        )
        for name, trace in found.items()
    )
    seconds = {
        f"compare_{name}": sum(v for k, v in trace.result.seconds.items() if k != "compile")
        for name, trace in found.items()
    }
    return replace(result, rivals=rivals, seconds={**result.seconds, **seconds})

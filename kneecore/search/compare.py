"""The search's methods side by side: the best f found against the models that it took.

Every f is the true model's own; where a method searched a surrogate, what that had promised stands
beside it.

Examples
--------
>>> import kneecore
>>> knee = kneecore.Knee(kneecore.ParameterSpace(case="material"), solver="equilibrium")
>>> found = {m.method: m for m in kneecore.compare_methods(knee)}
>>> best = max(m.objective[-1] for m in found.values())
>>> bool(found["exact"].shortfall_percent(best) < 0.01)
True
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kneecore._arguments import callback_or_none
from kneecore.budget import Budget
from kneecore.model import Model
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.arguments import checked
from kneecore.search.budget import search_budget
from kneecore.search.result import MethodTrace, SearchResult
from kneecore.search.settings import SearchSettings, enough_samples
from kneecore.search.worst_case import worst_case

__all__ = ["compare_methods", "comparison_budgets", "with_methods"]

Search = Callable[..., SearchResult]

VALIDATION = 100
"""Pairs and generations of the genetic algorithm in the true model: the paper's validation runs."""


Points = list[tuple[float, float | None]]
"""Models run by then, and f; None where it is not known."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Traced:
    """A method's trace, and the search behind it."""

    trace: MethodTrace
    result: SearchResult


def _traced(method: str, points: Points, result: SearchResult) -> Traced:
    best: dict[float, float] = {}  # the last f of each number of models
    for n, f in points:
        if f is not None and np.isfinite(f):
            best[float(n)] = max(f, *best.values()) if best else f
    trace = MethodTrace(
        method=method,
        promised=result.objective_surrogate,
        n_models=tuple(best),
        objective=tuple(float(f) for f in best.values()),
        seconds=sum(v for k, v in result.seconds.items() if k != "compile"),
    )
    return Traced(trace=trace, result=result)


def _genetic(search: Search, callback: Callback) -> Traced:
    """Run the genetic algorithm in the true model; each generation runs as many models."""
    found = search(**_OPTIONS["ga"], callback=callback)
    later = (found.counts["pairs_evaluated"] - VALIDATION) / max(len(found.history) - 1, 1)
    n_models = 2.0 * (VALIDATION + later * np.arange(len(found.history)))
    return _traced("ga", list(zip(n_models.tolist(), found.history.tolist(), strict=True)), found)


def _in_surrogate(search: Search, callback: Callback) -> Traced:
    """Run the paper's main search: the true model knows nothing of it but its end."""
    found = search(**_OPTIONS["ga_surrogate"], callback=callback)
    end = (found.counts["models_simulated"], found.objective_model)
    return _traced("ga_surrogate", [end], found)


def _repaired(search: Search, callback: Callback) -> Traced:
    """Let the surrogate repair itself: the true f of its optimum after each round."""
    found = search(**_OPTIONS["repair"], callback=callback)
    assert found.repair is not None
    first = found.settings.n_training
    points: Points = [(first + r.n_models, r.objective_model) for r in found.repair.rounds]
    end = (found.counts["models_simulated"], found.objective_model)
    return _traced("repair", [*_risen(points), end], found)


def _exact(search: Search, callback: Callback) -> Traced:
    points: Points = []

    def watch(report: Progress) -> object:
        if report.best is not None and report.n_models is not None:
            points.append((report.n_models, report.best))
        return callback(report)

    found = search(**_OPTIONS["exact"], callback=watch)
    evidence = found.evidence
    assert evidence is not None
    if evidence.objective_before_climb is not None:  # the proxy's f is another f
        points = [(evidence.n_evaluations, evidence.objective_before_climb)]
    n_models = evidence.n_evaluations + evidence.n_models
    return _traced("exact", [*_risen(points), (n_models, found.objective_model)], found)


def _risen(points: Points) -> Points:
    """Leave out what tells no better f."""
    kept: Points = []
    for n, f in points:
        if f is not None and (not kept or f > (kept[-1][1] or -np.inf)):
            kept.append((n, f))
    return kept


_METHODS: dict[str, Callable[[Search, Callback], Traced]] = {
    "ga_surrogate": _in_surrogate,
    "repair": _repaired,
    "exact": _exact,
    "ga": _genetic,
}


def methods_of(model: Model) -> tuple[str, ...]:
    """Return the methods that can search a model: the exact one needs gradients."""
    gradient = model.has_gradient or model.proxy is not None
    return tuple(name for name in _METHODS if gradient or name != "exact")


def _shared(model: Model, settings: SearchSettings) -> dict[str, Any]:
    """Return the options that all methods have."""
    return {
        "objective": settings.objective,
        "weights": settings.weights,
        "seed": settings.seed,
        "training_samples": enough_samples(model.n_free),
    }


_OPTIONS: dict[str, dict[str, Any]] = {
    "ga_surrogate": {"method": "ga", "search_space": "surrogate", "repair": False},
    "repair": {"repair": True},
    "exact": {"method": "exact"},
    "ga": {
        "method": "ga",
        "search_space": "model",
        "pop_size": VALIDATION,
        "n_generations": VALIDATION,
    },
}


def comparison_budgets(model: Model, settings: SearchSettings) -> list[Budget]:
    """Return what the methods ask for, one by one."""
    shared = _shared(model, settings)
    asked = [SearchSettings(**shared, **_OPTIONS[name]) for name in methods_of(model)]
    return [search_budget(one.of(model), model) for one in asked]


def _run_all(model: Model, settings: SearchSettings, callback: Callback | None) -> list[Traced]:
    shared = _shared(model, settings)
    names = methods_of(model)
    done, found = 0, []
    for k, name in enumerate(names):

        def watch(report: Progress, k: int = k) -> bool:
            nonlocal done
            working = report.stage in ("search", "repair")
            share = report.done / max(report.total, 1) if working else 0.0
            done = max(done, round(100 * (k + min(share, 1.0))))
            together = Progress(stage="search", done=done, total=100 * len(names))
            if callback is not None and callback(together):
                raise Cancelled
            return False

        def search(*, callback: Callback, **options: Any) -> SearchResult:
            return worst_case(model, SearchSettings(**shared, **options), callback=callback)

        found.append(_METHODS[name](search, watch))
    return found


def compare_methods(
    model: Model, settings: SearchSettings | None = None, *, callback: Callback | None = None
) -> tuple[MethodTrace, ...]:
    """Search the same bounds by all methods that a model allows.

    Parameters
    ----------
    model : Model
    settings : SearchSettings, optional
        Its objective, weights and seed are used.
    callback : callable, optional
        Gets `Progress` over all methods together; a true result cancels.

    Returns
    -------
    tuple of MethodTrace
        "ga_surrogate" (the paper's main search, 200 x 800), "repair" (the same in a surrogate that
        repairs itself), "exact" (where there are gradients) and "ga" (the paper's validation,
        100 x 100 in the true model).

    Raises
    ------
    Cancelled
        If the callback cancelled.
    ParameterError, ModelError
        As for `worst_case`.
    """
    settings = checked(model, settings, callback)
    return tuple(t.trace for t in _run_all(model, settings, callback))


def with_methods(result: SearchResult, callback: Callback | None = None) -> SearchResult:
    """Return a result with what all methods find in its bounds beside it.

    Raises
    ------
    Cancelled, ParameterError, ModelError
        As for `compare_methods`.
    """
    callback_or_none(callback)
    found = _run_all(result.model, result.settings, callback)
    seconds = {f"compare_{t.trace.method}": t.trace.seconds for t in found}
    return replace(
        result,
        methods=tuple(t.trace for t in found),
        seconds={**result.seconds, **seconds},
    )

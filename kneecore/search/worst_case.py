"""The worst case: the two most different models within the uncertainty of their inputs.

Examples
--------
Any mechanism will do. Two coupled springs, stiff within 10 per cent; the output is the stretch
under three loads:

>>> import numpy as np
>>> import kneecore
>>> from kneecore import Input, Output
>>> springs = kneecore.Model(
...     lambda k: np.outer(1.0 / k[:, 0] + 1.0 / k[:, 1], [1.0, 2.0, 5.0]),
...     inputs=[Input("k_1", nominal=100.0, tolerance_percent=10, unit="N/mm"),
...             Input("k_2", nominal=50.0, tolerance_percent=10, unit="N/mm")],
...     outputs=[Output("stretch", unit="mm", axis=[1.0, 2.0, 5.0], axis_unit="N")],
...     batched=True,
... )
>>> settings = kneecore.SearchSettings(training_samples=20, pop_size=50, n_generations=50)
>>> pair = kneecore.worst_case(springs, settings)
>>> np.sort(pair.x[:, 0]).round(3)
array([ 90., 110.])
"""

import time
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore._threads import thread_count
from kneecore._version import versions
from kneecore.model import Model
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.arguments import checked
from kneecore.search.exact_search import exact_in_model, exact_in_surrogate
from kneecore.search.genetic_search import find_pair
from kneecore.search.inside_search import find_inside_pair
from kneecore.search.offered import judged_and_offered
from kneecore.search.problem import Outcome, Problem
from kneecore.search.repair import find_repaired_pair
from kneecore.search.result import MODELS, SearchResult, gap_percent
from kneecore.search.settings import SearchSettings
from kneecore.search.warm_up import warm_up
from kneecore.unit_model import UnitModel

__all__ = ["find", "usual_settings", "worst_case"]

FloatArray = NDArray[np.float64]


def find(problem: Problem) -> Outcome:
    """Search as the problem's settings say."""
    settings = problem.settings
    if settings.repair:
        model = problem.model.model
        in_corners = model.in_corners and not model.grids
        return find_repaired_pair(problem) if in_corners else find_inside_pair(problem)
    if settings.method == "ga":
        return find_pair(problem)
    return (
        exact_in_model(problem) if settings.search_space == "model" else exact_in_surrogate(problem)
    )


def worst_case(
    model: Model,
    settings: SearchSettings | None = None,
    *,
    callback: Callback | None = None,
) -> SearchResult:
    """Find the two most different models within bounds.

    The search maximises f, the weighted sum over the outputs of |y(x_1) - y(x_2)|, the genetic
    algorithm over both models at once; the best pair is always computed again in the true model.

    Parameters
    ----------
    model : Model
        Such as `Knee`.
    settings : SearchSettings, optional
        How to search. What is left open is decided for the model: the paper's main run for a knee;
        for other models climbs with exact gradients where there are any, else a surrogate that is
        repaired within 150 runs, or 100 more than it is fitted to.
    callback : callable, optional
        Gets `Progress` reports; a true result cancels. A search that has begun returns what it has
        found, with the `stop_reason` "cancelled".

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    ModelError
        If too many models failed to say anything.
    Cancelled
        If the callback cancelled before the search had begun.
    """
    settings = checked(model, settings, callback).of(model)
    counted = UnitModel(model)
    started = time.perf_counter()
    if callback is not None and callback(Progress(stage="compile", done=0, total=1)):
        raise Cancelled
    warm_up(model, settings)
    compiled = time.perf_counter() - started
    problem = Problem(
        model=counted,
        weights=model.weights(settings.objective, settings.weights),
        settings=settings,
        callback=callback,
        result_of=lambda found, counted: _result(replace(problem, model=counted), found, compiled),
    )
    outcome = find(problem)
    if outcome.training is not None and not model.in_corners and not settings.repair:
        outcome = judged_and_offered(outcome, problem.weights)
    return _result(problem, outcome, compiled)


def usual_settings(model: Model) -> SearchSettings:
    """Return how `worst_case` searches a model if nothing is asked for."""
    return SearchSettings().of(model)


def _order(outcome: Outcome, column: int) -> list[int]:
    """Return the two models' places, the one with the smaller output in `column` first."""
    y = outcome.y[:, column]
    if not np.isfinite(y).all() and outcome.y_surrogate is not None:
        y = outcome.y_surrogate[:, column]
    return [1, 0] if y[0] > y[1] else [0, 1]


def _nominal(counted: UnitModel, x: FloatArray) -> tuple[FloatArray, dict[str, Any]]:
    """Return the nominal model's outputs, and what the model tells of it and of the pair."""
    model = counted.model
    told = model.responses(np.vstack([model.nominal, x]))
    y = (
        counted.model.examine(model.nominal[None]).y[0]
        if told
        else counted(model.to_free_unit(model.nominal)[None])[0]
    )
    return y, dict(zip(MODELS, told, strict=True)) if told else {}


def _result(problem: Problem, outcome: Outcome, compiled: float) -> SearchResult:
    counted, found, training = problem.model, outcome.found, outcome.training
    model = counted.model
    order = _order(outcome, model.watched)
    x = model.from_free_unit(found.u[order])
    y_nominal, responses = _nominal(counted, x)
    predicted = outcome.y_surrogate
    return SearchResult(
        model=model,
        settings=problem.settings,
        x=x,
        y=outcome.y[order],
        y_nominal=y_nominal,
        y_surrogate=None if predicted is None else predicted[order],
        responses=responses,
        objective_surrogate=outcome.objective_surrogate,
        objective_model=outcome.objective_model,
        gap_percent=gap_percent(outcome.objective_surrogate, outcome.objective_model),
        training_x=model.from_free_unit(training.points) if training else None,
        training_y=training.values if training else None,
        loo_rms=training.loo_rms if training else None,
        run_values=found.run_values,
        history=found.history,
        stop_reason=found.stop_reason,
        counts={"pairs_evaluated": found.n_evaluations, **counted.told},
        seconds={"compile": compiled, **outcome.seconds},
        threads=thread_count(model.threads),
        versions=versions(),
        evidence=found.evidence,
        repair=outcome.repair,
        verdict=outcome.verdict,
    )

"""The worst case: the two most different models within the uncertainty of the parameters.

Examples
--------
Any mechanism will do. Two coupled springs, stiff within 10 per cent; the output is the stretch
under three loads:

>>> import numpy as np
>>> import kneecore
>>> def stretch(k):
...     return np.outer(1.0 / k[:, 0] + 1.0 / k[:, 1], [1.0, 2.0, 5.0])
>>> pair = kneecore.worst_case(
...     model=stretch, lower=[90.0, 45.0], upper=[110.0, 55.0], training_samples=20,
...     pop_size=50, n_generations=50,
... )
>>> np.sort(pair.x[:, 0]).round(3)
array([ 90., 110.])
"""

import time
from collections.abc import Callable, Sequence
from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._threads import thread_count
from kneecore.errors import ParameterError
from kneecore.knee.model import KneeModel, Objective, load_weights
from kneecore.knee.response import RestLength, Solver, check_solver, simulate_batch
from kneecore.knee.space import ParameterSpace
from kneecore.numerics.genetic_options import GeneticOptions
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.exact_model import ALONG_LOADS
from kneecore.search.exact_search import exact_in_knee, exact_in_surrogate
from kneecore.search.genetic_search import PairOutcome, find_pair
from kneecore.search.repair import find_repaired_pair
from kneecore.search.result import LARGEST_EXTENSION, PairResult, SearchResult, versions
from kneecore.search.settings import Method, PairSettings, SearchSpace, default_space
from kneecore.search.warm_up import warm_up

__all__ = ["worst_case"]

FloatArray = NDArray[np.float64]
BatchedModel = Callable[[FloatArray], ArrayLike]


@overload
def worst_case(
    space: ParameterSpace | None = None,
    *,
    method: Method = ...,
    search_space: SearchSpace | None = ...,
    training_samples: int = ...,
    pop_size: int = ...,
    n_generations: int = ...,
    n_runs: int = ...,
    objective: Objective = ...,
    seed: int = ...,
    repair: bool = ...,
    repair_gap_percent: float = ...,
    repair_models: int = ...,
    rest_length: RestLength = ...,
    solver: Solver = ...,
    threads: int | None = ...,
    options: GeneticOptions | None = ...,
    callback: Callback | None = ...,
) -> SearchResult: ...


@overload
def worst_case(
    space: None = None,
    *,
    model: BatchedModel,
    lower: ArrayLike,
    upper: ArrayLike,
    names: Sequence[str] | None = ...,
    weights: ArrayLike | None = ...,
    method: Method = ...,
    search_space: SearchSpace | None = ...,
    training_samples: int = ...,
    pop_size: int = ...,
    n_generations: int = ...,
    n_runs: int = ...,
    seed: int = ...,
    repair: bool = ...,
    repair_gap_percent: float = ...,
    repair_models: int = ...,
    options: GeneticOptions | None = ...,
    callback: Callback | None = ...,
) -> PairResult: ...


def worst_case(
    space: ParameterSpace | None = None,
    *,
    model: BatchedModel | None = None,
    lower: ArrayLike | None = None,
    upper: ArrayLike | None = None,
    names: Sequence[str] | None = None,
    weights: ArrayLike | None = None,
    method: Method = "ga",
    search_space: SearchSpace | None = None,
    training_samples: int = 50,
    pop_size: int = 200,
    n_generations: int = 800,
    n_runs: int = 1,
    objective: Objective = "all",
    seed: int = 0,
    repair: bool = False,
    repair_gap_percent: float = 1.0,
    repair_models: int = 40,
    rest_length: RestLength = "recomputed",
    solver: Solver = "dynamics",
    threads: int | None = None,
    options: GeneticOptions | None = None,
    callback: Callback | None = None,
) -> SearchResult | PairResult:
    """Find the two most different models within bounds.

    The search maximises the sum over the outputs of |y(x_1) - y(x_2)|, the genetic algorithm over
    both models at once; the best pair is always computed again in the true model.

    Parameters
    ----------
    space : ParameterSpace, optional
        The knees to search; the packaged baseline with its default bounds for None.
    model : callable, optional
        A model of your own in the knee's place: maps (n, d) inputs to (n, m) outputs; a row of NaN
        is a failure. Needs `lower` and `upper`, and excludes `space`.
    lower, upper : array_like, shape (d,), optional
        Bounds of your own model's inputs.
    names : sequence of str, optional
        Names of its inputs.
    weights : array_like, shape (m,), optional
        Weight of each of its outputs' difference; ones for None.
    method : {"ga", "exact"}
        The paper's genetic algorithm, or climbs with exact gradients (`search.sign_climb`),
        which need none of its options.
    search_space : {"surrogate", "model"}, optional
        What the search evaluates; for None, "model" for the knee with exact gradients and without
        `repair`, otherwise "surrogate".
    training_samples : int
        Model runs that the surrogate is fitted to.
    pop_size, n_generations : int
        Size of the search; 200 x 800 is the paper's main run.
    n_runs : int
        Independent runs; the best is kept, the spread reported.
    objective : {"all", "extension", "flexion"}
        Which of the knee's 12 loads count.
    seed : int
        The same seed gives the same bytes, on any number of threads.
    repair : bool
        Whether to repair the surrogate around its own optimum (`kneecore.search.repair`).
    repair_gap_percent : float
        Gap between surrogate and model at the optimum, per cent, below which it counts as
        repaired.
    repair_models : int
        Model runs that a repair may add to the training samples. Those that the gap does not need
        look for a pair that is better in the true model.
    rest_length, solver, threads
        As for `simulate_batch`; a knee that has lost its equilibrium is left out and counted.
    options : GeneticOptions, optional
        The genetic algorithm's constants.
    callback : callable, optional
        Gets `Progress` reports; a true result cancels. A search that has begun returns what it has
        found, with the `stop_reason` "cancelled".

    Returns
    -------
    SearchResult
        For the knee; a `PairResult` for a model of your own.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    ModelError
        If too many models failed to say anything.
    Cancelled
        If the callback cancelled before the search had begun.
    """
    if search_space is None:
        search_space = default_space(method, repair=repair) if model is None else "surrogate"
    settings = PairSettings(
        method=method,
        search_space=search_space,
        training_samples=training_samples,
        pop_size=pop_size,
        n_generations=n_generations,
        n_runs=n_runs,
        options=options or GeneticOptions(),
        seed=seed,
        repair=repair,
        repair_gap_percent=repair_gap_percent,
        repair_models=repair_models,
    )
    if model is None:
        if lower is not None or upper is not None or names is not None or weights is not None:
            raise ParameterError(
                "`lower`, `upper`, `names`, `weights` need a `model`; for the knee use `space`"
            )
        if not isinstance(space, ParameterSpace | None):
            raise ParameterError(f"`space` is {space!r}; a ParameterSpace is allowed")
        return _worst_knees(
            space or ParameterSpace(), settings, objective, rest_length, solver, threads, callback
        )
    if space is not None:
        raise ParameterError("`space` and `model` are given; only one of them is allowed")
    if not callable(model):
        raise ParameterError(f"`model` is {model!r}; a function of inputs (n, d) is allowed")
    usual = objective == "all" and rest_length == "recomputed" and solver == "dynamics"
    if not usual or threads is not None:
        raise ParameterError(
            "`objective`, `rest_length`, `solver`, `threads` are the knee's, not a `model`'s"
        )
    if method == "exact" and settings.search_space == "model":
        raise ParameterError(
            "`search_space` is 'model'; the method 'exact' has no gradients of a `model` of your "
            "own, and searches its surrogate"
        )
    return _worst_pair(model, lower, upper, names, weights, settings, callback)


def _worst_knees(
    space: ParameterSpace,
    settings: PairSettings,
    objective: Objective,
    rest_length: RestLength,
    solver: Solver,
    threads: int | None,
    callback: Callback | None,
) -> SearchResult:
    check_solver(solver)
    weights = load_weights(objective)
    settings.check_training(space.n_free)
    n_threads = thread_count(threads)
    model = KneeModel(space, rest_length, n_threads, solver)
    started = time.perf_counter()
    if callback is not None and callback(Progress(stage="compile", done=0, total=1)):
        raise Cancelled
    warm_up(settings.search_space, method=settings.method, solver=solver)
    compiled = time.perf_counter() - started
    if settings.repair:
        outcome = find_repaired_pair(
            model, space.n_free, weights, settings, callback, ALONG_LOADS, n_threads
        )
    elif settings.method == "ga":
        outcome = find_pair(model, space.n_free, weights, settings, callback, n_threads)
    elif settings.search_space == "model":
        outcome = exact_in_knee(model, objective, settings, callback)
    else:
        outcome = exact_in_surrogate(model, space.n_free, weights, settings, callback, ALONG_LOADS)
    counts = {
        "pairs_evaluated": outcome.n_evaluations,
        "models_simulated": model.n_simulated,
        "models_failed": model.n_failed,
        "models_refined": model.n_refined,
        "models_unsettled": model.n_unsettled,
    }
    order = _order(outcome, LARGEST_EXTENSION)
    x = space.from_free_unit(outcome.u[order])
    responses = simulate_batch(
        np.vstack([space.baseline, x]),
        baseline=space.baseline,
        rest_length=rest_length,
        solver=solver,
        threads=1,
    )
    training = outcome.training
    predicted = outcome.y_surrogate
    return SearchResult(
        space=space,
        method=settings.method,
        solver=solver,
        evidence=outcome.evidence,
        repair=outcome.repair,
        search_space=settings.search_space,
        objective=objective,
        rest_length=rest_length,
        x=x,
        baseline=responses[0],
        model_1=responses[1],
        model_2=responses[2],
        predicted_flexion=None if predicted is None else np.radians(predicted[order]),
        objective_surrogate=outcome.objective_surrogate,
        objective_model=outcome.objective_model,
        gap_percent=outcome.gap_percent,
        training_x=space.from_free_unit(training.points) if training else None,
        training_flexion=np.radians(training.values) if training else None,
        loo_rms_deg=training.loo_rms if training else None,
        run_values=outcome.run_values,
        history=outcome.history,
        pop_size=settings.pop_size,
        n_generations=settings.n_generations,
        n_runs=settings.n_runs,
        training_samples=settings.training_samples,
        options=settings.options,
        seed=settings.seed,
        stop_reason=outcome.stop_reason,
        counts=counts,
        seconds={"compile": compiled, **outcome.seconds},
        threads=n_threads,
        versions=versions(),
    )


def _order(outcome: PairOutcome, output: int) -> list[int]:
    """Return the two models' places, the one with the smaller `output` first."""
    y = outcome.y[:, output]
    if not np.isfinite(y).all() and outcome.y_surrogate is not None:
        y = outcome.y_surrogate[:, output]
    return [1, 0] if y[0] > y[1] else [0, 1]


def _numbers(name: str, values: ArrayLike) -> FloatArray:
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError(f"`{name}` is {values!r}; an array of numbers is allowed") from None
    if not np.isfinite(array).all():
        raise ParameterError(f"`{name}` is {values!r}; finite numbers are allowed")
    return array


def _worst_pair(
    model: BatchedModel,
    lower: ArrayLike | None,
    upper: ArrayLike | None,
    names: Sequence[str] | None,
    weights: ArrayLike | None,
    settings: PairSettings,
    callback: Callback | None,
) -> PairResult:
    if lower is None or upper is None:
        raise ParameterError("`lower` and `upper` are needed with a `model`")
    low, high = _numbers("lower", lower), _numbers("upper", upper)
    if low.ndim != 1 or low.shape != high.shape:
        raise ParameterError(
            f"`lower` and `upper` have shapes {low.shape} and {high.shape}; one shape (d,) is "
            "allowed"
        )
    if (low > high).any():
        k = int(np.argmax(low > high))
        raise ParameterError(f"`lower`[{k}] is {low[k]:g}, above `upper`[{k}] = {high[k]:g}")
    free = high > low
    if not free.any():
        raise ParameterError("all bounds have zero width; at least one above 0 is needed")
    if names is not None and len(names) != len(low):
        raise ParameterError(f"`names` has {len(names)} entries; {len(low)} are needed")
    wanted = None if weights is None else _numbers("weights", weights)

    def scale(u: FloatArray) -> FloatArray:
        x = np.broadcast_to(low, (len(u), len(low))).copy()
        x[:, free] = np.clip(low[free] + u * (high - low)[free], low[free], high[free])
        return x

    search = find_pair if settings.method == "ga" else exact_in_surrogate
    if settings.repair:
        search = find_repaired_pair
    outcome = search(
        lambda u: np.asarray(model(scale(u))),
        int(np.count_nonzero(free)),
        wanted,
        settings,
        callback,
    )
    order = _order(outcome, 0)
    return PairResult(
        names=tuple(names) if names else tuple(f"x{k}" for k in range(len(low))),
        lower=low,
        upper=high,
        x=scale(outcome.u[order]),
        y=outcome.y[order],
        objective_surrogate=outcome.objective_surrogate,
        objective_model=outcome.objective_model,
        gap_percent=outcome.gap_percent,
        loo_rms=outcome.training.loo_rms if outcome.training else None,
        n_failed=outcome.training.n_failed if outcome.training else 0,
        run_values=outcome.run_values,
        history=outcome.history,
        n_evaluations=outcome.n_evaluations,
        stop_reason=outcome.stop_reason,
        seed=settings.seed,
        seconds=outcome.seconds,
        repair=outcome.repair,
    )

"""What must agree in a search's result: its value, its gap, its bounds, its samples, its counts."""

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import FileFormatError, KneecoreError, ParameterError
from kneecore.files.bound_relations import check_bound
from kneecore.files.consistent import check_equal, check_finite_or_not, check_holds
from kneecore.files.knee_relations import check_responses
from kneecore.files.model import digits_of
from kneecore.files.run_relations import check_evidence, check_repair, check_runs
from kneecore.knee.model import Knee
from kneecore.knee.parameters import ALL_NAMES
from kneecore.model import Model
from kneecore.numerics.surrogate import Surrogate
from kneecore.search.discrete import combinations
from kneecore.search.problem import pair_value
from kneecore.search.result import SearchResult, gap_percent

__all__ = ["check_search", "check_within"]

FloatArray = NDArray[np.float64]

_PER_CENT = 100.0
_FITTED = 1e-8
"""Share of the samples' range by which another machine's fit may differ."""
_MOST_SAMPLES = 300
"""Samples up to which a surrogate is fitted again: some milliseconds."""


def check_within(where: str, model: Model, x: FloatArray) -> None:
    """Raise a `FileFormatError` if points, shape (n, d), are outside of the model's bounds."""
    d = len(model.inputs)
    if isinstance(model, Knee) and x.ndim == 2 and x.shape[1] == len(ALL_NAMES):
        x = x[:, :d]  # rest lengths that are changed but held have no bounds
    if x.ndim != 2 or x.shape[1] != d:
        raise FileFormatError(f"`{where}` has shape {x.shape}; (n, {d}) is allowed")
    slack = 1e-9 * (model.upper - model.lower + np.abs(model.upper))
    outside = ~((x >= model.lower - slack) & (x <= model.upper + slack))
    if outside.any():
        row, column = (int(i) for i in np.argwhere(outside)[0])
        raise FileFormatError(
            f"`{where}[{row}].{model.names[column]}` is {x[row, column]:g}; its bounds are "
            f"{model.lower[column]:g} to {model.upper[column]:g} (SI)"
        )
    try:
        model.check_allowed(x)
    except ParameterError as error:
        raise FileFormatError(str(error).replace("`x`", f"`{where}`", 1)) from None


def check_search(result: SearchResult) -> None:
    """Raise a `FileFormatError` if a search's result contradicts itself."""
    check_within("parameters", result.model, result.x)
    check_responses(result)
    _check_values(result)
    _check_training(result)
    check_runs(result)
    _check_counts(result)
    check_evidence(result)
    check_bound(result)
    check_repair(result)
    for trace in result.methods:
        where = f"comparison.methods.{trace.method}"
        check_holds(where, np.diff(trace.n_models) >= 0, "`models` never fall")
        check_holds(where, np.diff(trace.objective) >= 0, "`best_by_then` never falls")
        check_holds(
            where,
            len(trace.n_models) == len(trace.objective) or not trace.objective,
            "`models` and `best_by_then` have the same length",
        )


def _check_values(result: SearchResult) -> None:
    weights = result.model.weights(result.settings.objective, result.settings.weights)
    digits = digits_of(result.model)

    def check_f(where: str, said: float | None, y: FloatArray) -> None:
        size = (np.abs(y).sum(axis=0) * weights).sum()
        check_equal(where, said, pair_value(y, weights), digits=digits, size=size)

    check_f("objective_model", result.objective_model, result.y)
    promised, predicted = result.objective_surrogate, result.y_surrogate
    check_holds(
        "objective_surrogate",
        (promised is None) == (predicted is None),
        "it is known where the surrogate's outputs are",
    )
    offered = result.repair is not None or result.verdict is not None
    if predicted is not None and not (offered and np.allclose(predicted, result.y)):
        # A surrogate knows the pair itself where one of its own runs is the best.
        check_f("objective_surrogate", promised, predicted)
    gap = gap_percent(promised, result.objective_model)
    check_equal("gap_percent", result.gap_percent, gap, digits=digits, size=_PER_CENT)


def _check_training(result: SearchResult) -> None:
    x, y = result.training_x, result.training_y
    if x is None or y is None:
        return
    check_holds("training", len(x) == len(y), "`parameters` and outputs have the same length")
    n = min(result.settings.n_training, combinations(result.model))
    n += result.repair.n_models if result.repair else 0
    check_holds("training", len(x) == n, "as many samples as were asked for, and those added")
    check_within("training.parameters", result.model, x)
    check_finite_or_not("training", y)
    check_holds("training.loo_rms", result.loo_rms is None or result.loo_rms >= 0.0, "0 or above")
    known = np.isfinite(y).all(axis=1)
    if np.count_nonzero(known) <= _MOST_SAMPLES:
        _check_fit(result, result.model.to_free_unit(x)[known], y[known])


def _check_fit(result: SearchResult, u: FloatArray, y: FloatArray) -> None:
    """Fit the surrogate again; what it says then is what it has said, up to its rounding."""
    try:
        surrogate = Surrogate.fit(u, y)
    except KneecoreError as error:
        raise FileFormatError(f"`training` gives no surrogate: {error}") from None
    size = float(np.ptp(y)) if len(y) else 0.0
    errors = surrogate.loo_errors
    loo = float(np.sqrt(np.mean(errors**2))) if np.isfinite(errors).all() else None
    check_equal("training.loo_rms", result.loo_rms, loo, size=size, rounding=_FITTED)
    if result.repair is None and result.y_surrogate is not None:
        told = _predicted(surrogate, result.model.to_free_unit(result.x))
        check_equal("predicted", result.y_surrogate, told, size=size, rounding=_FITTED)


def _predicted(surrogate: Surrogate, u: FloatArray) -> FloatArray:
    """Return what a surrogate says of few points, shape (n, d) -> (n, m), without its kernels."""
    d, m = surrogate.n_dimensions, surrogate.n_values
    centres = surrogate.centres[: len(surrogate.points), :d]
    q = ((u[:, None] - centres) ** 2).sum(axis=2)
    curved = (q * np.log(np.where(q > 0.0, q, 1.0))) @ surrogate.weights[:m, : len(centres)].T
    predicted: FloatArray = curved + u @ surrogate.tail[:m, :d].T + surrogate.constant[:m]
    return predicted


def _check_counts(result: SearchResult) -> None:
    runs = result.counts.get("models_simulated", 0)
    for name in result.model.count_names:
        count = result.counts.get(f"models_{name}", 0)
        check_holds(f"counts.models_{name}", count <= runs, "at most the models simulated")
    check_holds("threads", result.threads >= 1, "at least 1")
    _check_failed(result)
    wanted = _models_of(result)
    if wanted is not None:
        wanted += 0 if result.responses else 1  # the nominal inputs
        check_holds("counts.models_simulated", runs == wanted, f"{wanted} follows from the search")


def _failed(y: FloatArray) -> int:
    return int(np.count_nonzero(~np.isfinite(y).all(axis=1)))


def _check_failed(result: SearchResult) -> None:
    """Check the failed models of a search in a surrogate: all that were run are in the file."""
    if result.training_y is None or "failed" not in result.model.count_names:
        return
    failed = _failed(result.training_y)
    failed += result.repair.n_checked_failed if result.repair else _failed(result.y)
    failed += 0 if result.responses else _failed(result.y_nominal[None])
    told, offered = result.counts.get("models_failed", 0), result.verdict and not result.repair
    # The pair that failed is not in the file where a better one was offered.
    fits = failed <= told <= failed + 2 if offered else told == failed
    check_holds("counts.models_failed", fits, f"{failed} follows from the samples and the pair")


def _models_of(result: SearchResult) -> int | None:
    """Return how many models a search has run, as far as the result tells."""
    evidence, pairs = result.evidence, result.counts.get("pairs_evaluated", 0)
    if result.training_x is not None:
        return len(result.training_x) + (result.repair.n_checked if result.repair else 2)
    if result.settings.method == "ga":
        return 2 * pairs + 2
    return None if evidence is None else evidence.n_evaluations + evidence.n_models

"""What must agree in a search's result: its value, its gap, its bounds, its history."""

import math

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import FileFormatError
from kneecore.files.consistent import check_equal, check_finite_or_not, check_holds
from kneecore.knee.model import Knee
from kneecore.knee.parameters import ALL_NAMES
from kneecore.knee.response import Response
from kneecore.model import Model
from kneecore.search.problem import pair_value
from kneecore.search.result import Evidence, Repair, SearchResult, gap_percent

__all__ = ["check_response", "check_search", "check_within"]

FloatArray = NDArray[np.float64]

_SINGLE = 1e-4
"""The surrogate's search has single precision."""
_FIELDS = ("flexion", "tension", "contact_force", "indentation", "ap_position", "tibia_position")


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


def check_response(response: Response, name: str = "") -> None:
    """Raise a `FileFormatError` if a knee's numbers do not fit its status."""
    place = f".{name}" if name else ""
    known = response.refinements >= 0
    for field in _FIELDS:
        values = np.isfinite(getattr(response, field))
        if known and math.isnan(response.lost_at) and not values.all():
            raise FileFormatError(
                f"`{field}{place}` lacks numbers, and `status{place}` is {response.status!r}"
            )
        if not known and values.any():
            raise FileFormatError(f"`{field}{place}` has numbers, and `status{place}` is 'failed'")


def check_search(result: SearchResult) -> None:
    """Raise a `FileFormatError` if a search's result contradicts itself."""
    model = result.model
    check_within("parameters", model, result.x)
    for name, response in result.responses.items():
        if isinstance(model, Knee):
            check_response(response, name)
    _check_values(result)
    _check_training(result)
    _check_history(result)
    _check_counts(result)
    _check_evidence(result.evidence)
    _check_repair(result.repair)
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
    check_equal("objective_model", result.objective_model, pair_value(result.y, weights))
    promised = result.objective_surrogate
    check_holds(
        "objective_surrogate",
        (promised is None) == (result.y_surrogate is None),
        "it is known where the surrogate's outputs are",
    )
    if result.y_surrogate is not None and promised is not None:
        f = pair_value(result.y_surrogate, weights)
        if result.repair is None:
            check_equal("objective_surrogate", promised, f)
    check_equal("gap_percent", result.gap_percent, gap_percent(promised, result.objective_model))


def _check_training(result: SearchResult) -> None:
    x, y = result.training_x, result.training_y
    if x is None or y is None:
        return
    check_holds("training", len(x) == len(y), "`parameters` and outputs have the same length")
    check_within("training.parameters", result.model, x)
    check_finite_or_not("training", y)
    check_holds("training.loo_rms", result.loo_rms is None or result.loo_rms >= 0.0, "0 or above")


def _check_history(result: SearchResult) -> None:
    values, history = np.array(result.run_values), result.history
    if result.settings.method == "ga" and result.repair is None and len(values):
        f = result.objective_surrogate
        f = result.objective_model if f is None else f
        if f is not None:
            check_equal("search.run_values", values.max(), f, _SINGLE)
        if len(history):
            check_equal("search.history", history[-1], values.max(), _SINGLE)
            rises = np.diff(history) >= -_SINGLE * np.abs(history[1:])
            check_holds("search.history", rises, "it never falls")


def _check_counts(result: SearchResult) -> None:
    runs = result.counts.get("models_simulated", 0)
    for name in result.model.count_names:
        count = result.counts.get(f"models_{name}", 0)
        check_holds(f"counts.models_{name}", count <= runs, "at most the models simulated")
    check_holds("threads", result.threads >= 1, "at least 1")


def _check_evidence(evidence: Evidence | None) -> None:
    if evidence is None:
        return
    check_holds("evidence.share_reached", 0.0 <= evidence.share_reached <= 1.0, "0 to 1")
    check_holds(
        "evidence.models_lost",
        evidence.n_failed <= evidence.n_evaluations,
        "at most the models with a gradient",
    )
    signs = [set(signs) <= {-1, 0, 1} for signs, _ in evidence.patterns]
    check_holds("evidence.patterns", signs, "signs are -1, 0 or 1")


def _check_repair(repair: Repair | None) -> None:
    if repair is None:
        return
    most = "at most the models that were added"
    check_holds("repair.models_failed", repair.n_failed <= repair.n_models, most)
    check_holds("repair.models_added", repair.n_models <= repair.max_models, "at most max_models")
    for one in repair.rounds:
        check_holds("repair.rounds", one.n_models <= repair.n_models, most)
        follows = gap_percent(one.objective_surrogate, one.objective_model)
        check_equal("repair.rounds.gap_percent", one.gap_percent, follows)

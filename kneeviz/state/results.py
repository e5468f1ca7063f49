"""What the page reads of kneecore's results: the one place that knows where they keep it.

The texts about a search (`views.html.result`) and the files that it gives away read the rest.
"""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

import kneecore
from kneecore import Knee, ParameterError, ParameterSpace, Response, SearchResult, Trajectory
from kneecore.knee.response import RestLength

FloatArray = NDArray[np.float64]


def of_knees(result: SearchResult) -> SearchResult:
    """Return a result that the page can show: files and searches may be of any model.

    Raises
    ------
    ParameterError
        If its model is no knee.
    """
    if not isinstance(result.model, Knee):
        raise ParameterError(
            f"`result` is of the model {result.model.name[:60]!r}; results of knees are allowed"
        )
    return result


def space(found: Any) -> ParameterSpace:
    """Return the bounds that a result of any kind belongs to."""
    kept: ParameterSpace = found.model.space
    return kept


def rest_length(found: Any) -> RestLength:
    """Return what a result's knees do with their rest lengths: "recomputed" or "fixed"."""
    kept: RestLength = found.model.rest_length
    return kept


def solver(found: Any) -> str:
    """Return how a result's knees were simulated: "dynamics" or "equilibrium"."""
    return str(found.model.solver)


def seed(found: Any) -> int:
    """Return the seed of a result."""
    return int(found.settings.seed)


def knees(result: SearchResult) -> tuple[tuple[FloatArray, Response], tuple[FloatArray, Response]]:
    """Return both worst cases: parameters, SI, and the true model's answer."""
    one, two = (np.array(x) for x in result.x)
    return (one, result.responses["model_1"]), (two, result.responses["model_2"])


def angles_deg(result: SearchResult) -> FloatArray:
    """Return the two worst cases' angles in the true model, shape (2, 12), deg."""
    return np.degrees([response.flexion for _, response in knees(result)])


def motion(result: SearchResult, x: FloatArray) -> Trajectory:
    """Return the motion in time of one of a result's knees."""
    return kneecore.trajectory(x, baseline=space(result).baseline, rest_length=rest_length(result))


@lru_cache(maxsize=4)
def objective_at_rest(result: SearchResult) -> float | None:
    """Return f of a result's two knees, deg, were both at rest; None if one has no equilibrium."""
    knee = Knee(space(result), solver="equilibrium", rest_length=rest_length(result), threads=1)
    found = knee.simulate_batch(np.array(result.x))
    if found.failed.any() or not np.isnan(found.lost_at).all():
        return None
    one, two = np.degrees(found.flexion)
    weights = knee.weights(result.settings.objective, result.settings.weights)
    return float((np.abs(one - two) * weights).sum())


def same_question(a: SearchResult, b: SearchResult) -> bool:
    """Tell whether two searches were of the same bounds and loads."""
    return same_bounds(a, b) and (a.settings.objective, a.settings.weights) == (
        b.settings.objective,
        b.settings.weights,
    )


def same_bounds(a: Any, b: Any) -> bool:
    """Tell whether two results belong to the same bounds and rest lengths."""
    return (
        np.array_equal(space(a).lower, space(b).lower)
        and np.array_equal(space(a).upper, space(b).upper)
        and rest_length(a) == rest_length(b)
    )

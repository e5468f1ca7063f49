"""The worst pair of a model by the best search that it allows, for studies that need many.

A model with exact gradients, or with another near it that has them, is climbed in itself. Any other
is searched in its surrogate, which is repaired.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ModelError
from kneecore.model import Model
from kneecore.search.exact_model import exact_pair
from kneecore.search.problem import Problem
from kneecore.search.settings import SearchSettings
from kneecore.search.sign_climb import ExactSettings
from kneecore.search.worst_case import find
from kneecore.study.arguments import Steps
from kneecore.unit_model import UnitModel

__all__ = ["PairFound", "best_pair", "one_column", "searches_in_model"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class PairFound:
    """The most different pair that was found."""

    objective: float
    """f in the true model."""
    u: FloatArray
    """The two models in the unit cube of the free inputs, shape (2, n_free)."""
    y: FloatArray
    """The two models' outputs, shape (2, m)."""
    seen: FloatArray
    """Outputs of all models that are known from the search, those of the pair included, (k, m)."""


def searches_in_model(model: Model) -> bool:
    """Tell whether `best_pair` searches in the model itself."""
    return model.has_gradient or model.proxy is not None


def one_column(model: Model, column: int) -> FloatArray:
    """Return weights with which the pair is the least and the largest value of one output."""
    weights = np.zeros(model.n_outputs)
    weights[column] = 1.0
    return weights


def best_pair(model: Model, weights: FloatArray, *, seed: int, steps: Steps) -> PairFound:
    """Find the most different pair of a model for weights (m,) of its outputs' differences.

    The first of the two has the smaller output in the first column that counts, by `Model.order`.

    Raises
    ------
    ModelError
        If no pair could be computed.
    """
    if searches_in_model(model):
        settings = ExactSettings(seed=seed)
        pair = exact_pair(model, weights, settings=settings, report=steps)
        return PairFound(objective=pair.objective, u=pair.u, y=pair.y, seen=pair.y)
    return _in_repaired_surrogate(model, weights, seed, steps)


def _in_repaired_surrogate(model: Model, weights: FloatArray, seed: int, steps: Steps) -> PairFound:
    settings = SearchSettings(
        method="exact",  # as good as the genetic algorithm here, in a fifth of the time
        repair=True,
        repair_models=40,
        training_samples=max(50, 2 * (model.n_free + 1)),
        seed=seed,
    )
    problem = Problem(
        model=UnitModel(model), weights=weights, settings=settings, callback=steps.within
    )
    found = find(problem)
    if found.objective_model is None or found.training is None:
        raise ModelError("the model fails for every pair that was searched for")
    u, y = found.found.u, found.y
    first = next(k for k in model.order if weights[k] > 0.0)
    if y[0, first] > y[1, first]:
        u, y = u[::-1].copy(), y[::-1].copy()
    runs = found.training.values
    good = np.isfinite(runs).all(axis=1)
    return PairFound(objective=found.objective_model, u=u, y=y, seen=np.vstack([y, runs[good]]))

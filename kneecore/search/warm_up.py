"""Compile or load the kernels before anything is timed, or while a visitor still looks around."""

import numpy as np

from kneecore.model import Model
from kneecore.numerics.genetic import GENERATIONS_PER_CALL, maximize
from kneecore.numerics.pair import SurrogatePair
from kneecore.numerics.surrogate import Surrogate
from kneecore.search.arguments import checked
from kneecore.search.settings import SearchSettings

__all__ = ["warm_up"]


def warm_up(model: Model, settings: SearchSettings | None = None) -> None:
    """Run each kernel of a search once on next to nothing.

    Parameters
    ----------
    model : Model
    settings : SearchSettings, optional
        Of the search whose kernels are wanted; the default search's for None.
    """
    settings = checked(model, settings).of(model)
    exact = settings.method == "exact"
    model.warm_up(gradient=exact and settings.search_space == "model")
    if settings.search_space == "surrogate":
        points = np.array([[0.0], [0.5], [1.0]])
        surrogate = Surrogate.fit(points, points)
        surrogate(points)
        if exact:
            surrogate.weighted_gradient(points, points)
        pair = SurrogatePair(surrogate, np.ones(1))
        maximize(pair, np.zeros(2), np.ones(2), pop_size=10, n_generations=GENERATIONS_PER_CALL)
    elif not exact:
        maximize(lambda x: x[:, 0], np.zeros(2), np.ones(2), pop_size=10, n_generations=1)

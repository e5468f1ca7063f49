"""Compile or load the kernels before anything is timed, or while a visitor still looks around."""

from collections.abc import Callable

import numpy as np

from kneecore._second_compiler import compile_apart, wait_for
from kneecore.model import Model
from kneecore.numerics.genetic import GENERATIONS_PER_CALL, maximize
from kneecore.numerics.pair import SurrogatePair
from kneecore.numerics.surrogate import Surrogate
from kneecore.search.ahead import GENERATIONS
from kneecore.search.arguments import checked
from kneecore.search.settings import SearchSettings

__all__ = ["warm_up"]

_POINTS = np.array([[0.0], [0.5], [1.0]])


def warm_up(
    model: Model,
    settings: SearchSettings | None = None,
    *,
    model_ready: Callable[[], object] | None = None,
) -> None:
    """Run each kernel of a search once on next to nothing.

    Parameters
    ----------
    model : Model
    settings : SearchSettings, optional
        Of the search whose kernels are wanted; the default search's for None.
    model_ready : callable, optional
        Called as soon as the model itself can run.
    """
    told = model_ready or bool
    settings = checked(model, settings).of(model)
    exact = settings.method == "exact"
    if settings.search_space == "model":
        model.warm_up(gradient=exact)
        told()
        if not exact:
            maximize(lambda x: x[:, 0], np.zeros(2), np.ones(2), pop_size=10, n_generations=1)
        return
    compile_apart(GENERATIONS)
    model.warm_up()
    told()
    surrogate = _surrogate()
    surrogate(_POINTS)
    if exact:
        surrogate.weighted_gradient(_POINTS, _POINTS)
    wait_for(GENERATIONS)
    compile_generations()


def _surrogate() -> Surrogate:
    return Surrogate.fit(_POINTS, _POINTS)


def compile_generations() -> None:
    """Compile the genetic algorithm in a surrogate."""
    pair = SurrogatePair(_surrogate(), np.ones(1))
    maximize(pair, np.zeros(2), np.ones(2), pop_size=10, n_generations=GENERATIONS_PER_CALL)

"""Compile or load the kernels before anything is timed, or while a visitor still looks around."""

import numpy as np

from kneecore.knee.gradient import flexion_gradient
from kneecore.knee.response import simulate
from kneecore.knee.space import ParameterSpace
from kneecore.numerics.genetic import GENERATIONS_PER_CALL, maximize
from kneecore.numerics.pair import SurrogatePair
from kneecore.numerics.surrogate import Surrogate


def warm_up(
    search_space: str = "surrogate", *, method: str = "ga", solver: str = "dynamics"
) -> None:
    """Run each kernel of a search once on next to nothing.

    Parameters
    ----------
    search_space : {"surrogate", "model"}
        The search whose kernels are wanted.
    method : {"ga", "exact"}
    solver : {"dynamics", "equilibrium"}
    """
    baseline = ParameterSpace().baseline
    simulate(baseline, solver="equilibrium" if solver == "equilibrium" else "dynamics")
    if method == "exact" and search_space == "model":
        flexion_gradient(baseline)
    if search_space == "surrogate":
        points = np.array([[0.0], [0.5], [1.0]])
        surrogate = Surrogate.fit(points, points)
        surrogate(points)
        if method == "exact":
            surrogate.weighted_gradient(points, points)
        pair = SurrogatePair(surrogate, np.ones(1))
        maximize(pair, np.zeros(2), np.ones(2), pop_size=10, n_generations=GENERATIONS_PER_CALL)
    elif method == "ga":
        maximize(lambda x: x[:, 0], np.zeros(2), np.ones(2), pop_size=10, n_generations=1)

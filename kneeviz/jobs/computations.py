"""The long computations that a page asks kneecore for, each as work for a `Job`.

Every option that the page can set passes here on its way to kneecore.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

import kneecore
from kneecore import InfluenceResult, Landscape, MonteCarloResult, ParameterSpace, SearchResult
from kneecore.knee.model import Objective
from kneecore.knee.response import Solver
from kneecore.numerics.sampling_options import Sampling
from kneecore.search.compare import MethodTrace, compare_methods
from kneecore.search.settings import Method, SearchSpace
from kneeviz.jobs.cores import spare_cores
from kneeviz.jobs.job import Watch

FloatArray = NDArray[np.float64]
Result = TypeVar("Result")
Work = Callable[[Watch], Result]


@dataclass(frozen=True, kw_only=True)
class Bounded:
    """The box that a computation stays in, and what its knees do with their rest lengths."""

    space: ParameterSpace
    rest_length: Any


@dataclass(frozen=True, kw_only=True)
class SearchOptions:
    """How to search."""

    search_space: SearchSpace
    method: Method
    repair: bool
    """Whether a surrogate is repaired; a search in the true model has none."""
    solver: Solver
    objective: Objective
    pop_size: int
    n_generations: int
    seed: int


def search(within: Bounded, options: SearchOptions) -> Work[SearchResult]:
    """Return the worst-case search."""
    # The exact search has neither, and refuses them.
    genetic: dict[str, Any] = {}
    if options.method == "ga":
        genetic = {"pop_size": options.pop_size, "n_generations": options.n_generations}
    return lambda watch: kneecore.worst_case(
        within.space,
        method=options.method,
        repair=options.repair and options.search_space == "surrogate",
        search_space=options.search_space,
        training_samples=max(50, within.space.n_free + 2),
        **genetic,
        objective=options.objective,
        seed=options.seed,
        rest_length=within.rest_length,
        solver=options.solver,
        threads=spare_cores(),
        callback=watch,
    )


def comparison(
    within: Bounded, *, objective: Objective, solver: Solver, seed: int
) -> Work[Mapping[str, MethodTrace]]:
    """Return the comparison of the search's methods."""
    return lambda watch: compare_methods(
        within.space,
        objective=objective,
        solver=solver,
        rest_length=within.rest_length,
        seed=seed,
        threads=spare_cores(),
        callback=watch,
    )


def sampling(
    within: Bounded,
    *,
    n_samples: int,
    sampling: Sampling,
    seed: int,
    angles_deg: FloatArray | None,
) -> Work[MonteCarloResult]:
    """Return the sampling of the true model; `angles_deg` are held against the samples."""
    return lambda watch: kneecore.monte_carlo(
        within.space,
        n_samples=n_samples,
        sampling=sampling,
        seed=seed,
        rest_length=within.rest_length,
        threads=spare_cores(),
        angles_deg=angles_deg,
        callback=watch,
    )


def influence(within: Bounded, *, n_base: int, seed: int) -> Work[InfluenceResult]:
    """Return the sensitivity analysis."""
    return lambda watch: kneecore.influence(
        within.space,
        n_base=n_base,
        seed=seed,
        rest_length=within.rest_length,
        threads=spare_cores(),
        callback=watch,
    )


def landscape(
    within: Bounded,
    x: FloatArray,
    names: tuple[str, str],
    surrogate: kneecore.KneeSurrogate | None,
) -> Landscape:
    """Run kneecore over the grid of a landscape."""
    return kneecore.landscape(
        x,
        names,
        space=within.space,
        surrogate=surrogate,
        rest_length=within.rest_length,
        threads=spare_cores(),
    )

"""Other people's libraries on the same problems, with their defaults where they have any.

They come with ``python -m pip install ".[bench]"``. All get our compiled objective, on whole
generations at once: the fastest evaluation that there is, so that only the searches differ.
"""

import importlib
import random
import warnings
from collections.abc import Callable
from types import ModuleType

import numpy as np
from scipy.optimize import differential_evolution

Objective = Callable[[np.ndarray], np.ndarray]


class PeerMissingError(Exception):
    """A library to compare with is not installed."""


def imported(name: str) -> ModuleType:
    """Import a peer, or say in one line what to install."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return importlib.import_module(name)
        except ModuleNotFoundError as error:
            raise PeerMissingError(
                f"`{error.name}` is not installed; the benchmarks compare with it: "
                'python -m pip install ".[bench]"'
            ) from None


def pymoo_search(value: Objective, d: int, budget: int, seed: int) -> np.ndarray:
    """pymoo's `GA` as it comes (SBX, polynomial mutation), 200 individuals."""
    problem_class = imported("pymoo.core.problem").Problem
    genetic = imported("pymoo.algorithms.soo.nonconvex.ga").GA

    class Pairs(problem_class):
        def __init__(self):
            super().__init__(n_var=d, n_obj=1, xl=0.0, xu=1.0)

        def _evaluate(self, x, out, *args, **kwargs):
            out["F"] = -value(x)[:, None]

    minimize = imported("pymoo.optimize").minimize
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = minimize(Pairs(), genetic(pop_size=200), ("n_eval", budget), seed=seed)
    return np.array(found.X)


def deap_search(value: Objective, d: int, budget: int, seed: int) -> np.ndarray:
    """DEAP's `eaSimple`, 200 individuals: blend crossover 0.7, Gaussian mutation 0.2, tournament 3.

    The genes are clipped to the bounds, and the best ever seen is kept apart.
    """
    base, tools, algorithms = (imported(f"deap.{m}") for m in ("base", "tools", "algorithms"))

    class Fitness(base.Fitness):
        weights = (1.0,)

    class Individual(list):
        def __init__(self, genes):
            super().__init__(genes)
            self.fitness = Fitness()

    n_evaluations = 0

    def evaluate_all(_function, individuals):
        nonlocal n_evaluations
        genes = np.clip(np.array(individuals).reshape(-1, d), 0.0, 1.0)
        for individual, row in zip(individuals, genes.tolist(), strict=True):
            individual[:] = row
        n_evaluations += len(genes)
        return [(f,) for f in value(genes)] if len(genes) else []

    random.seed(seed)
    toolbox = base.Toolbox()
    toolbox.register("evaluate", lambda individual: individual)
    toolbox.register("map", evaluate_all)
    toolbox.register("mate", tools.cxBlend, alpha=0.5)
    toolbox.register("mutate", tools.mutGaussian, mu=0.0, sigma=0.1, indpb=0.05)
    toolbox.register("select", tools.selTournament, tournsize=3)
    population = [Individual([random.random() for _ in range(d)]) for _ in range(200)]
    best = tools.HallOfFame(1)
    while n_evaluations < budget:  # only changed individuals are evaluated: 152 of 200 or so
        n_left = max(1, (budget - n_evaluations) // 200)
        population, _ = algorithms.eaSimple(
            population, toolbox, 0.7, 0.2, n_left, halloffame=best, verbose=False
        )
    return np.array(best[0])


def scipy_search(value: Objective, d: int, budget: int, seed: int) -> np.ndarray:
    """SciPy's `differential_evolution` as it comes, vectorised, 4 individuals a gene, no polish."""
    pop_size = 4
    found = differential_evolution(
        lambda x: -value(np.ascontiguousarray(x.T)),
        [(0.0, 1.0)] * d,
        popsize=pop_size,
        maxiter=budget // (pop_size * d) - 1,
        tol=0.0,
        polish=False,
        vectorized=True,
        updating="deferred",
        rng=seed,
    )
    return np.array(found.x)


def sobol_indices(
    model: Callable[[np.ndarray], np.ndarray], d: int, n_base: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """First-order and total Sobol' indices by SALib, each (n_outputs, d).

    With two bootstrap samples, the fewest that it can do: what is measured leaves intervals out.
    """
    problem = {"num_vars": d, "names": [str(k) for k in range(d)], "bounds": [[0.0, 1.0]] * d}
    sample, analyze = imported("SALib.sample.sobol"), imported("SALib.analyze.sobol")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        points = sample.sample(problem, n_base, calc_second_order=False, seed=seed)
        outputs = model(points)
        found = [
            analyze.analyze(problem, y, calc_second_order=False, num_resamples=2, seed=seed)
            for y in outputs.T
        ]
    return np.array([f["S1"] for f in found]), np.array([f["ST"] for f in found])

"""How good and how dear the searches are: the same surrogate, the same seeds, one budget."""

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import cases
import numpy as np
import peers
import rivals
from scipy.interpolate import RBFInterpolator
from threadpoolctl import threadpool_limits

from kneecore.knee.model import ALONG_LOADS
from kneecore.numerics.genetic import maximize
from kneecore.numerics.genetic_options import GeneticOptions
from kneecore.numerics.pair import SurrogatePair
from kneecore.search.sign_climb import ExactSettings, climb_pair

BUDGET = 160_000
"""Pairs evaluated at most: 200 x 800, the paper's main run."""
SEEDS = range(5)
N_GENES = 56


class Counted:
    """An objective that counts the pairs which it is asked for."""

    def __init__(self, objective: peers.Objective):
        self.objective, self.n = objective, 0

    def __call__(self, x):
        self.n += len(x)
        return self.objective(x)


@dataclass(kw_only=True)
class Contender:
    """One method, and what it did."""

    name: str
    search: Callable[[int], tuple[np.ndarray, str]]
    """Maps a seed to the best pair, shape (56,), and the count of what it evaluated."""
    seconds: list[float] = field(default_factory=list)
    values: list[float] = field(default_factory=list)
    count: str = ""


def pair_objective():
    return SurrogatePair(cases.training().surrogate, np.ones(12))


def ours(seed):
    found = maximize(
        pair_objective(), np.zeros(56), np.ones(56), pop_size=200, n_generations=800, seed=seed
    )
    return found.x, f"{found.n_evaluations:,}"


def exact(seed):
    surrogate = cases.training().surrogate

    def slopes(u, w):
        y = surrogate(u)
        return (w * y).sum(axis=1), (w[:, :, None] * surrogate.gradient(u)).sum(axis=1), y

    settings = ExactSettings(seed=seed)
    found = climb_pair(slopes, 28, np.ones(12), order=ALONG_LOADS, settings=settings)
    return found.u.ravel(), f"{found.evidence.n_evaluations:,} models with gradients"


def numpy_search(objective):
    def search(seed):
        counted = Counted(objective())
        with threadpool_limits(1):
            x = rivals.numpy_search(counted, 28, 200, 800, seed)[1]
        return x, f"{counted.n:,}"

    return search


def matrix_product():
    return rivals.matrix_product(cases.training().surrogate, 12)


def interpolated():
    training = cases.training()
    return rivals.interpolated(
        RBFInterpolator(training.points, training.values, kernel="thin_plate_spline", degree=1),
        28,
    )


def peer(library):
    def search(seed):
        counted = Counted(pair_objective())
        return library(counted, N_GENES, BUDGET, seed), f"{counted.n:,}"

    return search


def contenders() -> list[Contender]:
    return [
        Contender(name="ours: genetic algorithm, 200 x 800", search=ours),
        Contender(name="ours: `--method exact`", search=exact),
        Contender(
            name="NumPy genetic algorithm, distances by one matrix product",
            search=numpy_search(matrix_product),
        ),
        Contender(
            name="plain NumPy genetic algorithm on SciPy's RBFInterpolator",
            search=numpy_search(interpolated),
        ),
        Contender(name="SciPy differential evolution", search=peer(peers.scipy_search)),
        Contender(name="DEAP eaSimple", search=peer(peers.deap_search)),
        Contender(name="pymoo GA", search=peer(peers.pymoo_search)),
    ]


def run(contender: Contender, seed: int) -> None:
    """Let a contender search once; f is computed again in double precision for all alike."""
    start = time.perf_counter()
    x, contender.count = contender.search(seed)
    contender.seconds.append(time.perf_counter() - start)
    contender.values.append(pair_objective().exact(x))


def search_table(shown: Callable[[float], str]) -> list[str]:
    """Return the table `Search quality and cost`; all contenders take their turns seed by seed."""
    field_of_all = contenders()
    for contender in field_of_all[:2]:
        contender.search(0)  # kernels are compiled, or loaded, outside of the measurement
    for seed in SEEDS:
        for contender in field_of_all:
            run(contender, seed)
            print(f"seed {seed}: {contender.name}", file=sys.stderr, flush=True)
    reference = np.median(field_of_all[0].seconds)
    lines = ["| search | time | times ours | pairs evaluated | mean f, deg | worst f, deg |"]
    lines.append("|---|---|---|---|---|---|")
    for c in field_of_all:
        median = float(np.median(c.seconds))
        lines.append(
            f"| {c.name} | {shown(median)} | {median / reference:.1f} | {c.count} "
            f"| {np.mean(c.values):.3f} | {min(c.values):.3f} |"
        )
    return lines


OPTIONS = {
    "as shipped (eta_min 0, 5 % of the genes)": GeneticOptions(),
    "eta_min 0.75": GeneticOptions(rank_eta_min=0.75),
    "2 % of the genes": GeneticOptions(gene_mutation_probability=0.02),
    "10 % of the genes": GeneticOptions(gene_mutation_probability=0.1),
    "all genes": GeneticOptions(gene_mutation_probability=1.0),
}


def options_table() -> list[str]:
    """Return the table of what the genetic algorithm's own choices cost, over 20 seeds."""
    seeds = range(20)
    big = {
        name: [cases.surrogate_search(options=options, seed=s).value for s in seeds]
        for name, options in OPTIONS.items()
    }
    small = {
        name: [cases.surrogate_search(100, 100, options=options, seed=s).value for s in seeds]
        for name, options in OPTIONS.items()
    }
    best = max(max(values) for values in big.values())
    lines = ["| genetic algorithm, 20 seeds | 200 x 800: mean loss | 100 x 100: mean loss |"]
    lines.append("|---|---|---|")
    for name in OPTIONS:
        losses = [100.0 * (1.0 - np.mean(v[name]) / best) for v in (big, small)]
        lines.append(f"| {name} | {losses[0]:.2f} % | {losses[1]:.2f} % |")
    return lines

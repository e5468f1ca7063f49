"""What is measured, ours and the rival's side by side."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
import rivals
from scipy.interpolate import RBFInterpolator

from kneecore import ParameterSpace, influence, monte_carlo, worst_case
from kneecore.model.dynamics import respond
from kneecore.model.equilibrium import equilibria
from kneecore.model.response import prepare
from kneecore.numerics.genetic import maximize
from kneecore.numerics.genetic_options import GeneticOptions
from kneecore.numerics.pair import SurrogatePair
from kneecore.search.knee import KneeModel
from kneecore.search.pair_search import PairSettings, train


@dataclass(frozen=True, kw_only=True)
class Case:
    """One measurement; both callables do the same work."""

    name: str
    ours: Callable[[], object]
    rival_name: str = ""
    rival: Callable[[], object] | None = None
    repeats: int = 7
    elsewhere: str = ""
    """What others report, and where."""


@cache
def training():
    space = ParameterSpace()
    return train(KneeModel(space), space.n_free, PairSettings())


@cache
def knees():
    space = ParameterSpace()
    return prepare(space.from_unit(np.random.default_rng(0).random((1024, 28))), None, "recomputed")


def surrogate_search(pop_size=200, n_generations=800, seed=0, options=None):
    pair = SurrogatePair(training().surrogate, np.ones(12))
    return maximize(
        pair,
        np.zeros(56),
        np.ones(56),
        pop_size=pop_size,
        n_generations=n_generations,
        seed=seed,
        options=options,
    )


def numpy_search(pop_size=200, n_generations=800, seed=0):
    data = training().surrogate
    interpolator = RBFInterpolator(data.points, data.values, kernel="thin_plate_spline", degree=1)
    return rivals.numpy_search(interpolator, 28, pop_size, n_generations, seed)


def command(*arguments, cold=False):
    """Run a command as a user would; `cold` with an empty kernel cache."""
    with tempfile.TemporaryDirectory() as folder:
        extra = {"env": {**os.environ, "NUMBA_CACHE_DIR": folder}} if cold else {}
        subprocess.run(
            [sys.executable, "-m", "kneecore.search", *arguments],
            check=True,
            capture_output=True,
            **extra,
        )


CASES = (
    Case(
        name="dynamic model, 1,024 knees",
        ours=lambda: respond(knees()),
        rival_name="the same arithmetic, one model at a time, one core",
        rival=lambda: rivals.scalar_flexion(knees()),
    ),
    Case(
        name="200 x 800 search in the surrogate",
        ours=surrogate_search,
        rival_name="plain NumPy genetic algorithm on SciPy's RBFInterpolator",
        rival=numpy_search,
        elsewhere="4.10 s (the paper, 15 threads)",
    ),
    Case(
        name="100 x 100 search in the surrogate",
        ours=lambda: surrogate_search(100, 100),
        rival_name="plain NumPy genetic algorithm on SciPy's RBFInterpolator",
        rival=lambda: numpy_search(100, 100),
        elsewhere="0.35 s (the paper, 15 threads)",
    ),
    Case(
        name="100 x 100 search in the true model",
        ours=lambda: worst_case(search_space="model", pop_size=100, n_generations=100),
        repeats=2,
        elsewhere="2,633 s (the paper, 15 threads)",
    ),
    Case(
        name="12 equilibria, 1,024 knees",
        ours=lambda: equilibria(knees()),
        rival_name="the dynamic model",
        rival=lambda: respond(knees()),
    ),
    Case(
        name="exact worst case in the true model",
        ours=lambda: worst_case(method="exact"),
    ),
    Case(
        name="exact worst case of the knees at rest",
        ours=lambda: worst_case(method="exact", solver="equilibrium"),
    ),
    Case(
        name="10,000 Monte-Carlo samples of the true model",
        ours=monte_carlo,
        repeats=2,
        elsewhere="1,246 s (the paper, 15 threads)",
    ),
    Case(
        name="Sobol' indices, 30,720 models, no intervals",
        ours=lambda: influence(intervals=False),
        repeats=2,
    ),
    Case(name="`python -m kneecore.search --help`", ours=lambda: command("--help"), repeats=3),
    Case(name="`python -m kneecore.search`, kernels cached", ours=command, repeats=3),
    Case(
        name="`python -m kneecore.search`, empty kernel cache",
        ours=lambda: command(cold=True),
        repeats=1,
    ),
)

OPTIONS = {
    "as shipped (eta_min 0, 5 % of the genes)": GeneticOptions(),
    "eta_min 0.75": GeneticOptions(rank_eta_min=0.75),
    "2 % of the genes": GeneticOptions(gene_mutation_probability=0.02),
    "10 % of the genes": GeneticOptions(gene_mutation_probability=0.1),
    "all genes": GeneticOptions(gene_mutation_probability=1.0),
}

"""What is measured, ours and the rival's side by side."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import peers
import rivals
from scipy.interpolate import RBFInterpolator
from threadpoolctl import threadpool_limits

from kneecore import (
    InfluenceSettings,
    Knee,
    SearchSettings,
    influence,
    monte_carlo,
    worst_case,
)
from kneecore.knee.physics.dynamics import respond
from kneecore.knee.physics.equilibrium import equilibria
from kneecore.knee.physics.forces import THETA_0
from kneecore.knee.response import prepare
from kneecore.numerics.genetic import maximize
from kneecore.numerics.pair import SurrogatePair
from kneecore.search.training import train
from kneecore.unit_model import UnitModel


@dataclass(frozen=True, kw_only=True)
class Case:
    """One measurement; both callables do the same work."""

    name: str
    ours: Callable[[], object]
    rival_name: str = ""
    rival: Callable[[], object] | None = None
    repeats: int = 7
    rival_repeats: int | None = None
    """`repeats` for None."""
    items: int = 0
    """What our time is also given per one of: knees, pairs; 0 for nothing."""
    rival_share: float = 1.0
    """Part of the work that the rival does; its time is scaled up."""
    agreement: Callable[[Any, Any], str] | None = None
    """Says of both results how far they agree."""
    elsewhere: str = ""
    """What others report, and where."""


@cache
def training():
    knee = Knee()
    return train(UnitModel(knee), SearchSettings().of(knee))


@cache
def knees():
    x = Knee().from_free_unit(np.random.default_rng(0).random((1024, 28)))
    return prepare(x, None, "recomputed")


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
    value = rivals.interpolated(
        RBFInterpolator(training().points, training().values, kernel="thin_plate_spline", degree=1),
        28,
    )
    return rivals.numpy_search(value, 28, pop_size, n_generations, seed)


def matrix_search(pop_size=200, n_generations=800, seed=0):
    value = rivals.matrix_product(training().surrogate, 12)
    with threadpool_limits(1):
        return rivals.numpy_search(value, 28, pop_size, n_generations, seed)


def flexion(rows):
    """Flexion angles (rad) of our dynamic model, shape (n, 36) -> (n, 12)."""
    return THETA_0 - respond(rows)[0][..., 2]


def sobol_by_salib():
    knee = Knee()
    return peers.sobol_indices(UnitModel(knee), knee.n_free, 1024, seed=0)


def angles_apart(ours, theirs):
    """Both results' largest difference, the rival's rows being the first of ours."""
    degrees = np.degrees(np.abs(ours[: len(theirs)] - theirs).max())
    return f"within {degrees:.1g} deg"


def indices_apart(ours, theirs):
    total = np.abs(ours.indices.total_order - theirs[1]).max()
    return f"total indices within {total:.3f}"


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
        ours=lambda: flexion(knees()),
        items=1024,
        rival_name="the same arithmetic, one model at a time, one core",
        rival=lambda: rivals.scalar_flexion(knees()),
        rival_repeats=3,
        agreement=angles_apart,
    ),
    Case(
        name="dynamic model, 1,024 knees",
        ours=lambda: flexion(knees()),
        items=1024,
        rival_name="SciPy's solve_ivp (LSODA, compiled right-hand side), scaled up from 4 knees",
        rival=lambda: rivals.solve_ivp_flexion(knees()[:4]),
        rival_repeats=2,
        rival_share=4 / 1024,
        agreement=angles_apart,
    ),
    Case(
        name="12 equilibria, 1,024 knees",
        ours=lambda: equilibria(knees()),
        items=1024,
        rival_name="the dynamic model",
        rival=lambda: respond(knees()),
    ),
    Case(
        name="200 x 800 search in the surrogate",
        ours=surrogate_search,
        rival_name="plain NumPy genetic algorithm on SciPy's RBFInterpolator",
        rival=numpy_search,
        rival_repeats=3,
        elsewhere="4.10 s (the paper, 15 threads)",
    ),
    Case(
        name="200 x 800 search in the surrogate",
        ours=surrogate_search,
        rival_name="the same with the distances by one matrix product",
        rival=matrix_search,
        rival_repeats=3,
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
        ours=lambda: worst_case(
            Knee(), SearchSettings(search_space="model", pop_size=100, n_generations=100)
        ),
        repeats=2,
        elsewhere="2,633 s (the paper, 15 threads)",
    ),
    Case(
        name="100 x 100 search in the knees at rest",
        ours=lambda: worst_case(
            Knee(solver="equilibrium"),
            SearchSettings(search_space="model", pop_size=100, n_generations=100),
        ),
        repeats=3,
    ),
    Case(
        name="200 x 800 search in the true model",
        ours=lambda: worst_case(Knee(), SearchSettings(search_space="model")),
        repeats=1,
    ),
    Case(
        name="200 x 800 search in the knees at rest",
        ours=lambda: worst_case(Knee(solver="equilibrium"), SearchSettings(search_space="model")),
        repeats=2,
    ),
    Case(
        name="exact worst case in the true model",
        ours=lambda: worst_case(Knee(), SearchSettings(method="exact")),
    ),
    Case(
        name="exact worst case of the knees at rest",
        ours=lambda: worst_case(Knee(solver="equilibrium"), SearchSettings(method="exact")),
    ),
    Case(
        name="10,000 Monte-Carlo samples of the true model",
        ours=lambda: monte_carlo(Knee()),
        repeats=2,
        elsewhere="1,246 s (the paper, 15 threads)",
    ),
    Case(
        name="Sobol' indices, 28 parameters, 30,720 models, no intervals",
        ours=lambda: influence(Knee(), InfluenceSettings(intervals=False)),
        repeats=2,
        rival_name="SALib, driving the same model",
        rival=sobol_by_salib,
        rival_repeats=1,
        agreement=indices_apart,
    ),
    Case(name="`python -m kneecore.search --help`", ours=lambda: command("--help"), repeats=3),
    Case(name="`python -m kneecore.search`, kernels cached", ours=command, repeats=3),
    Case(
        name="`python -m kneecore.search`, empty kernel cache",
        ours=lambda: command(cold=True),
        repeats=1,
    ),
)

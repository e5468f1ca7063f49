"""How many runs a surrogate should learn from: its gap, its ranking and its time by their number.

Examples
--------
>>> import kneecore
>>> sweep = kneecore.training_sweep(sizes=(30, 60), n_seeds=2)
>>> bool(sweep.rank_correlation[1].mean() > sweep.rank_correlation[0].mean())
True
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import spearmanr

from kneecore._threads import thread_count
from kneecore.errors import ParameterError
from kneecore.knee.model import KneeModel
from kneecore.knee.response import MOMENT, RestLength, Solver, check_solver
from kneecore.knee.space import ParameterSpace
from kneecore.numbers import plain
from kneecore.numerics.sampling import check_count, check_seed, uniform
from kneecore.numerics.surrogate import Surrogate
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.exact_model import ALONG_LOADS
from kneecore.search.exact_search import exact_in_surrogate
from kneecore.search.genetic_search import PairOutcome, find_pair
from kneecore.search.result import versions
from kneecore.search.settings import Method, PairSettings
from kneecore.study.defaults import SIZES

__all__ = ["TrainingSweep", "training_sweep"]

FloatArray = NDArray[np.float64]
TEST_KNEES = 1000
_TEST_SEEDS = 2**62
"""Added to a seed: test knees are no training knees."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TrainingSweep:
    """Surrogates of n training sizes, each for several seeds: arrays have shape (n, seeds)."""

    space: ParameterSpace
    solver: Solver
    rest_length: RestLength
    method: Method
    size: NDArray[np.int64]
    """Model runs that the surrogates learned from, shape (n,)."""
    n_failed: NDArray[np.int64]
    """Those among them that failed and were left out."""
    objective_surrogate: FloatArray
    """f of the best pair by the surrogate, deg."""
    objective_model: FloatArray
    """f of the same pair in the true model, deg; NaN if one of the two knees fails there."""
    rank_correlation: FloatArray
    """Spearman's, of f by surrogate and by model over random pairs of knees that are new to it."""
    rank_correlation_angles: FloatArray
    """The same of the angles, the worst of the 12 loads."""
    rms_error_deg: FloatArray
    """Root mean square error of the angles of new knees, deg."""
    seconds: FloatArray
    """Sampling, fit and search together."""
    n_test: int
    """New knees, failed ones apart."""
    seed: int
    versions: Mapping[str, str]

    @property
    def gap_percent(self) -> FloatArray:
        """100 (surrogate - model) / surrogate of the best pair."""
        return 100.0 * (1.0 - self.objective_model / self.objective_surrogate)

    def to_dict(self) -> dict[str, Any]:
        """Return the sweep as JSON-ready values; rows are sizes, columns seeds."""
        return {
            "schema": "kneecore.training_sweep/1",
            "training_samples": self.size.tolist(),
            "seeds": list(range(self.seed, self.seed + self.n_failed.shape[1])),
            "n_failed": self.n_failed.tolist(),
            "objective_surrogate": plain(self.objective_surrogate),
            "objective_model": plain(self.objective_model),
            "gap_percent": plain(self.gap_percent),
            "rank_correlation_pairs": plain(self.rank_correlation),
            "rank_correlation_worst_angle": plain(self.rank_correlation_angles),
            "rms_error_deg": plain(self.rms_error_deg),
            "seconds": [[round(s, 6) for s in row] for row in self.seconds.tolist()],
            "n_test": self.n_test,
            "method": self.method,
            "solver": self.solver,
            "case": self.space.case,
            "rest_length": self.rest_length,
            "baseline": {"title": self.space.title, "note": self.space.note},
            "versions": dict(self.versions),
        }

    def __str__(self) -> str:
        from kneecore.report.sweep import training_report

        return training_report(self)


@dataclass(frozen=True, kw_only=True)
class _Judged:
    """One surrogate."""

    outcome: PairOutcome
    pairs: float
    angles: float
    rms_deg: float
    seconds: float


def training_sweep(
    space: ParameterSpace | None = None,
    *,
    sizes: Sequence[int] = SIZES,
    n_seeds: int = 5,
    method: Method = "ga",
    solver: Solver = "dynamics",
    rest_length: RestLength = "recomputed",
    seed: int = 0,
    threads: int | None = None,
    callback: Callback | None = None,
) -> TrainingSweep:
    """Train surrogates on more and more runs, search in each, and hold each against the model.

    Parameters
    ----------
    space : ParameterSpace, optional
        The packaged baseline with its default bounds for None.
    sizes : sequence of int
        Training samples; at least one more than free parameters.
    n_seeds : int
        Repetitions with other training samples, of seeds `seed` and up.
    method : {"ga", "exact"}
        How each surrogate is searched: the paper's main run, or exactly.
    solver, rest_length, seed, threads
        As for `worst_case`.
    callback : callable, optional
        Gets `Progress`; a true result cancels (raises `Cancelled`).

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    ModelError
        If too many training samples failed.
    """
    space = space or ParameterSpace()
    if len(sizes) == 0:
        raise ParameterError("`sizes` is empty; at least one number of samples is needed")
    check_solver(solver)
    check_count("n_seeds", n_seeds)
    check_seed(seed)
    settings = [
        PairSettings(method=method, training_samples=size, seed=check_seed(seed + s))
        for size in sizes
        for s in range(n_seeds)
    ]
    for one in settings:
        one.check_training(space.n_free)
    model = KneeModel(space, rest_length, thread_count(threads), solver)
    test_u = uniform(TEST_KNEES, space.n_free, (seed + _TEST_SEEDS) % 2**63)
    test_y = model(test_u)
    good = np.isfinite(test_y).all(axis=1)
    judged = []
    for k, one in enumerate(settings):
        stage = "training and searching"
        if callback and callback(Progress(stage=stage, done=k, total=len(settings))):
            raise Cancelled
        judged.append(_judge(model, one, test_u[good], test_y[good]))
    if callback:
        callback(Progress(stage=stage, done=len(settings), total=len(settings)))
    shape = (len(sizes), n_seeds)

    def table(values: Sequence[float | None]) -> FloatArray:
        return np.array(values, dtype=np.float64).reshape(shape)

    failed = [0 if j.outcome.training is None else j.outcome.training.n_failed for j in judged]
    return TrainingSweep(
        space=space,
        solver=solver,
        rest_length=rest_length,
        method=method,
        size=np.array(sizes, dtype=np.int64),
        n_failed=np.array(failed, dtype=np.int64).reshape(shape),
        objective_surrogate=table([j.outcome.objective_surrogate for j in judged]),
        objective_model=table([j.outcome.objective_model for j in judged]),
        rank_correlation=table([j.pairs for j in judged]),
        rank_correlation_angles=table([j.angles for j in judged]),
        rms_error_deg=table([j.rms_deg for j in judged]),
        seconds=table([j.seconds for j in judged]),
        n_test=int(np.count_nonzero(good)),
        seed=seed,
        versions=versions(),
    )


def _judge(
    model: KneeModel, settings: PairSettings, test_u: FloatArray, test_y: FloatArray
) -> _Judged:
    n_free = model.space.n_free
    begun = time.perf_counter()
    if settings.method == "ga":
        outcome = find_pair(model, n_free, None, settings)
    else:
        outcome = exact_in_surrogate(model, n_free, None, settings, order=ALONG_LOADS)
    seconds = time.perf_counter() - begun
    assert outcome.training is not None
    pairs, angles, rms_deg = ranking(outcome.training.surrogate, test_u, test_y)
    return _Judged(outcome=outcome, pairs=pairs, angles=angles, rms_deg=rms_deg, seconds=seconds)


def ranking(surrogate: Surrogate, u: FloatArray, y: FloatArray) -> tuple[float, float, float]:
    """Return how well a surrogate ranks knees that are new to it.

    Parameters
    ----------
    surrogate : Surrogate
    u : ndarray, shape (n, n_free)
        Knees in the unit cube.
    y : ndarray, shape (n, 12)
        Their angles in the true model.

    Returns
    -------
    tuple of float
        Spearman's rank correlation of f over disjoint pairs of the knees, that of the angles at the
        worst load, and the root mean square error of the angles, in their unit.
    """
    predicted = surrogate(u)
    half = len(u) // 2
    f = [np.abs(v[:half] - v[half : 2 * half]).sum(axis=1) for v in (predicted, y)]
    pairs = float(spearmanr(*f).statistic)
    loads = [float(spearmanr(predicted[:, k], y[:, k]).statistic) for k in range(len(MOMENT))]
    return pairs, min(loads), float(np.sqrt(np.mean((predicted - y) ** 2)))

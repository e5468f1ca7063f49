"""How many runs a surrogate should learn from: its gap, its ranking and its time by their number.

Examples
--------
>>> import kneecore
>>> settings = kneecore.TrainingSweepSettings(sizes=(30, 60), n_seeds=2)
>>> sweep = kneecore.training_sweep(kneecore.Knee(), settings)
>>> bool(sweep.rank_f[1].mean() > sweep.rank_f[0].mean())
True
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore._version import versions
from kneecore.model import Model
from kneecore.presented import Presented
from kneecore.progress import Callback
from kneecore.search.problem import Outcome, Problem
from kneecore.search.settings import SearchSettings
from kneecore.search.worst_case import find
from kneecore.study.arguments import Steps, checked_settings
from kneecore.study.settings import TrainingSweepSettings
from kneecore.study.surrogate_quality import Judgement, judge, new_points
from kneecore.unit_model import UnitModel

__all__ = ["TrainingSweep", "training_sweep"]

FloatArray = NDArray[np.float64]
N_TEST = 1000
"""Points, new to the surrogates, that they are held against."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TrainingSweep(Presented):
    """Surrogates of n training sizes, each for several seeds: arrays have shape (n, seeds)."""

    model: Model
    """Read from a file, a model that is no knee has no function."""
    settings: TrainingSweepSettings
    n_failed: NDArray[np.int64]
    """Training samples that failed and were left out."""
    objective_surrogate: FloatArray
    """f of the best pair by the surrogate."""
    objective_model: FloatArray
    """f of the same pair in the true model; NaN if one of the two fails there."""
    gap_percent: FloatArray
    """100 (surrogate - model) / surrogate of the best pair."""
    rank_f: FloatArray
    """Spearman's rank correlation of f by surrogate and by model, over random pairs of models that
    are new to the surrogate."""
    rank_outputs: FloatArray
    """The same of the outputs, the worst of them."""
    rms_error: FloatArray
    """Root mean square error of the outputs of new models, in the unit of f."""
    seconds: FloatArray
    """Sampling, fit and search together."""
    n_test: int
    """New models, failed ones apart."""
    counts: Mapping[str, int]
    """Models that were run, to learn from, to be held against and of best pairs, by what became of
    them, as in `MonteCarloResult`; empty where an older file did not tell."""
    versions: Mapping[str, str]

    @property
    def size(self) -> NDArray[np.int64]:
        """Model runs that the surrogates learned from, shape (n,)."""
        return np.array(self.settings.sizes, dtype=np.int64)


@dataclass(frozen=True, kw_only=True)
class _Judged:
    """One surrogate."""

    outcome: Outcome
    judgement: Judgement
    seconds: float


def _searches(model: Model, settings: TrainingSweepSettings) -> list[SearchSettings]:
    """Return how each of the surrogates is searched, seed after seed, size after size."""
    return [
        SearchSettings(
            method=settings.method,
            search_space="surrogate",
            repair=False,
            training_samples=size,
            seed=settings.seed + s,
        ).of(model)
        for size in settings.sizes
        for s in range(settings.n_seeds)
    ]


def training_sweep(
    model: Model,
    settings: TrainingSweepSettings | None = None,
    *,
    callback: Callback | None = None,
) -> TrainingSweep:
    """Train surrogates on more and more runs, search in each, and hold each against the model.

    Parameters
    ----------
    model : Model
        Such as `Knee`.
    settings : TrainingSweepSettings, optional
    callback : callable, optional
        Gets `Progress`; a true result cancels (raises `Cancelled`).

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    ModelError
        If too many training samples failed.
    """
    settings = checked_settings(model, TrainingSweepSettings, settings, callback)
    searches = _searches(model, settings)
    counted = UnitModel(model, every_mark=True)
    test = new_points(counted, N_TEST, settings.seed)
    steps = Steps(callback, "training and searching", len(searches))
    judged = []
    for one in searches:
        steps.begin()
        judged.append(_judged(counted, one, test))
        steps.done += 1
    steps()
    return _sweep(counted, settings, judged, len(test[0]))


def _judged(
    model: UnitModel, settings: SearchSettings, test: tuple[FloatArray, FloatArray]
) -> _Judged:
    weights = model.model.weights()
    begun = time.perf_counter()
    outcome = find(Problem(model=model, weights=weights, settings=settings))
    seconds = time.perf_counter() - begun
    assert outcome.training is not None
    judgement = judge(outcome.training.surrogate, *test, weights)
    return _Judged(outcome=outcome, judgement=judgement, seconds=seconds)


def _sweep(
    model: UnitModel, settings: TrainingSweepSettings, judged: Sequence[_Judged], n_test: int
) -> TrainingSweep:
    shape = (len(settings.sizes), settings.n_seeds)

    def table(values: Sequence[float | None]) -> FloatArray:
        return np.array(values, dtype=np.float64).reshape(shape)

    outcomes = [j.outcome for j in judged]
    promised = table([o.objective_surrogate for o in outcomes])
    kept = table([o.objective_model for o in outcomes])
    with np.errstate(divide="ignore", invalid="ignore"):  # a surrogate of what does not vary
        gap = 100.0 * (1.0 - kept / promised)
    failed = [o.training.n_failed if o.training else 0 for o in outcomes]
    return TrainingSweep(
        model=model.model,
        settings=settings,
        n_failed=np.array(failed, dtype=np.int64).reshape(shape),
        objective_surrogate=promised,
        objective_model=kept,
        gap_percent=gap,
        rank_f=table([j.judgement.rank_f for j in judged]),
        rank_outputs=table([j.judgement.worst_rank for j in judged]),
        rms_error=table([j.judgement.rms_all for j in judged]),
        seconds=table([j.seconds for j in judged]),
        n_test=n_test,
        counts=model.counts,
        versions=versions(),
    )

"""How far a model's surrogate can be trusted: its errors and its ranking on new points.

Examples
--------
>>> import kneecore
>>> quality = kneecore.surrogate_quality(kneecore.Knee())
>>> bool(quality.rank_f > 0.9)
True
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy  # its subpackages are loaded when they are used: a page's start needs none
from numpy.typing import NDArray

from kneecore._version import versions
from kneecore.errors import ModelError
from kneecore.model import Model
from kneecore.numerics.sampling import uniform
from kneecore.numerics.surrogate import Surrogate
from kneecore.presented import Presented
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.settings import SearchSettings
from kneecore.search.training import train
from kneecore.study.arguments import checked_settings
from kneecore.study.settings import SurrogateQualitySettings
from kneecore.unit_model import UnitModel

__all__ = [
    "Judgement",
    "SurrogateQuality",
    "judge",
    "new_points",
    "rank_correlation",
    "surrogate_quality",
]

FloatArray = NDArray[np.float64]
_TEST_SEEDS = 2**62
"""Added to a seed: new points are no training points."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Judgement:
    """A surrogate beside the true model at points that are new to it."""

    f_surrogate: FloatArray
    """f of pairs of the points by the surrogate, shape (n // 2,)."""
    f_model: FloatArray
    """f of the same pairs in the true model."""
    rank_f: float
    """Spearman's rank correlation of the two; NaN where one of them does not vary."""
    rank: FloatArray
    """The same for each output at the points, shape (m,)."""
    rms: FloatArray
    """Root mean square error of each output, in its unit, shape (m,)."""
    explained: FloatArray
    """Share of each output's variance that the surrogate explains, shape (m,); below 0 where the
    mean would do better."""
    rms_all: float
    """Root mean square error of all outputs together, in the unit of f."""

    @property
    def worst_rank(self) -> float:
        """The rank correlation of the output that is ranked worst."""
        known = self.rank[np.isfinite(self.rank)]
        return float(known.min()) if len(known) else np.nan


def new_points(model: UnitModel, n: int, seed: int) -> tuple[FloatArray, FloatArray]:
    """Return points of the unit cube that no training with this seed has, and their outputs.

    Points whose model failed are left out.

    Raises
    ------
    ModelError
        If fewer than 4 did not fail.
    """
    u = model.model.snapped(uniform(n, model.model.n_free, (seed + _TEST_SEEDS) % 2**63))
    y = model(u)
    good = np.isfinite(y).all(axis=1)
    if np.count_nonzero(good) < 4:
        raise ModelError(f"{np.count_nonzero(~good)} of {n} test points failed; 4 are needed")
    return u[good], y[good]


def rank_correlation(one: FloatArray, other: FloatArray) -> float:
    """Return Spearman's rank correlation; NaN where there is nothing to rank."""
    if np.ptp(one) == 0.0 or np.ptp(other) == 0.0:
        return np.nan
    return float(scipy.stats.spearmanr(one, other).statistic)


def judge(surrogate: Surrogate, u: FloatArray, y: FloatArray, weights: FloatArray) -> Judgement:
    """Hold a surrogate against the true model at points that are new to it.

    Parameters
    ----------
    surrogate : Surrogate
    u : ndarray, shape (n, n_free)
        Points in the unit cube; the first half is paired with the second.
    y : ndarray, shape (n, m)
        Their outputs in the true model.
    weights : ndarray, shape (m,)
        Of the outputs' differences in f.
    """
    predicted = surrogate(u)
    half = len(u) // 2
    f_surrogate, f_model = (
        (np.abs(v[:half] - v[half : 2 * half]) * weights).sum(axis=1) for v in (predicted, y)
    )
    squares = (predicted - y) ** 2
    variance = y.var(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        explained = np.where(variance > 0.0, 1.0 - squares.mean(axis=0) / variance, np.nan)
    return Judgement(
        f_surrogate=f_surrogate,
        f_model=f_model,
        rank_f=rank_correlation(f_surrogate, f_model),
        rank=np.array([rank_correlation(p, t) for p, t in zip(predicted.T, y.T, strict=True)]),
        rms=np.sqrt(squares.mean(axis=0)),
        explained=explained,
        rms_all=float(np.sqrt(np.mean((predicted * weights - y * weights) ** 2))),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class SurrogateQuality(Presented):
    """What is known of a surrogate: from its own samples, and from points that are new to it."""

    model: Model
    """Read from a file, a model that is no knee has no function."""
    settings: SurrogateQualitySettings
    loo_rms: FloatArray
    """Root mean square leave-one-out error of each output, in its unit, shape (m,): what the
    samples alone tell; NaN where there are too few of them."""
    judgement: Judgement
    """What new points tell."""
    n_failed: int
    """Training samples that failed and were left out."""
    n_test: int
    """New points, failed ones apart."""
    counts: Mapping[str, int]
    """All models that were run by what became of them, as in `MonteCarloResult`; empty where an
    older file did not tell."""
    seconds: Mapping[str, float]
    """sampling and fit of the training samples, test"""
    versions: Mapping[str, str]

    @property
    def rank_f(self) -> float:
        """Spearman's rank correlation of f over pairs of new points."""
        return self.judgement.rank_f

    @property
    def rms_error(self) -> FloatArray:
        """Root mean square error of each output at new points, in its unit, shape (m,)."""
        return self.judgement.rms

    @property
    def explained(self) -> FloatArray:
        """Share of each output's variance that the surrogate explains there, shape (m,)."""
        return self.judgement.explained


def surrogate_quality(
    model: Model,
    settings: SurrogateQualitySettings | None = None,
    *,
    callback: Callback | None = None,
) -> SurrogateQuality:
    """Fit a surrogate as a search does, and tell how far it can be trusted.

    Parameters
    ----------
    model : Model
        Such as `Knee`.
    settings : SurrogateQualitySettings, optional
        The same number of samples and the same seed give the same surrogate as in `worst_case`.
    callback : callable, optional
        Gets `Progress`; a true result cancels (raises `Cancelled`).

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    ModelError
        If too many models failed.
    """
    settings = checked_settings(model, SurrogateQualitySettings, settings, callback)
    counted = UnitModel(model, every_mark=True)
    search = SearchSettings(training_samples=settings.training_samples, seed=settings.seed)
    training = train(counted, search, callback)
    report = Progress(stage="testing the surrogate", done=0, total=settings.n_test)
    if callback is not None and callback(report):
        raise Cancelled
    begun = time.perf_counter()
    u, y = new_points(counted, settings.n_test, settings.seed)
    judgement = judge(training.surrogate, u, y, model.weights())
    return SurrogateQuality(
        model=model,
        settings=settings,
        loo_rms=np.sqrt(np.mean(training.surrogate.loo_errors**2, axis=0)),
        judgement=judgement,
        n_failed=training.n_failed,
        n_test=len(u),
        counts=counted.counts,
        seconds={
            "sampling": training.seconds_sampling,
            "fit": training.seconds_fit,
            "test": time.perf_counter() - begun,
        },
        versions=versions(),
    )

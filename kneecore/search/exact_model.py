"""The exact worst case of a model: climbs with exact gradients, in it or in one near it.

A model in whose place its proxy is climbed (for knees in motion: the knees at rest) is climbed in
by itself from there, without gradients. Where the proxy often fails, bounds are so wide that many
inputs end inside of them, and both models are evolved from there.

Examples
--------
>>> import kneecore
>>> from kneecore.search.exact_model import exact_pair
>>> space = kneecore.ParameterSpace(case="material")
>>> found = exact_pair(kneecore.Knee(space, solver="equilibrium"))
>>> round(found.objective, 2)  # deg, summed over the 12 loads
35.57
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ModelError
from kneecore.model import Model, Slopes
from kneecore.record import Arrays, current_record
from kneecore.search.best_seen import BestSeen
from kneecore.search.half_evolution import QUICK, THOROUGH, evolve_pair
from kneecore.search.pattern_climb import ClimbedPair, climb_from_patterns
from kneecore.search.result import MANY_FAILED, Evidence
from kneecore.search.sign_climb import ExactPair, ExactSettings, Report, climb_pair
from kneecore.unit_model import UnitModel

__all__ = ["ExactModelPair", "exact_pair"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class ExactModelPair:
    """The two most different models by an exact search.

    Model 1 is the one with the smaller output in the first column that counts, by `Model.order`.
    """

    u: FloatArray
    """The two models in the unit cube of the free inputs, shape (2, n_free)."""
    y: FloatArray
    """Their outputs, shape (2, m)."""
    objective: float
    """f"""
    evidence: Evidence


class _CountedSlopes:
    """A model's slopes, which count what was run."""

    def __init__(self, model: Model, seen: BestSeen | None) -> None:
        self._model, self._seen = model, seen
        self.n_simulated = self.n_failed = 0

    def __call__(self, u: FloatArray, weights: FloatArray) -> Slopes:
        values, slopes, y = self._slopes(u, weights)
        self.n_simulated += len(u)
        self.n_failed += int(np.count_nonzero(np.isneginf(values)))
        if self._seen is not None:
            self._seen.take(u, y)
        return values, slopes, y

    def _slopes(self, u: FloatArray, weights: FloatArray) -> Slopes:
        record = current_record()
        if record is None:
            return self._model.slopes(u, weights)

        def compute() -> Arrays:
            values, slopes, y = self._model.slopes(u, weights)
            return {"values": values, "slopes": slopes, "y": y}

        given = {"u": u, "weights": weights}
        kept = record.run("slopes", self._model.identity, given, compute)
        values, slopes, y = (np.asarray(kept[n], dtype=np.float64) for n in kept)
        return values, slopes, y


def _evidence(slopes: _CountedSlopes, found: ExactPair, moved: ClimbedPair | None) -> Evidence:
    evidence = replace(
        found.evidence,
        n_evaluations=slopes.n_simulated,
        n_failed=slopes.n_failed,
        objective_proxy=found.value,
    )
    if moved is None:
        return evidence
    return replace(
        evidence,
        second_best=moved.others[0] if moved.others else None,
        # None where the model fails for every pair that the proxy has proposed.
        objective_before_climb=moved.first_value if np.isfinite(moved.first_value) else None,
        n_models=moved.n_models,
    )


def _moved(
    model: Model,
    found: ExactPair,
    weights: FloatArray,
    settings: ExactSettings,
    report: Report | None,
    *,
    many_failed: bool,
) -> ClimbedPair:
    """Return the worst pair of the model itself, looked for from those of its proxy.

    Where many fail it is looked for among the models of a screening, if it leaves any pair.
    """
    screened = model.screening if many_failed else model
    pair = _climbed(screened, found, weights, settings, many_failed=many_failed)
    if many_failed and not np.isfinite(pair.value):
        screened, pair = model, _climbed(model, found, weights, settings, many_failed=True)
    if not np.isfinite(pair.value):
        raise ModelError("the model fails for every worst pair of the one near it (knees: at rest)")
    if not many_failed:
        return pair
    stages = THOROUGH if settings.thorough else QUICK
    return evolve_pair(
        UnitModel(screened), pair, weights, stages=stages, seed=settings.seed, report=report
    )


def _climbed(
    model: Model,
    found: ExactPair,
    weights: FloatArray,
    settings: ExactSettings,
    *,
    many_failed: bool,
) -> ClimbedPair:
    return climb_from_patterns(
        UnitModel(model), found, weights, seed=settings.seed, many_failed=many_failed
    )


def exact_pair(
    model: Model,
    weights: FloatArray | None = None,
    *,
    settings: ExactSettings | None = None,
    report: Report | None = None,
    seen: BestSeen | None = None,
) -> ExactModelPair:
    """Find the two most different models within bounds.

    Parameters
    ----------
    model : Model
        With gradients, or with a proxy that has them.
    weights : ndarray, shape (m,), optional
        Weight of each output's difference; those of `Model.weights` for None.
    settings : ExactSettings, optional
        How much to look for; the same seed gives the same bytes, on any number of threads.
    report : callable, optional
        As for `kneecore.search.sign_climb.climb_pair`, with the proxy's f.
    seen : BestSeen, optional
        Takes in what is evaluated on the way, where that is the model itself and no proxy.

    Raises
    ------
    ModelError
        If no model could be evaluated.
    Cancelled
        If `report` ended the search before there was a pair.
    """
    settings = settings or ExactSettings()
    weights = model.weights() if weights is None else weights
    guide = model if model.has_gradient else model.proxy
    assert guide is not None
    slopes = _CountedSlopes(guide, seen if guide is model else None)
    found = climb_pair(
        slopes, model.n_free, weights, order=model.order, settings=settings, report=report
    )
    moved = None
    if guide is not model:
        many_failed = slopes.n_failed > MANY_FAILED * slopes.n_simulated
        moved = _moved(model, found, weights, settings, report, many_failed=many_failed)
    u, y = (found.u, found.y) if moved is None else (moved.u, moved.y)
    first = next(k for k in model.order if weights[k] > 0.0)
    if y[0, first] > y[1, first]:
        u, y = u[::-1].copy(), y[::-1].copy()
    return ExactModelPair(
        u=u,
        y=y,
        objective=found.value if moved is None else moved.value,
        evidence=_evidence(slopes, found, moved),
    )

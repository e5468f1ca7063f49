"""How the worst case grows with the bounds.

Examples
--------
>>> import kneecore
>>> knee = kneecore.Knee(solver="equilibrium")
>>> sweep = kneecore.bound_sweep(knee, kneecore.BoundSweepSettings(sizes=(0.5, 1.0)))  # mm
>>> sweep.objective.round(1)  # deg, summed over the 12 loads
array([209.9, 421.1])
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kneecore._version import versions
from kneecore.model import Model
from kneecore.presented import Presented
from kneecore.progress import Callback
from kneecore.study.arguments import Steps, checked_settings
from kneecore.study.best_search import PairFound, best_pair, one_column, searches_in_model
from kneecore.study.settings import BoundSweepSettings

__all__ = ["BoundSweep", "bound_sweep"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class BoundSweep(Presented):
    """Worst cases over bounds of several sizes."""

    model: Model
    """With the bounds that were stated. Read from a file, a model that is no knee has no
    function."""
    settings: BoundSweepSettings
    """What was asked for, with nothing left open."""
    column: int
    """The output that is watched, one of the m numbers that the model returns."""
    size: FloatArray
    """How wide the bounds were, shape (n,), in the model's measure: for knees the half-ranges of
    every length and coordinate, mm."""
    objective: FloatArray
    """f of the worst pair in the true model, shape (n,)."""
    pair: FloatArray
    """The watched output of its two models, shape (n, 2)."""
    extremes: FloatArray
    """Least and largest watched output of any model, shape (n, 2)."""
    in_model: bool
    """Whether the searches were exact ones in the model, and not in repaired surrogates."""
    marks: Mapping[str, NDArray[np.int64]]
    """How many models of the worst pair and of the two that end the watched output's range bear
    each of the model's marks, such as "implausible", shape (n,); empty where there are none, and
    where an older file did not tell."""
    seconds: FloatArray
    """Of each size's two searches, shape (n,)."""
    versions: Mapping[str, str]


def bound_sweep(
    model: Model,
    settings: BoundSweepSettings | None = None,
    *,
    callback: Callback | None = None,
) -> BoundSweep:
    """Find the worst case for bounds of several sizes.

    Parameters
    ----------
    model : Model
        Its bounds are made wider and narrower by `Model.with_size`; of knees those of the geometry,
        while those of the material and the ratio of slope to length stay.
    settings : BoundSweepSettings, optional
    callback : callable, optional
        Gets `Progress`; a true result cancels (raises `Cancelled`).

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    ModelError
        If no model could be evaluated.
    """
    settings = checked_settings(model, BoundSweepSettings, settings, callback)
    sizes = model.sizes if settings.sizes is None else settings.sizes
    within = [model.with_size(size) for size in sizes]
    steps = Steps(callback, "searching at each bound", len(sizes))
    found = [_at_one_size(one, settings.seed, steps) for one in within]
    steps()
    objective, pair, extremes, marks, seconds = zip(*found, strict=True)
    return BoundSweep(
        model=model,
        settings=replace(settings, sizes=tuple(float(size) for size in sizes)),
        column=model.watched,
        size=np.array(sizes, dtype=np.float64),
        objective=np.array(objective),
        pair=np.stack(pair),
        extremes=np.stack(extremes),
        in_model=searches_in_model(model),
        marks={name: np.array([of_one[name] for of_one in marks]) for name in marks[0]},
        seconds=np.array(seconds),
        versions=versions(),
    )


def _at_one_size(
    model: Model, seed: int, steps: Steps
) -> tuple[float, FloatArray, FloatArray, Mapping[str, int], float]:
    """Return f, the pair's and the extreme values of the watched output, marks, and the time."""
    steps.begin()
    begun = time.perf_counter()
    worst = best_pair(model, model.weights(), seed=seed, steps=steps)
    steps.begin()
    column = model.watched
    extreme = worst  # with a single output the worst pair is its two ends
    if model.n_outputs > 1:
        extreme = best_pair(model, one_column(model, column), seed=seed, steps=steps)
    steps.begin()  # a search that was ended early is none
    steps.done += 1
    seen = np.concatenate([found.seen[:, column] for found in (extreme, worst)])
    pair = worst.y[:, column]
    if pair[0] > pair[1]:
        pair = pair[::-1].copy()
    extremes = np.array([seen.min(), seen.max()])
    marks = model.marks(model.from_free_unit(_different(worst, extreme)))
    return worst.objective, pair, extremes, marks, time.perf_counter() - begun


def _different(worst: PairFound, extreme: PairFound) -> FloatArray:
    """Return the two to four models of two pairs, each once."""
    models: FloatArray = np.unique(np.concatenate([worst.u, extreme.u]), axis=0)
    return models

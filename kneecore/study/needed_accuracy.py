"""How accurately the inputs must be known for every model to be good enough.

Examples
--------
>>> import kneecore
>>> need = kneecore.needed_accuracy(kneecore.Knee(solver="equilibrium"))
>>> need.summary()[:41]
'Every knee extends to within 5 deg if the'
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from kneecore._version import versions
from kneecore.errors import ModelError, ParameterError
from kneecore.model import Model
from kneecore.numerics.sampling import uniform
from kneecore.presented import Presented
from kneecore.progress import Callback
from kneecore.study.arguments import Steps, checked_settings
from kneecore.study.best_search import best_pair, one_column, searches_in_model
from kneecore.study.settings import NeededAccuracySettings
from kneecore.unit_model import UnitModel

__all__ = ["NeededAccuracy", "needed_accuracy"]

FloatArray = NDArray[np.float64]
CHECK_SAMPLES = 2000
_NEXT_TO_NOTHING = 1e-6
"""Stands for no bounds at all: a model needs something that is free to vary."""


@dataclass(frozen=True, kw_only=True, eq=False)
class NeededAccuracy(Presented):
    """The widest bounds within which every model is still good enough."""

    model: Model
    """With the bounds that were stated. Read from a file, a model that is no knee has no
    function."""
    settings: NeededAccuracySettings
    """What was asked for, with nothing left open."""
    column: int
    """The output that is watched, one of the m numbers that the model returns."""
    size: float | None
    """Size of the widest bounds; None if even exactly known inputs are not enough. For knees the
    half-ranges of every length and coordinate, mm."""
    reaches_largest: bool
    """Whether the widest bounds looked at are still narrow enough, so that the answer is beyond
    them."""
    largest_value: float
    """Largest watched output of any model within the bounds (within none, where there are none)."""
    beyond: float | None
    """A size that is too large by little; None if there is none."""
    beyond_value: float | None
    """Largest watched output there: above `NeededAccuracySettings.within`."""
    sampled_value: float | None
    """Largest watched output of a random sample within the bounds: a check from the other side."""
    n_sampled: int
    tried: FloatArray
    """Sizes that were searched, and the largest watched output at each, shape (n, 2), by size."""
    in_model: bool
    """Whether the searches were exact ones in the model, and not in repaired surrogates."""
    seconds: float
    versions: Mapping[str, str]

    @property
    def n_searches(self) -> int:
        """Searches that the answer took."""
        return len(self.tried)


def _settled(model: Model, given: NeededAccuracySettings) -> NeededAccuracySettings:
    """Return the settings with the model's own in the place of those left open."""
    within = model.goal if given.within is None else given.within
    if within is None:
        raise ParameterError(
            "`within` is None; the largest value of "
            f"{model.columns[model.watched].title!r} that is good enough is needed, such as "
            "NeededAccuracySettings(within=5)"
        )
    largest = float(max(model.sizes)) if given.largest is None else given.largest
    return replace(given, within=within, largest=largest)


@dataclass(kw_only=True)
class _Bracket:
    """Bisection of the size at which the largest watched output passes the goal."""

    model: Model
    within: float
    seed: int
    steps: Steps
    tried: dict[float, float] = field(default_factory=dict)

    def value(self, size: float) -> float:
        """Return the largest watched output of any model within bounds of a size."""
        self.steps.begin()
        one = self.model.with_size(max(size, _NEXT_TO_NOTHING))
        weights = one_column(one, one.watched)
        found = best_pair(one, weights, seed=self.seed, steps=self.steps)
        self.steps.begin()  # a search that was ended early is none
        self.steps.done += 1
        self.tried[size] = float(found.seen[:, one.watched].max())
        return self.tried[size]

    def narrow(self, largest: float, tolerance: float) -> tuple[float | None, float | None]:
        """Return the largest size that is good enough, and the smallest that is not."""
        low, high = 0.0, largest
        at_low, at_high = self.value(low), self.value(high)
        if at_low > self.within:
            return None, None
        if at_high <= self.within:
            return high, None
        while high - low > tolerance:
            middle = 0.5 * (low + high)
            if not low < middle < high:  # no number is between them
                break
            if self.value(middle) <= self.within:
                low = middle
            else:
                high = middle
        return low, high


def needed_accuracy(
    model: Model,
    settings: NeededAccuracySettings | None = None,
    *,
    callback: Callback | None = None,
) -> NeededAccuracy:
    """Find how accurately the inputs must be known for every model to be good enough.

    The largest value of the watched output, over all models within the bounds, grows with their
    size; the size at which it passes what is good enough is bracketed by bisection. The answer is
    the bracket's lower end, its upper end is reported too, and the answer is checked by sampling.

    Parameters
    ----------
    model : Model
        As for `bound_sweep`. For knees the watched output is the angle at the largest extension
        moment: how far they extend.
    settings : NeededAccuracySettings, optional
    callback : callable, optional
        Gets `Progress`; a true result cancels (raises `Cancelled`).

    Raises
    ------
    ParameterError, ModelError
        As for `bound_sweep`; and if it is not known what is good enough.
    """
    given = checked_settings(model, NeededAccuracySettings, settings, callback)
    settings = _settled(model, given)
    assert settings.within is not None
    assert settings.largest is not None
    total = 2 + max(0, int(np.ceil(np.log2(settings.largest / settings.tolerance))))
    steps = Steps(callback, "bracketing the bound", total)
    begun = time.perf_counter()
    bracket = _Bracket(model=model, within=settings.within, seed=settings.seed, steps=steps)
    size, beyond = bracket.narrow(settings.largest, settings.tolerance)
    sampled = None
    if size:
        steps.begin()
        sampled = _largest_sampled(model.with_size(size), settings.seed)
    return NeededAccuracy(
        model=model,
        settings=settings,
        column=model.watched,
        size=size,
        reaches_largest=size is not None and beyond is None,
        largest_value=bracket.tried[size or 0.0],
        beyond=beyond,
        beyond_value=None if beyond is None else bracket.tried[beyond],
        sampled_value=sampled,
        n_sampled=0 if sampled is None else CHECK_SAMPLES,
        tried=np.array(sorted(bracket.tried.items())),
        in_model=searches_in_model(model),
        seconds=time.perf_counter() - begun,
        versions=versions(),
    )


def _largest_sampled(model: Model, seed: int) -> float:
    values = UnitModel(model)(uniform(CHECK_SAMPLES, model.n_free, seed))[:, model.watched]
    if not np.isfinite(values).any():
        raise ModelError("no sample within the bounds gave an answer")
    return float(np.nanmax(values))

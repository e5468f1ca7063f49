"""The cheapest tolerances with which no model passes a limit.

With tolerances t, as shares of what was stated, the largest output of any model is F(t). To first
order it is F + sum s (t' - t), and what costs sum c / t' least within the limit is
t' = sqrt(c / (l s)), at most 1, with the one l that uses the limit up. So the worst model is
searched for, the tolerances of its slopes s are taken, and these are scaled until F meets the
limit; again and again, as long as the cost falls.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kneecore.model import Model
from kneecore.study.arguments import Steps
from kneecore.study.best_search import best_pair, one_column
from kneecore.unit_model import UnitModel

__all__ = ["NEXT_TO_NOTHING", "Allocator", "Point", "cheapest_linear"]

FloatArray = NDArray[np.float64]
NEXT_TO_NOTHING = 1e-6
"""Stands for no uncertainty at all: a model needs something that is free to vary."""
_STEP = 1e-4  # of an input's range, for central differences
_ROOM = 1e-4  # of the way from the nominal value to the limit: how closely the limit is met
_GAIN = 1e-4  # of the cost: less is not worth a further step
_MAX_ROUNDS = 12
_MAX_SCALINGS = 12


@dataclass(frozen=True, kw_only=True, eq=False)
class Point:
    """Tolerances, and the worst model within them."""

    factors: FloatArray
    """Each measurement's tolerance as a share of what was stated, shape (g,)."""
    value: float
    """Largest watched output of any model."""
    gains: FloatArray
    """What each measurement's uncertainty adds to it, to first order, shape (g,); at least 0."""


def cheapest_linear(costs: FloatArray, slopes: FloatArray, limit: float) -> FloatArray:
    """Return the t of at most 1 with the least sum costs / t for which sum slopes t <= limit.

    Parameters
    ----------
    costs : ndarray, shape (g,)
        Above 0.
    slopes : ndarray, shape (g,)
        At least 0.
    limit : float
        Above 0.
    """
    t = np.ones(len(costs))
    open_ones = slopes > 0.0
    while open_ones.any():
        left = limit - slopes[~open_ones].sum()
        c, s = costs[open_ones], slopes[open_ones]
        t[open_ones] = np.sqrt(c / s) * left / np.sqrt(c * s).sum()
        over = open_ones & (t > 1.0)
        if not over.any():
            break
        t[over] = 1.0
        open_ones &= ~over
    return t


@dataclass(kw_only=True, eq=False)
class Allocator:
    """The search for a model's cheapest tolerances."""

    model: Model
    members: Sequence[NDArray[np.intp]]
    """Places of each measurement's inputs among the model's."""
    costs: FloatArray
    within: float
    seeds: tuple[int, ...]
    """Of the searches for the worst model, which are all made each time."""
    steps: Steps
    n_searches: int = 0
    nominal_value: float = field(init=False)
    """The watched output where all is known exactly."""
    _centre: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        least = self.narrowed(np.zeros(len(self.members)))
        self._centre = 0.5 * (least.lower + least.upper)
        y = UnitModel(least)(least.to_free_unit(self._centre)[None])
        self.nominal_value = float(y[0, self.model.watched])

    def cost(self, factors: FloatArray) -> float:
        """Return what tolerances cost."""
        return float((self.costs / factors).sum())

    def narrowed(self, factors: FloatArray) -> Model:
        """Return the model with bounds of these tolerances."""
        each = np.ones(len(self.model.inputs))
        for places, factor in zip(self.members, factors, strict=True):
            each[places] = max(float(factor), NEXT_TO_NOTHING)
        return self.model.with_widths(each)

    def look(self, factors: FloatArray, seeds: Sequence[int] | None = None) -> Point:
        """Search for the worst model."""
        one = self.narrowed(factors)
        weights = one_column(one, one.watched)
        found = []
        for seed in self.seeds if seeds is None else seeds:
            self.steps.begin()
            pair = best_pair(one, weights, seed=seed, steps=self.steps)
            self.steps.begin()  # a search that was ended early is none
            self.steps.advance()
            self.n_searches += 1
            found.append((float(pair.seen[:, one.watched].max()), pair.u[1]))
        value, u = max(found, key=lambda pair: pair[0])
        return Point(factors=factors, value=value, gains=self._gains(one, u, weights))

    def _gains(self, one: Model, u: FloatArray, weights: FloatArray) -> FloatArray:
        each = np.zeros(len(one.inputs))
        away = u - one.to_free_unit(self._centre)
        each[one.free] = _slopes_at(one, u, weights) * away
        return np.array([max(float(each[places].sum()), 0.0) for places in self.members])

    def meet(self, factors: FloatArray) -> Point | None:
        """Scale tolerances, at most to what was stated, until the limit is just met.

        Those that are as stated stay so. None if the limit cannot be met with these.
        """
        moved = factors < 1.0
        allowed = _ROOM * (self.within - self.nominal_value)
        scale, low, high = 1.0, 0.0, np.inf
        best: Point | None = None
        for _ in range(_MAX_SCALINGS):
            point = self.look(np.minimum(np.where(moved, scale, 1.0) * factors, 1.0))
            room, open_ones = self.within - point.value, moved & (point.factors < 1.0)
            if room >= 0.0:
                low, best = scale, point
                if room <= allowed or not open_ones.any():
                    break
            elif not open_ones.any():
                break
            else:
                high = scale
            slope = float(point.gains[open_ones].sum())
            step = (room - 0.5 * allowed) / slope if slope > 0.0 else np.sign(room)
            scale *= 1.0 + float(np.clip(step, -0.5, 1.0))
            if not low < scale < high:
                scale = 0.5 * (low + high)
        return best

    def improve(self, point: Point) -> Point:
        """Return tolerances that cost less, as long as there are any."""
        share = 1.0
        for _ in range(_MAX_ROUNDS):
            slopes = point.gains / point.factors
            limit = self.within - point.value + float(point.gains.sum())
            wanted = cheapest_linear(self.costs, slopes, limit)
            trial = self.meet(point.factors * (wanted / point.factors) ** share)
            saved = (
                0.0 if trial is None else 1.0 - self.cost(trial.factors) / self.cost(point.factors)
            )
            if trial is not None and saved > 0.0:
                point = trial
            if saved < _GAIN:
                share *= 0.5
            if saved < _GAIN and share < 0.2:
                break
        return point


def _slopes_at(model: Model, u: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the slopes of a weighted sum of outputs at a point of the unit cube, (n_free,)."""
    guide = model if model.has_gradient else model.proxy
    if guide is not None:
        slopes: FloatArray = guide.slopes(u[None], weights[None])[1][0]
        return slopes
    step = model.steps(_STEP)
    steps = np.diag(step)
    centre = np.clip(u, step, 1.0 - step)  # a worst case lies on bounds
    y = UnitModel(model)(np.concatenate([centre + steps, centre - steps])) @ weights
    return np.nan_to_num((y[: model.n_free] - y[model.n_free :]) / (2.0 * step))

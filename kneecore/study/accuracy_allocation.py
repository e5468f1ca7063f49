"""Which measurement must be how good for every model to be good enough, at the least cost.

Examples
--------
>>> import kneecore
>>> found = kneecore.accuracy_allocation(kneecore.Knee(solver="equilibrium"))
>>> found.names[int(found.gains.argmax())]  # uses most of what is allowed
'condyle_centre'
>>> found.cost < found.equal_cost
True
"""

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kneecore._arguments import shown
from kneecore._version import versions
from kneecore.errors import ParameterError
from kneecore.model import Model
from kneecore.numerics.sampling import uniform
from kneecore.presented import Presented
from kneecore.progress import Callback
from kneecore.study.arguments import Steps, checked_settings
from kneecore.study.best_search import searches_in_model
from kneecore.study.cheapest import Allocator, Point
from kneecore.study.needed_accuracy import CHECK_SAMPLES, NeededAccuracy, needed_accuracy
from kneecore.study.settings import AccuracyAllocationSettings, NeededAccuracySettings
from kneecore.unit_model import UnitModel

__all__ = [
    "ENLARGED",
    "AccuracyAllocation",
    "accuracy_allocation",
    "members_of",
    "stated_tolerances",
]

FloatArray = NDArray[np.float64]
ENLARGED = 1.1
"""By how much each tolerance alone is enlarged to see whether it could be wider."""
_SHARE_OF_BOUNDS = (100.0, "% of its bounds")
_SEARCHES = 50  # roughly, for the progress


@dataclass(frozen=True, kw_only=True, eq=False)
class AccuracyAllocation(Presented):
    """Tolerances of measurements with which every model is good enough: one for all, and cheapest.

    A tolerance of t costs `costs` times stated / t, summed over the measurements. None is wider
    than what was stated.
    """

    model: Model
    """With the bounds that were stated. Read from a file, a model that is no knee has no
    function."""
    settings: AccuracyAllocationSettings
    """What was asked for, with nothing left open but unset costs."""
    column: int
    """The output that is watched, one of the m numbers that the model returns."""
    equal: NeededAccuracy
    """One tolerance for all that the model's size is about; the others as stated."""
    names: tuple[str, ...]
    """The g measurements whose inputs vary."""
    inputs: tuple[tuple[str, ...], ...]
    """What each of them tells."""
    stated: FloatArray
    """How far their inputs may be from the middle as stated, shape (g,)."""
    units: tuple[str, ...]
    """Units of `stated`."""
    costs: FloatArray
    """What each costs that is as good as stated, shape (g,)."""
    equal_factors: FloatArray | None
    """One tolerance for all as a share of what was stated, shape (g,); None if there is none above
    0."""
    factors: FloatArray | None
    """The cheapest, likewise; None if even exactly known inputs are not enough."""
    gains: FloatArray | None
    """What each measurement's uncertainty adds to the watched output of the worst model, to first
    order, shape (g,)."""
    enlarged: FloatArray | None
    """Largest watched output where one tolerance alone is 10 % wider, at most as stated, shape
    (g,); NaN where it is as stated already."""
    nominal_value: float
    """The watched output where all is known exactly."""
    largest_value: float
    """Largest watched output of any model within the cheapest tolerances; `nominal_value` where
    there are none."""
    sampled_value: float | None
    """Largest watched output of a random sample within them."""
    n_sampled: int
    n_sampled_failed: int
    """Models of the sample that failed, and were left out."""
    n_searches: int
    """Searches for the cheapest, its checks included."""
    in_model: bool
    """Whether the searches were exact ones in the model, and not in repaired surrogates."""
    seconds: float
    versions: Mapping[str, str]

    @property
    def cost(self) -> float | None:
        """What the cheapest tolerances cost."""
        return None if self.factors is None else float((self.costs / self.factors).sum())

    @property
    def equal_cost(self) -> float | None:
        """What one tolerance for all costs."""
        if self.equal_factors is None:
            return None
        return float((self.costs / self.equal_factors).sum())

    @property
    def as_stated(self) -> NDArray[np.bool_]:
        """Which measurements need not be better than stated, shape (g,)."""
        factors = np.zeros(len(self.names)) if self.factors is None else self.factors
        return factors >= 1.0


def accuracy_allocation(
    model: Model,
    settings: AccuracyAllocationSettings | None = None,
    *,
    callback: Callback | None = None,
) -> AccuracyAllocation:
    """Find how good each measurement must be for every model to be good enough.

    Two answers: one tolerance for all, as `needed_accuracy` finds it, and the tolerances that cost
    least, where a measurement costs its `costs` times stated / tolerance. Both are held against
    exact searches of the true model; the cheapest also with other seeds, with a random sample, and
    with each tolerance enlarged alone. It is the cheapest found from one start: where the largest
    output bends strongly, a cheaper one far away may be missed.

    Parameters
    ----------
    model : Model
        As for `bound_sweep`. `Model.measurements` tells what is measured at once.
    settings : AccuracyAllocationSettings, optional
    callback : callable, optional
        Gets `Progress`; a true result cancels (raises `Cancelled`).

    Raises
    ------
    ParameterError, ModelError
        As for `needed_accuracy`; and if `costs` name no measurement of the model's.
    """
    settings = checked_settings(model, AccuracyAllocationSettings, settings, callback)
    members = members_of(model)
    costs = _costs(settings.costs or {}, tuple(members))
    begun = time.perf_counter()
    equal = needed_accuracy(
        model,
        NeededAccuracySettings(
            within=settings.within,
            largest=model.size,  # as for the cheapest: nothing is wider than stated
            tolerance=settings.tolerance,
            seed=settings.seed,
        ),
        callback=callback,
    )
    settings = replace(settings, within=equal.settings.within)
    places = [np.array(where, dtype=np.intp) for where in members.values()]
    shares = _factors(model, model.with_size(equal.size), places) if equal.size else None
    assert settings.within is not None
    allocator = Allocator(
        model=model,
        members=places,
        costs=costs,
        within=settings.within,
        seeds=(settings.seed,),
        steps=Steps(callback, "allocating", _SEARCHES),
    )
    point = _cheapest(allocator, shares)
    checks = _Checks(allocator, point, callback)
    tolerances = stated_tolerances(model, places)
    return AccuracyAllocation(
        model=model,
        settings=settings,
        column=model.watched,
        equal=equal,
        names=tuple(members),
        inputs=tuple(tuple(model.names[k] for k in where) for where in places),
        stated=np.array([stated for stated, _ in tolerances]),
        units=tuple(unit for _, unit in tolerances),
        costs=costs,
        equal_factors=shares,
        factors=None if point is None else point.factors,
        gains=None if point is None else point.gains,
        enlarged=checks.enlarged,
        nominal_value=allocator.nominal_value,
        largest_value=allocator.nominal_value if point is None else point.value,
        sampled_value=checks.sampled_value,
        n_sampled=0 if point is None else CHECK_SAMPLES,
        n_sampled_failed=checks.n_failed,
        n_searches=allocator.n_searches,
        in_model=searches_in_model(model),
        seconds=time.perf_counter() - begun,
        versions=versions(),
    )


def members_of(model: Model) -> dict[str, list[int]]:
    """Return the places of each measurement's inputs that vary."""
    members: dict[str, list[int]] = {}
    for k, name in enumerate(model.names):
        if model.free[k]:
            members.setdefault(model.measurements.get(name, name), []).append(k)
    return members


def _costs(given: Mapping[str, float], names: tuple[str, ...]) -> FloatArray:
    unknown = next((name for name in given if name not in names), None)
    if unknown is not None:
        raise ParameterError(
            f"`costs` names {shown(unknown)}; {', '.join(names)} are measurements that vary"
        )
    return np.array([given.get(name, 1.0) for name in names])


def _factors(model: Model, other: Model, places: list[NDArray[np.intp]]) -> FloatArray:
    """Return how wide another model's bounds are, by measurement, in shares of this one's."""
    width = model.upper - model.lower
    return np.array([float(((other.upper - other.lower)[k] / width[k]).max()) for k in places])


def stated_tolerances(
    model: Model, places: Iterable[Sequence[int] | NDArray[np.intp]]
) -> list[tuple[float, str]]:
    """Return each measurement's stated tolerance and its unit."""
    told = []
    for where in places:
        each = [model.stated_tolerance(model.names[k]) for k in where]
        value, unit = each[0]
        same = all(u == unit and np.isclose(v, value, rtol=1e-6) for v, u in each)
        told.append((value, unit) if same else _SHARE_OF_BOUNDS)
    return told


def _cheapest(allocator: Allocator, shares: FloatArray | None) -> Point | None:
    """Return the cheapest tolerances; None if even exactly known inputs are not enough."""
    if not allocator.nominal_value < allocator.within:
        return None
    n, seed = len(allocator.members), allocator.seeds[0]
    widest = allocator.look(np.ones(n))
    if widest.value <= allocator.within:
        return widest
    begin = np.full(n, 0.1) if shares is None else np.minimum(shares, 1.0)
    point = allocator.meet(begin)
    if point is None:
        return None
    point = allocator.improve(point)
    for other in range(seed + 1, seed + 4):  # what one search misses, another may find
        again = allocator.look(point.factors, [other])
        if again.value <= allocator.within:
            value = max(point.value, again.value)
            return replace(point, value=value)
        allocator.seeds = (*allocator.seeds, other)
        narrower = allocator.meet(point.factors)
        if narrower is None:
            return None
        point = narrower
    return point


class _Checks:
    """What is held against the cheapest tolerances."""

    enlarged: FloatArray | None = None
    sampled_value: float | None = None
    n_failed: int = 0

    def __init__(
        self, allocator: Allocator, point: Point | None, callback: Callback | None
    ) -> None:
        if point is None:
            return
        narrowed = allocator.narrowed(point.factors)
        u = uniform(CHECK_SAMPLES, narrowed.n_free, allocator.seeds[0])
        y = UnitModel(narrowed)(u)[:, narrowed.watched]
        self.n_failed = int(np.count_nonzero(~np.isfinite(y)))
        if self.n_failed < len(y):
            self.sampled_value = float(np.nanmax(y))
        open_ones = np.flatnonzero(point.factors < 1.0)
        allocator.steps = Steps(callback, "enlarging each tolerance", len(open_ones))
        self.enlarged = np.full(len(point.factors), np.nan)
        for k in open_ones:
            factors = point.factors.copy()
            factors[k] = min(ENLARGED * factors[k], 1.0)
            self.enlarged[k] = allocator.look(factors, allocator.seeds[:1]).value

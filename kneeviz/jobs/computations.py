"""The long computations that a page asks kneecore for, each as work for a `Job`."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

import kneecore
from kneecore import (
    AccuracyAllocation,
    AccuracyAllocationSettings,
    InfluenceResult,
    InfluenceSettings,
    Knee,
    Landscape,
    MethodTrace,
    MonteCarloResult,
    SamplingSettings,
    SearchResult,
    SearchSettings,
    TrainedSurrogate,
)
from kneeviz.jobs.job import Watch

FloatArray = NDArray[np.float64]
Result = TypeVar("Result")
Work = Callable[[Watch], Result]


@dataclass(frozen=True, kw_only=True, eq=False)
class Compared:
    """What all methods found, and where."""

    model: Knee
    settings: SearchSettings
    methods: tuple[MethodTrace, ...]


def search(knee: Knee, settings: SearchSettings) -> Work[SearchResult]:
    """Return the worst-case search."""
    return lambda watch: kneecore.worst_case(knee, settings, callback=watch)


def comparison(knee: Knee, settings: SearchSettings) -> Work[Compared]:
    """Return the comparison of the search's methods."""
    return lambda watch: Compared(
        model=knee,
        settings=settings,
        methods=kneecore.compare_methods(knee, settings, callback=watch),
    )


def sampling(
    knee: Knee, settings: SamplingSettings, marks: FloatArray | None
) -> Work[MonteCarloResult]:
    """Return the sampling of the true model; `marks`, angles in deg, are held against it."""
    return lambda watch: kneecore.monte_carlo(knee, settings, marks=marks, callback=watch)


def influence(knee: Knee, settings: InfluenceSettings) -> Work[InfluenceResult]:
    """Return the sensitivity analysis."""
    return lambda watch: kneecore.influence(knee, settings, callback=watch)


def accuracy(knee: Knee, settings: AccuracyAllocationSettings) -> Work[AccuracyAllocation]:
    """Return the search for how good each measurement must be."""
    return lambda watch: kneecore.accuracy_allocation(knee, settings, callback=watch)


def landscape(
    knee: Knee, x: FloatArray, names: tuple[str, str], surrogate: TrainedSurrogate | None
) -> Landscape:
    """Run kneecore over the grid of a landscape."""
    return kneecore.landscape(knee, names, x=x, surrogate=surrogate)

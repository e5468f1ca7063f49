"""The long computations that a model's page asks kneecore for, each as work for a `Job`."""

import numpy as np
from numpy.typing import NDArray

import kneecore
from kneecore import (
    InfluenceResult,
    InfluenceSettings,
    Landscape,
    Model,
    MonteCarloResult,
    SamplingSettings,
    SearchResult,
    SearchSettings,
    TrainedSurrogate,
)
from kneecore.search.settings import enough_samples
from kneecore.search.worst_case import usual_settings
from kneeviz.jobs.computations import Work

FloatArray = NDArray[np.float64]

GRID = 21
"""Points along each input of a landscape in the model."""
FINE_GRID = 33
"""The same in the surrogate alone."""


def usual(model: Model) -> SearchSettings:
    """Return how a model is searched if nothing else is wanted."""
    return usual_settings(model)


def n_learning(model: Model) -> int:
    """Return the runs that a surrogate is fitted to."""
    return enough_samples(model.n_free)


def learning(model: Model) -> Work[TrainedSurrogate]:
    """Return the runs for a surrogate, and its fit."""
    n = n_learning(model)
    return lambda watch: kneecore.fit_surrogate(model, n_samples=n, callback=watch)


def search(model: Model, settings: SearchSettings) -> Work[SearchResult]:
    """Return the worst-case search."""
    return lambda watch: kneecore.worst_case(model, settings, callback=watch)


def sampling(model: Model, settings: SamplingSettings) -> Work[MonteCarloResult]:
    """Return the sampling that the band is drawn from."""
    return lambda watch: kneecore.monte_carlo(model, settings, callback=watch)


def influence(model: Model, settings: InfluenceSettings) -> Work[InfluenceResult]:
    """Return the sensitivity analysis."""
    return lambda watch: kneecore.influence(model, settings, callback=watch)


def landscape(
    model: Model,
    names: tuple[str, str],
    x: FloatArray,
    surrogate: TrainedSurrogate | None,
    n_points: int,
) -> Work[Landscape]:
    """Return a grid over two inputs."""
    return lambda watch: kneecore.landscape(
        model, names, x=x, surrogate=surrogate, n_points=n_points, callback=watch
    )


def stand_in(trained: TrainedSurrogate) -> Model:
    """Return a surrogate as a model of its own, for studies of a model that is slow."""
    model = trained.model
    return Model(
        trained.predict,
        model.inputs,
        model.outputs,
        batched=True,
        correlation=model.correlation,
        name=f"surrogate of {model.name}"[:200],
        threads=model.threads,
    )

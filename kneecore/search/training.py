"""The surrogate of any batched model on the unit cube, and the samples behind it."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ModelError, ParameterError
from kneecore.numerics.sampling import uniform
from kneecore.numerics.surrogate import Surrogate
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.settings import PairSettings

__all__ = ["Training", "UnitModel", "outputs_of", "train"]

FloatArray = NDArray[np.float64]
UnitModel = Callable[[FloatArray], FloatArray]
"""Maps points of the unit cube (n, d) to outputs (n, m); a row of NaN is a failure."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Training:
    """A surrogate and the samples it was fitted to."""

    surrogate: Surrogate
    points: FloatArray
    """All samples, failed ones included, shape (n, d), unit cube."""
    values: FloatArray
    """Their outputs, shape (n, m); NaN rows failed and were left out of the fit."""
    seconds_sampling: float
    seconds_fit: float

    @property
    def n_failed(self) -> int:
        """Number of samples whose model failed."""
        return int(np.count_nonzero(~np.isfinite(self.values).all(axis=1)))

    @property
    def loo_rms(self) -> float | None:
        """Root mean square of the leave-one-out errors, in the outputs' unit; None if unknown."""
        errors = self.surrogate.loo_errors
        return float(np.sqrt(np.mean(errors**2))) if np.isfinite(errors).all() else None


def train(
    model: UnitModel, n_dimensions: int, settings: PairSettings, callback: Callback | None = None
) -> Training:
    """Sample the model uniformly and fit a surrogate.

    Raises
    ------
    ParameterError
        If there are too few samples for the linear tail.
    ModelError
        If too many of them failed.
    """
    settings.check_training(n_dimensions)
    report = callback or (lambda _: None)
    n = settings.training_samples
    if report(Progress(stage="sampling", done=0, total=n)):
        raise Cancelled
    start = time.perf_counter()
    points = uniform(n, n_dimensions, settings.seed)
    values = outputs_of(model, points)
    sampled = time.perf_counter()
    report(Progress(stage="sampling", done=n, total=n))
    good = np.isfinite(values).all(axis=1)
    if np.count_nonzero(good) < n_dimensions + 1:
        raise ModelError(
            f"{np.count_nonzero(~good)} of {n} training samples failed; the surrogate needs "
            f"{n_dimensions + 1} that did not"
        )
    if report(Progress(stage="fit", done=0, total=1)):
        raise Cancelled
    surrogate = Surrogate.fit(points[good], values[good])
    return Training(
        surrogate=surrogate,
        points=points,
        values=values,
        seconds_sampling=sampled - start,
        seconds_fit=time.perf_counter() - sampled,
    )


def outputs_of(model: UnitModel, points: FloatArray, n_values: int | None = None) -> FloatArray:
    """Return the model's outputs, checked to have one row a point (and `n_values` columns)."""
    given = model(points)
    try:
        values = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError("`model` returned something other than an array of numbers") from None
    wanted = "m" if n_values is None else str(n_values)
    fits = values.ndim == 2 and len(values) == len(points) and values.shape[1] > 0
    if not fits or n_values not in (None, values.shape[1]):
        raise ParameterError(
            f"`model` returned shape {values.shape} for {len(points)} rows; "
            f"({len(points)}, {wanted}) is allowed"
        )
    return values

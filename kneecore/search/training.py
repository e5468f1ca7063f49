"""The surrogate of a model, and the samples behind it.

Examples
--------
>>> import kneecore
>>> knee = kneecore.Knee(kneecore.ParameterSpace(case="material"))
>>> surrogate = kneecore.fit_surrogate(knee, n_samples=20)
>>> surrogate.predict(knee.nominal[None]).shape
(1, 12)
"""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._arrays import numbers
from kneecore.errors import ModelError, ParameterError
from kneecore.model import Model
from kneecore.numerics.sampling import batches
from kneecore.numerics.sampling_options import check_count
from kneecore.numerics.surrogate import Surrogate
from kneecore.progress import Callback, Cancelled, Clock, Progress
from kneecore.search.arguments import check_model, checked
from kneecore.search.discrete import first_points
from kneecore.search.settings import SearchSettings
from kneecore.unit_model import UnitModel

__all__ = ["TrainedSurrogate", "Training", "fit_surrogate", "surrogate_through", "train"]

FloatArray = NDArray[np.float64]

_ENOUGH = 3  # samples for each input: of fewer, what is inside the bounds cannot be told
_INWARDS = 0.01  # of the cube's width: how far from the corners those lie at most


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
        if not np.isfinite(errors).all():
            return None
        with np.errstate(over="ignore"):  # squares of more than 1e154
            rms = float(np.sqrt(np.mean(errors**2)))
        return rms if np.isfinite(rms) else None


def train(model: UnitModel, settings: SearchSettings, callback: Callback | None = None) -> Training:
    """Sample the model and fit a surrogate.

    The samples are uniform as in the paper for a knee, a Latin hypercube for other models: their
    runs are few and dear. Where they are fewer than three an input, and more runs will follow, they
    lie at corners: of so many inputs only effects from bound to bound can be told.

    Raises
    ------
    ParameterError
        If there are too few samples for the linear tail.
    ModelError
        If too many of them failed.
    """
    n_dimensions = model.model.n_free
    settings.check_training(n_dimensions)
    report = callback or (lambda _: None)
    n = settings.n_training
    if report(Progress(stage="sampling", done=0, total=n)):
        raise Cancelled
    start = time.perf_counter()
    points = _points(model.model, settings)
    clock = Clock()

    def watch(done: int) -> object:
        left = clock.left(done, n - done + settings.n_repair)
        return report(Progress(stage="sampling", done=done, total=n, seconds_left=left))

    values = model(points, watch)
    sampled = time.perf_counter()
    report(Progress(stage="sampling", done=n, total=n))
    good = np.isfinite(values).all(axis=1)
    if np.count_nonzero(good) < n_dimensions + 1:
        raise ModelError(
            f"{np.count_nonzero(~good)} of {n} training samples failed; the surrogate needs "
            f"{n_dimensions + 1} that did not{model.model.told_failure}"
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


def _points(model: Model, settings: SearchSettings) -> FloatArray:
    n, d, seed = settings.n_training, model.n_free, settings.seed
    if model.in_corners or model.grids:
        return first_points(model, n, seed)
    points = next(batches(n, d, seed, sampling="latin-hypercube", size=n))
    if not settings.repair or n >= _ENOUGH * d:
        return points
    return _folded(points)


def _folded(points: FloatArray) -> FloatArray:
    """Move points (n, d) to corners, the second half to those across from the first.

    That tells the inputs' own effects from those of two together (G. E. P. Box, K. B. Wilson 1951,
    J. R. Stat. Soc. B 13:1-45). Where corners so few do not tell all inputs apart the points stay.
    """
    corners, n = np.round(points), len(points)
    # No two may be the same: a spline is fitted.
    inwards = 2.0 * _INWARDS * np.abs(points - corners)
    corners[n // 2 :] = 1.0 - corners[: n - n // 2]
    if np.linalg.matrix_rank(corners - 0.5) < points.shape[1]:
        return points
    return corners + inwards * (1.0 - 2.0 * corners)


@dataclass(frozen=True, kw_only=True, eq=False)
class TrainedSurrogate:
    """A surrogate of a model over its bounds."""

    model: Model
    training: Training
    """Samples in the unit cube of the free inputs."""

    @property
    def training_x(self) -> FloatArray:
        """Inputs of the training samples, shape (n, d)."""
        return self.model.from_free_unit(self.training.points)

    @property
    def training_y(self) -> FloatArray:
        """Outputs of the training samples, shape (n, m); NaN where the model failed."""
        return self.training.values

    @property
    def n_failed(self) -> int:
        """Number of training samples whose model failed."""
        return self.training.n_failed

    @property
    def loo_rms(self) -> float | None:
        """Root mean square leave-one-out error, in the outputs' unit; None if unknown."""
        return self.training.loo_rms

    def predict(self, x: ArrayLike) -> FloatArray:
        """Return the predicted outputs, shape (..., d) -> (..., m).

        Inputs that are held are not looked at.
        """
        u = self.model.to_free_unit(x)
        return self.training.surrogate(np.atleast_2d(u)).reshape(*u.shape[:-1], -1)


def fit_surrogate(
    model: Model,
    *,
    n_samples: int = 50,
    seed: int = 0,
    callback: Callback | None = None,
) -> TrainedSurrogate:
    """Fit a surrogate to samples of a model, uniform within its bounds.

    Parameters
    ----------
    model : Model
    n_samples : int
        Model runs; at least one more than there are free inputs.
    seed : int
        The same seed gives the same surrogate as `worst_case` uses.
    callback : callable, optional
        Gets `Progress`; a true result cancels (raises `Cancelled`).

    Raises
    ------
    ParameterError, ModelError
        If there are too few samples, or too many of them failed.
    """
    n = check_count("n_samples", n_samples)
    settings = checked(model, SearchSettings(training_samples=n, seed=seed), callback)
    return TrainedSurrogate(model=model, training=train(UnitModel(model), settings, callback))


def surrogate_through(model: Model, x: ArrayLike, y: ArrayLike) -> TrainedSurrogate:
    """Return the surrogate through samples that are there already, such as those of a search.

    Parameters
    ----------
    model : Model
    x : array_like, shape (n, d)
        Within its bounds.
    y : array_like, shape (n, m)
        The model's outputs; a row that is not finite failed, and is left out.

    Raises
    ------
    ParameterError
        If too few of them did not fail, or they have another shape.
    """
    check_model(model)
    points = model.to_free_unit(x)
    values = numbers("y", y)
    if values.shape != (len(points), model.n_outputs):
        raise ParameterError(
            f"`y` has shape {values.shape}; ({len(points)}, {model.n_outputs}) is needed, a row "
            "for each point of `x`"
        )
    begun = time.perf_counter()
    good = np.isfinite(values).all(axis=1)
    if np.count_nonzero(good) < model.n_free + 1:
        raise ParameterError(
            f"`y` has {np.count_nonzero(good)} finite rows; at least {model.n_free + 1} are needed"
        )
    training = Training(
        surrogate=Surrogate.fit(points[good], values[good]),
        points=points,
        values=values,
        seconds_sampling=0.0,
        seconds_fit=time.perf_counter() - begun,
    )
    return TrainedSurrogate(model=model, training=training)

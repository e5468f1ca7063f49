"""The knee as the search sees it: a batched model on the unit cube of the free parameters."""

from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._arguments import callback_or_none, choice
from kneecore._threads import thread_count
from kneecore.knee.parameters import check_physical
from kneecore.knee.physics.dynamics import flexion_of, respond
from kneecore.knee.physics.equilibrium import equilibria
from kneecore.knee.response import MOMENT, RestLength, Solver, prepare
from kneecore.knee.space import ParameterSpace, check_space
from kneecore.progress import Callback
from kneecore.search.settings import PairSettings
from kneecore.search.training import Training, train

__all__ = ["KneeModel", "KneeSurrogate", "Objective", "fit_surrogate", "load_weights"]

FloatArray = NDArray[np.float64]
Objective = Literal["all", "extension", "flexion"]


def load_weights(objective: str) -> FloatArray:
    """Return which of the 12 loads count, as weights 0 and 1.

    Raises
    ------
    ParameterError
        If `objective` is not `all`, `extension` or `flexion`.
    """
    said = "'all', 'extension' or 'flexion' is allowed"
    objective = choice("objective", objective, get_args(Objective), said)
    if objective == "all":
        return np.ones(len(MOMENT))
    return np.where((MOMENT > 0) == (objective == "extension"), 1.0, 0.0)


@dataclass(eq=False)
class KneeModel:
    """The true model of a space: unit cube of the free parameters -> 12 angles in deg.

    It counts what it simulates: `n_simulated`, `n_failed` (with the solver "equilibrium", models
    that have lost theirs), `n_refined` (a smaller time step was needed), `n_unsettled` (not at rest
    at some load).
    """

    space: ParameterSpace
    rest_length: RestLength = "recomputed"
    threads: int | None = None
    solver: Solver = "dynamics"
    n_simulated: int = field(default=0, init=False)
    n_failed: int = field(default=0, init=False)
    n_refined: int = field(default=0, init=False)
    n_unsettled: int = field(default=0, init=False)

    def __call__(self, u: FloatArray) -> FloatArray:
        """Return flexion angles (deg), shape (n, n_free) -> (n, 12); NaN for failed models."""
        x = self.space.from_free_unit(u)
        rows = prepare(x, self.space.baseline, self.rest_length)
        self.n_simulated += len(u)
        if self.solver == "equilibrium":
            poses, lost_at = equilibria(rows, self.threads)
            self.n_failed += int(np.count_nonzero(~np.isnan(lost_at)))
            return np.degrees(flexion_of(poses))
        poses, settled, refinements = respond(rows, self.threads)
        failed = refinements < 0
        self.n_failed += int(np.count_nonzero(failed))
        self.n_refined += int(np.count_nonzero(refinements > 0))
        self.n_unsettled += int(np.count_nonzero(~settled.all(axis=1) & ~failed))
        return np.degrees(flexion_of(poses))


@dataclass(frozen=True, kw_only=True, eq=False)
class KneeSurrogate:
    """A surrogate of the knee's 12 angles over a parameter space."""

    space: ParameterSpace
    training: Training
    """Samples in the unit cube of the free parameters, angles in deg."""

    @property
    def training_x(self) -> FloatArray:
        """Parameters of the training samples, shape (n, 28), SI."""
        return self.space.from_free_unit(self.training.points)

    @property
    def training_flexion(self) -> FloatArray:
        """Angles of the training samples, shape (n, 12), rad; NaN where the model failed."""
        return np.radians(self.training.values)

    @property
    def n_failed(self) -> int:
        """Number of training samples whose model failed."""
        return self.training.n_failed

    @property
    def loo_rms_deg(self) -> float | None:
        """Root mean square leave-one-out error, deg; None if there are too few samples for it."""
        return self.training.loo_rms

    def predict(self, x: ArrayLike) -> FloatArray:
        """Return the predicted flexion angles (rad) of knees, shape (..., 28) -> (..., 12).

        The parameters that the space holds at the baseline are not looked at.
        """
        models = check_physical(x, "x")
        u = self.space.to_unit(np.atleast_2d(models))[:, self.space.free]
        flexion = np.radians(self.training.surrogate(u))
        return flexion[0] if models.ndim == 1 else flexion


def fit_surrogate(
    space: ParameterSpace,
    *,
    n_samples: int = 50,
    seed: int = 0,
    rest_length: RestLength = "recomputed",
    threads: int | None = None,
    callback: Callback | None = None,
) -> KneeSurrogate:
    """Fit a surrogate to Monte-Carlo samples of the knee, uniform in the bounds.

    Parameters
    ----------
    space : ParameterSpace
    n_samples : int
        Model runs; at least one more than there are free parameters.
    seed : int
        The same seed gives the same surrogate as `worst_case` uses.
    rest_length, threads
        As for `simulate_batch`.
    callback : callable, optional
        Gets `Progress`; a true result cancels (raises `Cancelled`).

    Raises
    ------
    ParameterError, ModelError
        If there are too few samples, or too many of them failed.
    """
    check_space(space)
    callback_or_none(callback)
    choice("rest_length", rest_length, get_args(RestLength))
    thread_count(threads)
    settings = PairSettings(training_samples=n_samples, seed=seed)
    model = KneeModel(space, rest_length, threads)
    return KneeSurrogate(space=space, training=train(model, space.n_free, settings, callback))

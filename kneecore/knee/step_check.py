"""The audit of the time step: the same motion once more with half of it."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore.knee.physics.dynamics import attempt, flexion_of, respond_by_run
from kneecore.knee.response import Response, RestLength, prepare

__all__ = ["MOVED_DEG", "half_step_change", "with_half_step"]

MOVED_DEG = 0.05
"""An angle that half the step moves by more is reported."""

FloatArray = NDArray[np.float64]


def half_step_change(
    X: ArrayLike,
    *,
    baseline: ArrayLike | None = None,
    rest_length: RestLength = "recomputed",
    threads: int | None = None,
) -> FloatArray:
    """Return by how much half the time step moves each angle of the motion.

    Parameters
    ----------
    X, baseline, rest_length, threads
        As for `simulate_batch`. Each run is repeated with half of the step that it was accepted
        with, refined or not.

    Returns
    -------
    ndarray, shape (n, 12)
        rad, positive where half the step flexes more; NaN where the model failed, infinite where
        the run with half the step leaves its senses.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    rows = prepare(X, baseline, rest_length)
    poses, _, halvings = respond_by_run(rows, threads)
    before = flexion_of(poses).reshape(2 * len(rows), -1)
    change = np.full_like(before, np.nan)
    alive = np.repeat(halvings.min(axis=1) >= 0, 2)
    for done in np.unique(halvings.ravel()[alive]):
        runs = np.flatnonzero(alive & (halvings.ravel() == done))
        trial = attempt(rows, runs, int(done) + 1, threads)
        with np.errstate(invalid="ignore"):
            moved = flexion_of(trial.poses) - before[runs]
        moved[trial.wild] = np.inf
        change[runs] = moved
    return change.reshape(len(rows), -1)


def with_half_step(
    response: Response,
    x: ArrayLike,
    *,
    baseline: ArrayLike | None = None,
    rest_length: RestLength = "recomputed",
) -> Response:
    """Return a response in motion with its audit, `x` being its knee."""
    change = half_step_change(x, baseline=baseline, rest_length=rest_length)
    return replace(response, half_step_change=change[0])

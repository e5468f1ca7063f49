"""The load programme, and the rule by which a run is accepted, repeated or given up.

Four milliseconds are near the limit of semi-implicit Euler for so stiff a knee, and an integration
that rings gives itself away by nothing but its energy. A run is *wild* if it turns non-finite or by
150 deg, *hot* if it still moves with more than 5 mJ at a plateau's end. One that is neither is
accepted; others are repeated with the step halved. A pre-stressed knee may ring by itself, whatever
the step: a hot run that agrees with the one before it, and has settled wherever it is hot, is
accepted too. A run that is wild with two successive steps has dislocated.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kneecore.knee.physics.forces import INERTIA, MASS, THETA_0
from kneecore.knee.physics.lanes import integrate

MOMENTS = (0.1, 0.2, 0.4, 0.8, 2.0, 5.0)
"""Sizes of the moment, N m, in the order of the load programme."""
PLATEAU_STEPS = (1750, 1000, 750, 750, 750, 750)
"""Steps on each moment: they start at 0, 7, 11, 14, 17 and 20 s, and the run ends at 23 s."""
SETTLE_STEPS = 125
"""Steps (0.5 s) at a plateau's end over which a settled angle changes by less than 0.2 deg."""
SETTLE_ANGLE = math.radians(0.2)
KINETIC_LIMIT = 5e-3
"""J; more at a plateau's end is a hot run."""
TURN_LIMIT = math.radians(150.0)
"""Largest turn away from the load-free pose that counts as a knee."""
SAME_ANGLE = math.radians(0.2)
"""By less than this a hot run's plateau ends may differ from those with twice its step."""
MAX_REFINEMENTS = 3

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]
ByteArray = NDArray[np.int8]


class Trial(NamedTuple):
    """What runs gave with one time step."""

    poses: FloatArray
    """x, y (m) and psi (rad) at the six plateau ends, shape (n_runs, 6, 3)."""
    settled: BoolArray
    """Shape (n_runs, 6)."""
    wild: BoolArray
    """Shape (n_runs,)."""
    hot: BoolArray
    """At which plateau ends, shape (n_runs, 6)."""

    def chosen(self, mask: BoolArray) -> "Trial":
        """Return the part of the runs that `mask` names."""
        return Trial(self.poses[mask], self.settled[mask], self.wild[mask], self.hot[mask])


def plateau_segments() -> tuple[IntArray, FloatArray]:
    """Return (steps, moments) of the load programme, each plateau cut 0.5 s before its end."""
    steps = [part for n in PLATEAU_STEPS for part in (n - SETTLE_STEPS, SETTLE_STEPS)]
    return np.array(steps), np.repeat(np.array(MOMENTS), 2)


def kinetic_energy(states: FloatArray) -> FloatArray:
    """Return the kinetic energy (J) of states of shape (..., 6)."""
    vx, vy, omega = states[..., 3], states[..., 4], states[..., 5]
    return 0.5 * MASS * (vx * vx + vy * vy) + 0.5 * INERTIA * omega * omega


def attempt(
    rows: FloatArray, runs: IntArray, refinements: int, threads: int | None = None
) -> Trial:
    """Take `runs` through the load programme with the time step halved `refinements` times."""
    steps, moments = plateau_segments()
    states, farthest = integrate(
        rows, runs, steps, moments, refinements=refinements, threads=threads
    )
    ends = states[:, 1::2]
    with np.errstate(invalid="ignore", over="ignore"):
        late_turn = np.abs(ends[:, :, 2] - states[:, 0::2, 2])
        hot = ~(kinetic_energy(ends) <= KINETIC_LIMIT)
        wild = ~(np.isfinite(states).all(axis=(1, 2)) & (farthest < TURN_LIMIT))
    return Trial(ends[:, :, :3], late_turn < SETTLE_ANGLE, wild, hot)


def accepted(trial: Trial, before: Trial | None) -> BoolArray:
    """Return which runs are accepted, shape (n_runs,), given those with twice the step."""
    calm = ~trial.wild & ~trial.hot.any(axis=1)
    if before is None:
        return calm
    with np.errstate(invalid="ignore"):
        moved = np.abs(trial.poses[:, :, 2] - before.poses[:, :, 2])
        rings = (moved < SAME_ANGLE).all(axis=1) & (trial.settled | ~trial.hot).all(axis=1)
    return calm | (~trial.wild & ~before.wild & rings)


def respond_by_run(
    rows: FloatArray, threads: int | None = None, most_halvings: int = MAX_REFINEMENTS
) -> tuple[FloatArray, BoolArray, ByteArray]:
    """Return each model's pose at the end of its 12 plateaus.

    A run that is not accepted with the step halved `most_halvings` times has failed.

    Returns
    -------
    poses : ndarray, shape (n, 12, 3)
        x, y, psi: six of extension, then six of flexion; NaN where the model failed.
    settled : ndarray of bool, shape (n, 12)
        False where the model failed.
    halvings : ndarray of int8, shape (n, 2)
        Of the time step, that the run in extension and the one in flexion needed; -1 for a failed
        run.
    """
    n_runs = 2 * len(rows)
    poses = np.full((n_runs, len(MOMENTS), 3), np.nan)
    settled = np.zeros((n_runs, len(MOMENTS)), dtype=bool)
    halvings: ByteArray = np.full(n_runs, -1, dtype=np.int8)
    pending, before = np.arange(n_runs), None
    for refinements in range(most_halvings + 1):
        if len(pending) == 0:
            break
        trial = attempt(rows, pending, refinements, threads)
        good = accepted(trial, before)
        done = pending[good]
        poses[done], settled[done] = trial.poses[good], trial.settled[good]
        halvings[done] = refinements
        again = ~good if before is None else ~good & ~(trial.wild & before.wild)
        pending, before = pending[again], trial.chosen(again)
    poses, settled = poses.reshape(-1, 12, 3), settled.reshape(-1, 12)
    halvings = halvings.reshape(-1, 2)
    failed = halvings.min(axis=1) < 0
    poses[failed], settled[failed] = np.nan, False
    return poses, settled, halvings


def worse_run(halvings: ByteArray) -> ByteArray:
    """Return the halvings (n,) of each model's worse run, -1 where one failed, from (n, 2)."""
    lower, higher = halvings[:, 0], halvings[:, 1]
    worse: ByteArray = np.where(np.minimum(lower, higher) < 0, -1, np.maximum(lower, higher))
    return worse.astype(np.int8)


def respond(
    rows: FloatArray, threads: int | None = None, most_halvings: int = MAX_REFINEMENTS
) -> tuple[FloatArray, BoolArray, ByteArray]:
    """Return `respond_by_run`, with the halvings of each model's worse run, shape (n,)."""
    poses, settled, halvings = respond_by_run(rows, threads, most_halvings)
    return poses, settled, worse_run(halvings)


def flexion_of(poses: FloatArray) -> FloatArray:
    """Return the flexion angle (rad) of poses of shape (..., 3)."""
    return THETA_0 - poses[..., 2]

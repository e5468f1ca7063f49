"""The 12 equilibria of a knee without the transient.

A Newton walk in lanes (`physics.newton_walk`) finds nearly all of them. Where it is in
doubt about its path, the path is looked at in small turns (`physics.load_path`): either the
walk was right, or the path is traced from there, and the trace either finds the equilibria or says
at which load there is none to follow. A model that has lost its equilibrium gets the dynamics'
poses, marked by that load.
"""

import numpy as np
from numpy.typing import NDArray

from kneecore._jit import inner, kernel
from kneecore._threads import run_all, thread_count
from kneecore.knee.physics.dynamics import MOMENTS, respond
from kneecore.knee.physics.load_path import rises, trace
from kneecore.knee.physics.newton_walk import LANES, walk
from kneecore.knee.physics.pose import ORIGIN_X, ORIGIN_Y
from kneecore.knee.physics.potential import about_origin, all_terms, move_to_mass_centre

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_STRAINED = 1e-9  # J
_SAME_TURN = 1e-6  # rad: two solvers' psi in the same equilibrium


@inner
def _begins_free(row: FloatArray) -> bool:
    """Tell whether nothing is strained in the load-free pose, so that the way from it is one."""
    h = np.empty(10)
    all_terms(row, row[ORIGIN_X], row[ORIGIN_Y], 0.0, h)
    return bool(h[0] < _STRAINED)


@inner
def _clear_doubts(
    row: FloatArray, sign: float, moments: FloatArray, doubt: BoolArray, poses: FloatArray
) -> float:
    """Trace a run from where its walk was wrong; return the moment at which it is lost, or NaN."""
    if doubt[0] and not (_begins_free(row) and np.isfinite(poses[0, 2])):
        first = np.empty((1, 3))
        found = trace(row, sign, moments[:1], 0, first) < 0
        if not (found and abs(first[0, 2] - poses[0, 2]) < _SAME_TURN):
            k = trace(row, sign, moments, 0, poses)
            return sign * moments[k] if k >= 0 else np.nan
    for k in range(1, moments.shape[0]):
        if doubt[k] and not rises(row, sign, poses[k - 1], poses[k]):
            k = trace(row, sign, moments, k, poses)
            return sign * moments[k] if k >= 0 else np.nan
    return np.nan


@kernel
def _solve(rows: FloatArray, moments: FloatArray, poses: FloatArray, lost: FloatArray) -> None:
    """Fill `poses` (2 n, 6, 3) of the mass centre and `lost` (2 n,) for n models' two runs."""
    n_runs = lost.shape[0]
    moved = about_origin(rows)
    doubt = np.empty((n_runs, moments.shape[0]), dtype=np.bool_)
    walk(moved, np.arange(n_runs), moments, poses, doubt)
    for r in range(n_runs):
        sign = 1.0 - 2.0 * (r % 2)
        lost[r] = _clear_doubts(moved[r // 2], sign, moments, doubt[r], poses[r])
    move_to_mass_centre(poses)


def equilibria(rows: FloatArray, threads: int | None = None) -> tuple[FloatArray, FloatArray]:
    """Return each model's pose in its 12 equilibria, and the load at which it lost them.

    Parameters
    ----------
    rows : ndarray, shape (n, 36)
        Constants of each model.
    threads : int, optional
        Threads to use; all cores for None. The numbers do not depend on it.

    Returns
    -------
    poses : ndarray, shape (n, 12, 3)
        x, y (m) of the mass centre and psi (rad): six of extension, then six of flexion; NaN for a
        model that lost its equilibrium.
    lost_at : ndarray, shape (n,)
        The smallest moment (N m, extension positive) at which no equilibrium was left to follow;
        NaN where all 12 were found.
    """
    n_models, moments = len(rows), np.array(MOMENTS)
    poses = np.empty((2 * n_models, len(MOMENTS), 3))
    lost = np.empty(2 * n_models)
    # Lanes idle at the end of a chunk: few chunks, but enough to even out the threads' load.
    size = max(2 * LANES, -(-n_models // (4 * thread_count(threads))))

    def work(first: int) -> None:
        models, runs = slice(first, first + size), slice(2 * first, 2 * (first + size))
        _solve(rows[models], moments, poses[runs], lost[runs])

    run_all(work, range(0, n_models, size), threads)
    extension, flexion = lost[0::2], lost[1::2]
    first_lost = np.fmin(extension, -flexion)
    lost_at = np.where(extension == first_lost, first_lost, -first_lost)
    # A NaN's sign depends on how NumPy takes the minimum of so many; one NaN for all.
    lost_at[np.isnan(lost_at)] = np.nan
    poses = poses.reshape(n_models, 2 * len(MOMENTS), 3)
    poses[~np.isnan(lost_at)] = np.nan
    return poses, lost_at


def settle(
    rows: FloatArray, threads: int | None = None
) -> tuple[FloatArray, BoolArray, NDArray[np.int8], FloatArray]:
    """Return the 12 equilibria, or the dynamics' poses where an equilibrium was lost.

    Returns
    -------
    poses, settled, refinements
        As `physics.dynamics.respond`; all loads are settled where the equilibria were found.
    lost_at : ndarray, shape (n,)
        As `equilibria`; not NaN marks the models whose poses are the dynamics'.
    """
    poses, lost_at = equilibria(rows, threads)
    settled = np.ones(poses.shape[:2], dtype=np.bool_)
    refinements = np.zeros(len(rows), dtype=np.int8)
    lost = ~np.isnan(lost_at)
    if lost.any():
        poses[lost], settled[lost], refinements[lost] = respond(rows[lost], threads)
    return poses, settled, refinements, lost_at

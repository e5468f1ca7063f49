"""Semi-implicit Euler, many models abreast: lanes of a vector within a core, threads across cores.

A *run* is one model in one direction of the moment. Sixteen runs share a group of lanes: one inner
loop over the lanes holds the whole step, on flat arrays indexed ``A[row * LANES + lane]`` with a
compile-time number of lanes (LLVM's vectoriser gives up on two-dimensional arrays, and eight lanes
were not vectorised at all). Lanes never look at each other, so a run's result does not depend on
its group.
"""

import numpy as np
from numpy.typing import NDArray

from kneecore._jit import inline, kernel, written_in
from kneecore._threads import run_all, thread_count
from kneecore.knee.physics.forces import (
    ANGULAR_DAMPING,
    INERTIA,
    LINEAR_DAMPING,
    MASS,
    contact_push,
    ligament_pull,
    sin_cos,
)
from kneecore.knee.physics.pose import ACL, LCL, MCL, PCL, START_X, START_Y

TIME_STEP = 0.004
"""s"""
LANES = 16

_SIGN = 32  # row of the moment's direction, behind the 32 rows of constants that the step needs
_N_ROWS = 33

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@inline
def _pull(P, row, j, x, y, s, c):  # type: ignore[no-untyped-def]
    return ligament_pull(
        P[row * LANES + j],
        P[(row + 1) * LANES + j],
        P[(row + 2) * LANES + j],
        P[(row + 3) * LANES + j],
        P[(row + 4) * LANES + j],
        P[(row + 5) * LANES + j],
        x,
        y,
        s,
        c,
    )


@inline
def _push(P, j, x, y, s, c):  # type: ignore[no-untyped-def]
    return contact_push(
        P[24 * LANES + j],
        P[25 * LANES + j],
        P[26 * LANES + j],
        P[28 * LANES + j],
        P[29 * LANES + j],
        P[27 * LANES + j],
        P[30 * LANES + j],
        x,
        y,
        s,
        c,
    )


@written_in
def advance(
    P: FloatArray, S: FloatArray, farthest: FloatArray, n_steps: int, dt: float, moment: float
) -> None:
    """Advance a group of lanes by `n_steps` of `dt` under a constant moment, in place.

    Parameters
    ----------
    P : ndarray, shape (33 * LANES,)
        Constants of each lane and the direction of its moment.
    S : ndarray, shape (6 * LANES,)
        State: x, y, psi and their velocities.
    farthest : ndarray, shape (LANES,)
        Largest |psi| so far.
    """
    per_mass = dt / MASS
    per_inertia = dt / INERTIA
    for _ in range(n_steps):
        for j in range(LANES):
            x, y, psi = S[j], S[LANES + j], S[2 * LANES + j]
            vx, vy, omega = S[3 * LANES + j], S[4 * LANES + j], S[5 * LANES + j]
            s, c = sin_cos(psi)
            fx0, fy0, m0 = _pull(P, ACL, j, x, y, s, c)
            fx1, fy1, m1 = _pull(P, PCL, j, x, y, s, c)
            fx2, fy2, m2 = _pull(P, MCL, j, x, y, s, c)
            fx3, fy3, m3 = _pull(P, LCL, j, x, y, s, c)
            fx4, fy4, m4, _f, _d = _push(P, j, x, y, s, c)
            fx = fx0 + fx1 + fx2 + fx3 + fx4 - LINEAR_DAMPING * vx
            fy = fy0 + fy1 + fy2 + fy3 + fy4 - LINEAR_DAMPING * vy
            m = m0 + m1 + m2 + m3 + m4 - ANGULAR_DAMPING * omega + moment * P[_SIGN * LANES + j]
            vx += per_mass * fx
            vy += per_mass * fy
            omega += per_inertia * m
            psi += dt * omega
            S[j] = x + dt * vx
            S[LANES + j] = y + dt * vy
            S[2 * LANES + j] = psi
            S[3 * LANES + j] = vx
            S[4 * LANES + j] = vy
            S[5 * LANES + j] = omega
            farthest[j] = max(farthest[j], abs(psi))


@kernel
def _run_groups(
    rows: FloatArray,
    runs: IntArray,
    steps: IntArray,
    moments: FloatArray,
    dt: float,
    states: FloatArray,
    farthest: FloatArray,
) -> None:
    """Run `runs` in groups of lanes; a last group that is not full repeats its last run."""
    P = np.empty(_N_ROWS * LANES)
    S = np.empty(6 * LANES)
    far = np.empty(LANES)
    n_runs = runs.shape[0]
    for first in range(0, n_runs, LANES):
        for j in range(LANES):
            run = runs[min(first + j, n_runs - 1)]
            model = run // 2
            for row in range(32):
                P[row * LANES + j] = rows[model, row]
            P[_SIGN * LANES + j] = 1.0 - 2.0 * (run % 2)
            S[j] = rows[model, START_X]
            S[LANES + j] = rows[model, START_Y]
            for row in range(2, 6):
                S[row * LANES + j] = 0.0
            far[j] = 0.0
        for k in range(steps.shape[0]):
            advance(P, S, far, steps[k], dt, moments[k])
            for j in range(min(LANES, n_runs - first)):
                for row in range(6):
                    states[first + j, k, row] = S[row * LANES + j]
        for j in range(min(LANES, n_runs - first)):
            farthest[first + j] = far[j]


def integrate(
    rows: FloatArray,
    runs: IntArray,
    steps: IntArray,
    moments: FloatArray,
    *,
    refinements: int = 0,
    threads: int | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Integrate runs from the load-free pose at rest through segments of constant moment.

    Parameters
    ----------
    rows : ndarray, shape (n_models, 36)
        Constants of each model.
    runs : ndarray of int, shape (n_runs,)
        Run 2 i is model i in extension, run 2 i + 1 in flexion.
    steps : ndarray of int, shape (n_segments,)
        Steps of 4 ms in each segment.
    moments : ndarray, shape (n_segments,)
        Size of the moment in each segment, N m.
    refinements : int
        How often the time step is halved.
    threads : int, optional
        Threads to use; all cores for None. The result does not depend on it.

    Returns
    -------
    states : ndarray, shape (n_runs, n_segments, 6)
        x, y (m), psi (rad) and their velocities after each segment.
    farthest : ndarray, shape (n_runs,)
        Largest |psi| of each run, rad.
    """
    states = np.empty((len(runs), len(steps), 6))
    farthest = np.empty(len(runs))
    factor = 2**refinements
    scaled = np.ascontiguousarray(steps * factor)
    n_groups = -(-len(runs) // LANES)
    # A few chunks a thread even out the load.
    size = LANES * max(1, -(-n_groups // (4 * thread_count(threads))))

    def work(first: int) -> None:
        part = slice(first, min(first + size, len(runs)))
        _run_groups(
            rows, runs[part], scaled, moments, TIME_STEP / factor, states[part], farthest[part]
        )

    run_all(work, range(0, len(runs), size), threads)
    return states, farthest

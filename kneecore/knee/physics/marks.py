"""Two marks beside `settled`: whether an angle is the equilibrium's, and a pose one of a knee.

Whether a knee is at rest is asked of its potential: Newton's method goes downhill from where the
motion has ended. It is a small kernel of its own, for the solver that follows the equilibria from
the load-free pose takes six seconds to compile, which nobody who moves a knee shall wait for.
"""

import math

import numpy as np
from numpy.typing import NDArray

from kneecore._jit import kernel
from kneecore._threads import run_all, thread_count
from kneecore.knee.physics.dynamics import MOMENTS, flexion_of
from kneecore.knee.physics.pose import N_CONSTANTS, RADIUS
from kneecore.knee.physics.potential import all_terms

__all__ = ["at_rest", "compile_marks", "implausible", "nearest_rest"]

AT_REST_ANGLE = math.radians(0.1)
"""By this much an angle at rest may differ from the equilibrium of the same knee and load."""
LEAST_FLEXION, MOST_FLEXION = math.radians(-60.0), math.radians(170.0)
MOST_INDENTATION = 0.5
"""Share of the circle's radius."""

_FLOOR, _FLOOR_TURN = 10.0, 1e-2  # N/m, N m/rad: the smallest pivots
_LONGEST, _LONGEST_TURN = 0.001, 0.02  # m, rad: the longest step
_NEAR, _NEAR_TURN = 1e-7, 1e-6  # m, rad: the last step where the floors have shortened it
_SQUARE, _SQUARE_TURN = 1e-5, 1e-4  # m, rad: Newton's own last step; it leaves about its square
_NOISE = 1e-14  # of the energy: its rounding
_SHORTEST = 1e-4  # share of Newton's step
_FARTHEST = 0.1  # rad: nobody would call that near
_MAX_ITERATIONS = 60

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@kernel
def _descend(rows: FloatArray, moments: FloatArray, poses: FloatArray, turns: FloatArray) -> None:
    """Fill `turns` (n, 12) with psi of the equilibria below poses (n, 12, 3); NaN if none is near.

    `moments` (12,) are signed, extension positive.
    """
    h = np.empty(10)
    for i in range(poses.shape[0]):
        for k in range(poses.shape[1]):
            row, moment = rows[i], moments[k]
            x, y, psi = poses[i, k, 0], poses[i, k, 1], poses[i, k, 2]
            turns[i, k] = np.nan
            all_terms(row, x, y, psi, h)
            for _ in range(_MAX_ITERATIONS):
                d1 = max(h[4], _FLOOR)
                l21, l31 = h[5] / d1, h[7] / d1
                d2 = max(h[6] - l21 * h[5], _FLOOR)
                m32 = h[8] - l31 * h[5]
                d3 = max(h[9] - l31 * h[7] - m32 * m32 / d2, _FLOOR_TURN)
                b2 = l21 * h[1] - h[2]
                turn = (moment - h[3] + l31 * h[1] - m32 / d2 * b2) / d3
                dy = (b2 - m32 * turn) / d2
                dx = -h[1] / d1 - l21 * dy - l31 * turn
                shift = max(abs(dx), abs(dy))
                whole = d1 > _FLOOR and d2 > _FLOOR and d3 > _FLOOR_TURN
                near, near_turn = (_SQUARE, _SQUARE_TURN) if whole else (_NEAR, _NEAR_TURN)
                if shift < near and abs(turn) < near_turn:
                    turns[i, k] = psi + turn
                    break
                far = max(shift / _LONGEST, abs(turn) / _LONGEST_TURN)
                step, energy = 1.0 / max(far, 1.0), h[0] - moment * psi
                all_terms(row, x + step * dx, y + step * dy, psi + step * turn, h)
                while (
                    h[0] - moment * (psi + step * turn) > energy + _NOISE * (1.0 + abs(energy))
                    and step > _SHORTEST
                ):
                    step *= 0.3
                    all_terms(row, x + step * dx, y + step * dy, psi + step * turn, h)
                x, y, psi = x + step * dx, y + step * dy, psi + step * turn
                if abs(psi - poses[i, k, 2]) > _FARTHEST:
                    break


def nearest_rest(rows: FloatArray, poses: FloatArray, threads: int | None = None) -> FloatArray:
    """Return psi (rad) of the equilibria that knees sink into from poses, (n, 12, 3) to (n, 12).

    NaN where none is within some degrees, and of NaN.
    """
    turns = np.empty(poses.shape[:2])
    moments = np.concatenate([np.array(MOMENTS), -np.array(MOMENTS)])
    size = max(16, -(-len(rows) // (4 * thread_count(threads))))

    def work(first: int) -> None:
        part = slice(first, first + size)
        _descend(rows[part], moments, poses[part], turns[part])

    run_all(work, range(0, len(rows), size), threads)
    return turns


def compile_marks() -> None:
    """Compile the kernel of this module."""
    nearest_rest(np.zeros((1, N_CONSTANTS)), np.full((1, 2 * len(MOMENTS), 3), np.nan))


def at_rest(rows: FloatArray, poses: FloatArray, threads: int | None = None) -> BoolArray:
    """Tell which poses (n, 12, 3) are within 0.1 deg of an equilibrium of the same knee, (n, 12).

    False where a knee has none near, and where it failed.
    """
    poses = np.ascontiguousarray(poses)
    near: BoolArray = np.abs(poses[..., 2] - nearest_rest(rows, poses, threads)) <= AT_REST_ANGLE
    return near


def implausible(rows: FloatArray, poses: FloatArray, indentation: FloatArray) -> BoolArray:
    """Tell which poses (n, 12, 3) no knee takes, (n, 12); false of a failed model's."""
    theta = flexion_of(poses)
    deep = indentation > MOST_INDENTATION * rows[:, RADIUS, None]
    outside: BoolArray = (theta < LEAST_FLEXION) | (theta > MOST_FLEXION) | deep
    return outside

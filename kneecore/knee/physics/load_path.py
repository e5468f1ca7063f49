"""The load path of one knee in small turns: slow, and the judge where a fast walk is in doubt.

At a given turn psi the potential is convex in the translation: the length of a ligament is a convex
function of where the tibia is, its energy a convex and rising function of that length, and the
indentation is linear. So the tibia's place follows from psi, one function M(psi) of one variable is
left, the moment that holds the knee at psi, and branches of equilibria are nothing but intervals on
which M rises with the turn. An equilibrium is *lost* where M turns back before it has reached the
load: the knee then snaps to another branch, or finds no hold at all.
"""

import math

import numpy as np
from numpy.typing import NDArray

from kneecore._jit import inner, kernel
from kneecore.knee.physics.dynamics import TURN_LIMIT
from kneecore.knee.physics.pose import ORIGIN_X, ORIGIN_Y
from kneecore.knee.physics.potential import all_terms

TURN_STEP = math.radians(0.25)
_FLOOR = 1e-2  # N/m: the smallest pivot of the translation
_LONGEST = 0.002  # m: the longest step of the translation
_SHORTEST = 1e-6  # share of Newton's step
_BALANCE, _NEARLY = 1e-9, 1e-5  # N: the force that is left, and that may be left
_NOISE = 1e-14  # of the energy: its rounding
_NEAR_TURN = 1e-9  # rad: Newton's last step; it leaves an error of its square
_DIP = 1e-8  # N m: rounding of the moment that holds the knee
_MAX_ITERATIONS = 80

FloatArray = NDArray[np.float64]


@inner
def _hold(row: FloatArray, psi: float, place: FloatArray, h: FloatArray) -> bool:
    """Relax the translation at a held turn; return whether the forces are in balance.

    `place` (2,) is where it starts and ends; `h` (10,) gets the terms there.
    """
    x, y = place[0], place[1]
    all_terms(row, x, y, psi, h)
    for _ in range(_MAX_ITERATIONS):
        if max(abs(h[1]), abs(h[2])) < _BALANCE:
            break
        d1 = max(h[4], _FLOOR)
        ratio = h[5] / d1
        d2 = max(h[6] - ratio * h[5], _FLOOR)
        dy = (ratio * h[1] - h[2]) / d2
        dx = -h[1] / d1 - ratio * dy
        size = max(abs(dx), abs(dy))
        cap = min(1.0, _LONGEST / size) if size > 0.0 else 1.0
        energy = h[0]
        all_terms(row, x + cap * dx, y + cap * dy, psi, h)
        while h[0] > energy + _NOISE * (1.0 + energy) and cap > _SHORTEST:
            cap *= 0.3
            all_terms(row, x + cap * dx, y + cap * dy, psi, h)
        x += cap * dx
        y += cap * dy
    place[0], place[1] = x, y
    return bool(max(abs(h[1]), abs(h[2])) < _NEARLY)


@inner
def _rate(h: FloatArray) -> float:
    """Return dM / dpsi along the relaxed places: the Schur complement of the translation."""
    d1 = max(h[4], _FLOOR)
    ratio = h[5] / d1
    d2 = max(h[6] - ratio * h[5], _FLOOR)
    rest = h[8] - h[7] * ratio
    return float(h[9] - h[7] * h[7] / d1 - rest * rest / d2)


@inner
def _meet(
    row: FloatArray, moment: float, short: float, far: float, place: FloatArray, h: FloatArray
) -> float:
    """Return the turn between `short` and `far` at which the moment is `moment`; NaN if none."""
    side = 1.0 if far > short else -1.0
    psi = far
    for _ in range(_MAX_ITERATIONS):
        if not _hold(row, psi, place, h):
            return np.nan
        missing = moment - h[3]
        if side * missing > 0.0:
            short = psi
        else:
            far = psi
        step = missing / _rate(h)
        if abs(step) < _NEAR_TURN or abs(far - short) < _NEAR_TURN:
            return psi + step if _hold(row, psi + step, place, h) else np.nan
        psi += step
        if not (min(short, far) < psi < max(short, far)):
            psi = 0.5 * (short + far)
    return np.nan


@kernel
def rises(row: FloatArray, sign: float, start: FloatArray, end: FloatArray) -> bool:
    """Tell whether M rises all the way from one equilibrium to the next.

    `start` and `end` (3,) are the tibia's origin and psi at two loads, NaN where there is none.
    """
    turn = sign * (end[2] - start[2])
    if not turn > 0.0:
        return False
    place, h = start[:2].copy(), np.empty(10)
    n_steps = int(turn / (2.0 * TURN_STEP)) + 4
    held, rate = -np.inf, 0.0
    for i in range(n_steps + 1):
        if not _hold(row, start[2] + sign * turn * i / n_steps, place, h):
            return False
        risen, now = sign * h[3] - held, _rate(h)
        # Between two ends from which M rises much faster than on average there may be a dip: a
        # cubic rises all the way if neither end is steeper than three times the average
        # (Fritsch & Carlson 1980, SIAM J Numer Anal 17:238).
        if not (risen > 0.0 and now > 0.0 and max(rate, now) * turn <= 3.0 * risen * n_steps):
            return False
        held, rate = sign * h[3], now
    return True


@kernel
def trace(row: FloatArray, sign: float, moments: FloatArray, first: int, poses: FloatArray) -> int:
    """Trace the load path of one model in one direction.

    Parameters
    ----------
    row : ndarray, shape (36,)
        Constants about the tibia's origin.
    sign : float
        Direction of the moment, +1 for extension.
    moments : ndarray, shape (n_loads,)
        Sizes of the moment, rising, N m.
    first : int
        Load to begin with: from the equilibrium at the load before it, or the load-free pose for 0.
    poses : ndarray, shape (n_loads, 3)
        Gets the tibia's origin (m) and psi (rad) in each equilibrium.

    Returns
    -------
    int
        Place of the load at which the equilibrium was lost; -1 if it never was.
    """
    place, h = np.array([row[ORIGIN_X], row[ORIGIN_Y]]), np.empty(10)
    psi = 0.0
    if first > 0:
        place[0], place[1], psi = poses[first - 1, 0], poses[first - 1, 1], poses[first - 1, 2]
    if not _hold(row, psi, place, h):
        return first
    held = h[3]
    # A knee with the baseline's rest lengths begins out of equilibrium and may have to turn back.
    side = sign if first > 0 or sign * (sign * moments[0] - held) > 0.0 else -sign
    for k in range(first, moments.shape[0]):
        moment = sign * moments[k]
        while side * (moment - held) > 0.0:
            following = psi + side * TURN_STEP
            if not (abs(psi) < TURN_LIMIT and _hold(row, following, place, h)):
                return k
            # Before the first load there is no equilibrium that could be lost.
            if k > 0 and side * (h[3] - held) < -_DIP:
                return k
            if side * (moment - h[3]) <= 0.0:
                break
            psi, held = following, h[3]
        meeting = _meet(row, moment, psi, psi + side * TURN_STEP, place, h)
        if not (abs(meeting) < TURN_LIMIT and _rate(h) > 0.0):
            return k
        psi, held = meeting, moment
        poses[k, 0], poses[k, 1], poses[k, 2] = place[0], place[1], psi
        side = sign
    return -1

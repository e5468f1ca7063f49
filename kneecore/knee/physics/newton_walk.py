"""A safeguarded Newton walk along the loads to the equilibria, many runs abreast in lanes.

A *run* is one model in one direction of the moment; it starts in the load-free pose and goes
through the six loads, each from the equilibrium of the last. Within a load the potential less the
moment's work (`physics.potential`) falls with every step that is kept: the Hessian is
factorised as L D L^T with pivots that are too small (slack ligaments, a contact that just touches)
or negative lifted to a floor, the step is capped, and taken back part of the way where the energy
rose. The first trial of a load is a leap, extrapolated from the path so far; one that raises the
energy is dropped. An equilibrium is what passes three tests at once: the energy has not risen, no
pivot was lifted, and the Newton step is below `_NEAR`.

Thirty-two runs advance together, one in each lane of flat arrays ``A[row * LANES + lane]``, as in
`physics.dynamics`. Each lane is at its own load, and a lane whose run has ended takes up the
next run: nobody waits, and nobody looks at a neighbour, so no result depends on who they are.

The walk says at which loads it is in doubt about its path; `physics.equilibrium` has the
path looked at more closely there.
"""

import math

import numpy as np
from numpy.typing import NDArray

from kneecore._jit import inline, inner, kernel
from kneecore.knee.physics.dynamics import TURN_LIMIT
from kneecore.knee.physics.forces import sin_cos
from kneecore.knee.physics.pose import ACL, LCL, MCL, ORIGIN_X, ORIGIN_Y, PCL
from kneecore.knee.physics.potential import contact_terms, ligament_terms

LANES = 32
_STEP_LENGTH, _STEP_TURN = 0.004, 0.15  # m, rad: the longest step
_FLOOR, _FLOOR_TURN = 10.0, 1e-2  # N/m, N m/rad: the smallest pivots
_NEAR, _NEAR_TURN = 1e-8, 3e-7  # m, rad: Newton's last step; it leaves an error of its square
_NOISE = 1e-14  # of the energy: its rounding
_MAX_ITERATIONS = 60
# The path between two loads is in doubt if Newton's method took more iterations than this, if the
# leap missed by more than this share of the turn between them, or if the turn is more than this
# many times what its pace at the end (per logarithm of the moment) would give: a knee that has
# snapped to another branch is stiffer there. Of 31,500 random knees within two to ten times the
# usual bounds a trace shows 2,942 to be lost, and all of them were in doubt, at the same load;
# within the usual bounds no knee of 10,000 was in doubt, and none lost.
_SURE_ITERATIONS, _SURE_MISS, _SURE_PACE = 12, 0.25, 1.1
# The way to the first load is in doubt if it is longer than this, rad: then Newton's method may
# have passed a nearer equilibrium (strained knees with the baseline's rest lengths).
_SURE_FIRST_TURN = 0.5


# Rows of a lane's state: pose, step to the next trial pose, energy and slope along the step, the
# moment, whether the trial is a leap, the pose's change per moment, and what the trial has shown.
_X, _DX, _V, _SLOPE, _MOMENT, _LEAP, _TANGENT, _SEEN = 0, 3, 6, 7, 8, 9, 10, 13
_N_STATE = 14
_REFUSED, _LIFTED, _FIRM, _FOUND = -1.0, 0.0, 1.0, 2.0  # values of _SEEN

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


@inline
def _ligament(P, row, j, x, y, s, c):  # type: ignore[no-untyped-def]
    return ligament_terms(
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
def _contact(P, j, x, y, s, c):  # type: ignore[no-untyped-def]
    return contact_terms(
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


@inline
def _newton(gx, gy, gp, hxx, hxy, hyy, hxp, hyp, hpp):  # type: ignore[no-untyped-def]
    """Return Newton's step, the solution for a unit moment, and whether no pivot was lifted."""
    d1 = max(hxx, _FLOOR)
    l21 = hxy / d1
    r2 = hyy - l21 * hxy
    d2 = max(r2, _FLOOR)
    l31 = hxp / d1
    m32 = hyp - l31 * hxy
    l32 = m32 / d2
    r3 = hpp - l31 * hxp - l32 * m32
    d3 = max(abs(r3), _FLOOR_TURN)
    firm = (hxx >= _FLOOR) & (r2 >= _FLOOR) & (r3 >= _FLOOR_TURN)
    z2 = l21 * gx - gy
    z3 = l31 * gx - l32 * z2 - gp
    tp = 1.0 / d3
    ty = -l32 * tp
    tx = -l21 * ty - l31 * tp
    dp = z3 * tp
    dy = z2 / d2 - l32 * dp
    dx = -gx / d1 - l21 * dy - l31 * dp
    return dx, dy, dp, tx, ty, tp, firm


@inner
def _iterate(P: FloatArray, W: FloatArray) -> None:
    """Judge each lane's trial pose and make its next one.

    Parameters
    ----------
    P : ndarray, shape (32 * LANES,)
        Constants of each lane.
    W : ndarray, shape (14 * LANES,)
        State of each lane.
    """
    for j in range(LANES):
        x0, y0, psi0 = W[_X * LANES + j], W[(_X + 1) * LANES + j], W[(_X + 2) * LANES + j]
        dx, dy, dp = W[_DX * LANES + j], W[(_DX + 1) * LANES + j], W[(_DX + 2) * LANES + j]
        v0, slope = W[_V * LANES + j], W[_SLOPE * LANES + j]
        moment, leap = W[_MOMENT * LANES + j], W[_LEAP * LANES + j]
        x, y, psi = x0 + dx, y0 + dy, psi0 + dp
        s, c = sin_cos(psi)
        va, xa, ya, pa, xxa, xya, yya, xpa, ypa, ppa = _ligament(P, ACL, j, x, y, s, c)
        vb, xb, yb, pb, xxb, xyb, yyb, xpb, ypb, ppb = _ligament(P, PCL, j, x, y, s, c)
        vc, xc, yc, pc, xxc, xyc, yyc, xpc, ypc, ppc = _ligament(P, MCL, j, x, y, s, c)
        vd, xd, yd, pd, xxd, xyd, yyd, xpd, ypd, ppd = _ligament(P, LCL, j, x, y, s, c)
        ve, xe, ye, pe, xxe, xye, yye, xpe, ype, ppe = _contact(P, j, x, y, s, c)
        v = va + vb + vc + vd + ve - moment * psi
        gx = xa + xb + xc + xd + xe
        gy = ya + yb + yc + yd + ye
        gp = pa + pb + pc + pd + pe - moment
        nx, ny, np_, tx, ty, tp, firm = _newton(
            gx,
            gy,
            gp,
            xxa + xxb + xxc + xxd + xxe,
            xya + xyb + xyc + xyd + xye,
            yya + yyb + yyc + yyd + yye,
            xpa + xpb + xpc + xpd + xpe,
            ypa + ypb + ypc + ypd + ype,
            ppa + ppb + ppc + ppd + ppe,
        )
        near = (abs(nx) < _NEAR) & (abs(ny) < _NEAR) & (abs(np_) < _NEAR_TURN)
        size = max(max(abs(nx), abs(ny)) * (1.0 / _STEP_LENGTH), abs(np_) * (1.0 / _STEP_TURN))
        cap = 1.0 / max(size, 1.0)
        nx *= cap
        ny *= cap
        np_ *= cap
        accepted = v <= v0 + _NOISE * (1.0 + abs(v0))
        # A refused step is cut to the minimum of the parabola through both energies and the slope;
        # a refused leap is dropped, and the pose before it looked at again.
        cut = min(max(-0.5 * slope / (v - v0 - slope), 0.1), 0.5)
        cut = 0.0 if leap > 0.0 else cut
        kept = np.inf if leap > 0.0 else v0
        seen = _FIRM if firm else _LIFTED
        seen = _FOUND if firm & near else seen
        W[_X * LANES + j] = x if accepted else x0
        W[(_X + 1) * LANES + j] = y if accepted else y0
        W[(_X + 2) * LANES + j] = psi if accepted else psi0
        W[_DX * LANES + j] = nx if accepted else cut * dx
        W[(_DX + 1) * LANES + j] = ny if accepted else cut * dy
        W[(_DX + 2) * LANES + j] = np_ if accepted else cut * dp
        W[_V * LANES + j] = v if accepted else kept
        W[_SLOPE * LANES + j] = gx * nx + gy * ny + gp * np_ if accepted else cut * slope
        W[_LEAP * LANES + j] = 0.0
        W[_TANGENT * LANES + j] = tx
        W[(_TANGENT + 1) * LANES + j] = ty
        W[(_TANGENT + 2) * LANES + j] = tp
        W[_SEEN * LANES + j] = seen if accepted else _REFUSED


@inner
def _begin(row: FloatArray, moment: float, P: FloatArray, W: FloatArray, j: int) -> None:
    """Put a run into lane `j`: its constants, and the load-free pose."""
    for i in range(32):
        P[i * LANES + j] = row[i]
    for i in range(_N_STATE):
        W[i * LANES + j] = 0.0
    W[_X * LANES + j] = row[ORIGIN_X]
    W[(_X + 1) * LANES + j] = row[ORIGIN_Y]
    W[_V * LANES + j] = np.inf
    W[_MOMENT * LANES + j] = moment


@inner
def _next_load(
    W: FloatArray, j: int, k: int, sign: float, moments: FloatArray, path: FloatArray
) -> float:
    """Load lane `j`, in equilibrium at load `k`, with the next moment; return psi after the leap.

    The leap is a parabola in the logarithm of the moment, through the last two equilibria (`path`)
    with the tangent at the last; behind the first load, a square root of the moment.
    """
    old, new = sign * moments[k], sign * moments[k + 1]
    # Under the new moment the pose's energy is less by the work of the difference.
    W[_V * LANES + j] -= (new - old) * W[(_X + 2) * LANES + j]
    W[_MOMENT * LANES + j] = new
    W[_LEAP * LANES + j] = 1.0
    ratio = moments[k + 1] / moments[k]
    for i in range(3):
        tangent = old * W[(_TANGENT + i) * LANES + j]
        if k == 0:
            ahead = 2.0 * (math.sqrt(ratio) - 1.0) * tangent
        else:
            back = math.log(moments[k] / moments[k - 1])
            ahead = math.log(ratio)
            bend = (path[k - 1, i] - path[k, i] + back * tangent) / (back * back)
            ahead = ahead * (tangent + bend * ahead)
        W[(_DX + i) * LANES + j] += ahead
    return float(W[(_X + 2) * LANES + j] + W[(_DX + 2) * LANES + j])


@kernel
def walk(
    rows: FloatArray, runs: IntArray, moments: FloatArray, poses: FloatArray, doubt: BoolArray
) -> None:
    """Walk runs through the loads.

    Parameters
    ----------
    rows : ndarray, shape (n_models, 36)
        Constants about the tibia's origin (`physics.potential.about_origin`).
    runs : ndarray of int, shape (n_runs,)
        Run 2 i is model i in extension, run 2 i + 1 in flexion.
    moments : ndarray, shape (n_loads,)
        Sizes of the moment, rising, N m.
    poses : ndarray, shape (n_runs, n_loads, 3)
        Gets the origin (m) and psi (rad) in each equilibrium; NaN from where it was not found.
    doubt : ndarray of bool, shape (n_runs, n_loads)
        Gets whether the walk is in doubt about its path to each equilibrium.
    """
    n_loads = moments.shape[0]
    P = np.zeros(32 * LANES)
    W = np.zeros(_N_STATE * LANES)
    run_in = np.full(LANES, -1)
    load = np.zeros(LANES, dtype=np.int64)
    count = np.zeros(LANES, dtype=np.int64)
    leap_to = np.zeros(LANES)
    taken, n_busy = 0, LANES
    while n_busy > 0:
        n_busy = 0
        for j in range(LANES):
            r = run_in[j]
            if r >= 0:
                k = load[j]
                sign = 1.0 - 2.0 * (runs[r] % 2)
                count[j] += 1
                inside = abs(W[(_X + 2) * LANES + j]) < TURN_LIMIT
                going = inside and count[j] < _MAX_ITERATIONS
                if inside and W[_SEEN * LANES + j] == _FOUND:
                    for i in range(3):
                        poses[r, k, i] = W[(_X + i) * LANES + j] + W[(_DX + i) * LANES + j]
                    doubt[r, k] = abs(poses[r, k, 2]) > _SURE_FIRST_TURN
                    if k > 0:
                        turn = sign * (poses[r, k, 2] - poses[r, k - 1, 2])
                        rise = moments[k] * math.log(moments[k] / moments[k - 1])
                        doubt[r, k] = (
                            count[j] > _SURE_ITERATIONS
                            or abs(poses[r, k, 2] - leap_to[j]) > _SURE_MISS * turn
                            or turn > _SURE_PACE * rise * W[(_TANGENT + 2) * LANES + j]
                        )
                    going = k + 1 < n_loads
                    if going:
                        leap_to[j] = _next_load(W, j, k, sign, moments, poses[r])
                        load[j], count[j] = k + 1, 0
                elif not going:
                    for i in range(k, n_loads):
                        doubt[r, i] = True
                        poses[r, i, 0] = poses[r, i, 1] = poses[r, i, 2] = np.nan
                if not going:
                    run_in[j] = -1
            if run_in[j] < 0 and taken < runs.shape[0]:
                sign = 1.0 - 2.0 * (runs[taken] % 2)
                _begin(rows[runs[taken] // 2], sign * moments[0], P, W, j)
                run_in[j], load[j], count[j] = taken, 0, 0
                taken += 1
            if run_in[j] >= 0:
                n_busy += 1
        if n_busy > 0:
            _iterate(P, W)

"""Runs that look at the model itself when its worst pair is found: its noise, and its jumps."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

__all__ = ["MOST", "Checks", "looked_at"]

FloatArray = NDArray[np.float64]
Run = Callable[[FloatArray], FloatArray]

_BESIDE = 1e-7  # of the cube's width: as good as the same point, but no run that was kept
_HALVINGS = 7  # of the way between two runs
_LARGE = 0.1  # of f: a smaller step is none
_STAYS = 0.3  # of a step that is a jump, after the halvings
MOST = 2 + _HALVINGS
"""Runs that the checks take at most."""


@dataclass(frozen=True, kw_only=True)
class Checks:
    """What became of the pair's second run, and of the way across the steepest step."""

    n_models: int = 0
    n_failed: int = 0
    noise: float = 0.0
    """By how much the pair's outputs were others the second time, of f."""
    jump: float = 0.0
    """A step of the signed sum, of f, that stays however near its two sides are; 0 if there is
    none, or nobody has looked."""
    width: float = 0.0
    """How near its two sides came, of the cube's width."""


def looked_at(
    run: Run,
    points: FloatArray,
    values: FloatArray,
    places: list[int],
    signs: FloatArray,
    *,
    rough: bool,
) -> Checks:
    """Run the pair again, and where the model is `rough` look for a jump.

    Parameters
    ----------
    run : callable
        Points (n, d) to outputs (n, m).
    points, values : ndarray, shapes (n, d) and (n, m)
        All runs.
    places : list of int
        The pair among them.
    signs : ndarray, shape (m,)
        Weighted signs of the pair's outputs.
    """
    u, y = points[places], values[places]
    f = abs(float((y[0] - y[1]) @ signs))
    again = run(np.where(u < 0.5, u + _BESIDE, u - _BESIDE))
    failed = int(np.count_nonzero(~np.isfinite(again).all(axis=1)))
    noise = float((np.abs(again - y) @ np.abs(signs)).max()) / f if not failed else np.inf
    checks = Checks(n_models=len(u), n_failed=failed, noise=noise)
    return _across(run, points, values @ signs, signs, f, checks) if rough else checks


def _across(
    run: Run, points: FloatArray, sums: FloatArray, signs: FloatArray, f: float, checks: Checks
) -> Checks:
    """Halve the way between the two runs with the steepest large step, again and again."""
    steepest = _steepest(points, sums, _LARGE * f)
    if steepest is None:
        return checks
    ends, reached = points[list(steepest)], sums[list(steepest)]
    first = abs(float(reached[1] - reached[0]))
    n = 0
    for n in range(1, _HALVINGS + 1):
        middle = ends.mean(axis=0)
        there = float(run(middle[None])[0] @ signs)
        if not np.isfinite(there):
            return replace(checks, n_models=checks.n_models + n, n_failed=checks.n_failed + 1)
        moved = int(abs(there - reached[0]) > abs(there - reached[1]))
        ends[moved], reached[moved] = middle, there
    last = abs(float(reached[1] - reached[0]))
    is_jump = last > _STAYS * first
    return replace(
        checks,
        n_models=checks.n_models + n,
        jump=last / f if is_jump else 0.0,
        width=float(np.abs(ends[1] - ends[0]).max()),
    )


def _steepest(points: FloatArray, sums: FloatArray, least: float) -> tuple[int, int] | None:
    """Return the runs between which the sum changes by at least that much, over the least way."""
    best, slope = None, 0.0
    for k in range(1, len(points)):
        steps = np.abs(sums[:k] - sums[k])
        ways = np.sqrt(((points[:k] - points[k]) ** 2).sum(axis=1))
        slopes = np.where(steps >= least, steps / np.maximum(ways, 1e-12), 0.0)
        j = int(np.argmax(slopes))
        if slopes[j] > slope:
            best, slope = (j, k), float(slopes[j])
    return best

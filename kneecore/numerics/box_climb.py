"""Local maxima of smooth functions over the unit cube, many climbs abreast.

The functions that a worst case is made of are nearly monotone in most of their inputs, so that most
of a maximum's coordinates lie on a bound. A climb therefore walks all coordinates at once by the
sign of the gradient, by a share of the cube's width that doubles with success and is halved where
the value did not rise. A coordinate whose derivative changed its sign over a step has its maximum
inside and goes to where the secant of the derivative vanishes. That gets a climb to its bounds in a
few steps, and close to the maximum in the others; `polish` ends it by Newton's method in those few.
Climbs never look at each other.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Climbs", "Slopes", "climb", "polish"]

FloatArray = NDArray[np.float64]
Slopes = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray, FloatArray]]
"""Maps points u (n, d) and weights w (n, m) to sum w y (n,), minus infinity for a failure, its
gradients (n, d), and the outputs y (n, m)."""

_SHORTEST = 1e-3  # of the cube's width: a shorter step ends a climb
_GAIN = 1e-7  # of the value: a smaller gain is none
_NOISE = 1e-12  # of the value: its rounding
_PROBE = 1e-5  # of the cube's width: the difference behind the Hessian
_NEAR = 1e-9  # of the cube's width: Newton's last step


@dataclass(kw_only=True, eq=False)
class Climbs:
    """Where n climbs have ended."""

    u: FloatArray
    """Shape (n, d)."""
    values: FloatArray
    """Shape (n,); minus infinity where a climb began at a failure."""
    gradients: FloatArray
    """Shape (n, d)."""
    outputs: FloatArray
    """Shape (n, m)."""
    n_evaluations: int


def _next_steps(u: FloatArray, g: FloatArray, secant: FloatArray, reach: FloatArray) -> FloatArray:
    """Return each coordinate's step; `secant` (n, d) is the step to a zero of g, NaN if unknown."""
    steps = np.where(np.isnan(secant), np.sign(g) * reach[:, None], secant)
    return np.clip(u + steps, 0.0, 1.0) - u


def _zeros(g: FloatArray, ahead: FloatArray, steps: FloatArray) -> FloatArray:
    """Return the part of `steps` at whose end the secant through g and `ahead` vanishes, or NaN."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        return np.where((g * ahead < 0.0) & (steps != 0.0), steps * g / (g - ahead), np.nan)


def climb(
    slopes: Slopes,
    u: FloatArray,
    weights: FloatArray,
    *,
    first_reach: float = 0.25,
    max_steps: int = 20,
) -> Climbs:
    """Climb from each of `u` to a local maximum of its own weighted sum of outputs.

    Parameters
    ----------
    slopes : callable
        The outputs' weighted sums with their gradients.
    u : ndarray, shape (n, d)
        Where to begin, in the unit cube.
    weights : ndarray, shape (n, m)
        Weights of the outputs, for each climb its own.
    first_reach : float
        Length of the first step, of the cube's width.
    max_steps : int
        Steps after which a climb ends wherever it is.
    """
    u = u.copy()
    values, g, y = slopes(u, weights)
    n_evaluations = len(u)
    reach = np.full(len(u), first_reach)
    secant = np.full(u.shape, np.nan)
    for _ in range(max_steps):
        steps = _next_steps(u, g, secant, reach)
        going = np.flatnonzero(np.isfinite(values) & (np.abs(steps).max(axis=1) > _SHORTEST))
        if len(going) == 0:
            break
        steps = steps[going]
        trial = u[going] + steps
        new_values, new_g, new_y = slopes(trial, weights[going])
        n_evaluations += len(going)
        zeros = _zeros(g[going], new_g, steps)
        gain = new_values - values[going]
        risen = gain > 0.0
        # A refused step has shown the zeros ahead; a kept one has passed them.
        secant[going] = np.where(risen[:, None], zeros - steps, zeros)
        kept = going[risen]
        u[kept], values[kept] = trial[risen], new_values[risen]
        g[kept], y[kept] = new_g[risen], new_y[risen]
        reach[kept] = np.minimum(2.0 * reach[kept], 1.0)
        reach[going[~risen]] *= 0.5
        reach[going[risen & (gain < _GAIN * np.abs(values[going]))]] = 0.0
    return Climbs(u=u, values=values, gradients=g, outputs=y, n_evaluations=n_evaluations)


def polish(slopes: Slopes, u: FloatArray, weights: FloatArray, *, max_steps: int = 8) -> Climbs:
    """End one climb by Newton's method in the coordinates that are not held by a bound.

    Parameters
    ----------
    slopes, u, weights
        As for `climb`, of one point: shapes (d,) and (m,).
    max_steps : int
        Steps after which to stop wherever it is.
    """
    u = u.copy()
    values, g, y = slopes(u[None], weights[None])
    n_evaluations = 1
    if (g == 0.0).any():  # inputs without effect go to the middle, if that has none either
        middle = np.where(g[0] == 0.0, 0.5, u)
        new_values, new_g, new_y = slopes(middle[None], weights[None])
        n_evaluations += 1
        if new_values[0] >= values[0] - _NOISE * abs(values[0]):
            u, values, g, y = middle, new_values, new_g, new_y
    for _ in range(max_steps):
        held = (g[0] == 0.0) | ((u <= 0.0) & (g[0] < 0.0)) | ((u >= 1.0) & (g[0] > 0.0))
        free = np.flatnonzero(~held)
        if len(free) == 0:
            break
        probes = np.repeat(u[None], len(free), axis=0)
        shifts = np.where(u[free] < 0.5, _PROBE, -_PROBE)
        probes[np.arange(len(free)), free] += shifts
        probed = slopes(probes, np.repeat(weights[None], len(free), axis=0))[1]
        hessian = (probed[:, free] - g[:, free]) / shifts[:, None]
        n_evaluations += len(free)
        step = _newton_step(hessian, g[0, free])
        trial = u.copy()
        trial[free] = np.clip(u[free] + step, 0.0, 1.0)
        new_values, new_g, new_y = slopes(trial[None], weights[None])
        n_evaluations += 1
        moved = float(np.abs(trial - u).max())
        if new_values[0] >= values[0]:
            u, values, g, y = trial, new_values, new_g, new_y
        if moved < _NEAR or not new_values[0] >= values[0]:
            break
    return Climbs(u=u[None], values=values, gradients=g, outputs=y, n_evaluations=n_evaluations)


def _newton_step(hessian: FloatArray, g: FloatArray) -> FloatArray:
    """Return Newton's step uphill; directions that do not bend down go a tenth of the cube."""
    bends, axes = np.linalg.eigh(0.5 * (hessian + hessian.T))
    along = (axes * g[:, None]).sum(axis=0)
    down = np.minimum(bends, -1e-12)
    lengths = np.where(bends < -1e-12, -along / down, np.sign(along) * 0.1)
    step: FloatArray = (axes * np.clip(lengths, -0.25, 0.25)).sum(axis=1)
    return step

"""From responses to the arrays that the charts draw. Pure functions; degrees, N and mm outside.

The moment-angle chart has the moment on its first (vertical) scale, because all knees share the
moments and each has angles of its own: one short array of moments serves every curve. The other
charts stand on the angle; there every curve is cut at the union of all curves' angles, which
leaves straight lines between loads straight.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kneecore import MOMENT
from kneecore.knee.physics.forces import THETA_0
from kneeviz.geometry.sweep import Sweep

FloatArray = NDArray[np.float64]

MOMENT_LIMIT = 5.6
"""N m; the chart's upper and lower edge."""
ANGLE_RANGE = (-30.0, 135.0)
"""deg; the charts' least range."""


def with_load_free(flexion: FloatArray, *, strain_free: bool) -> tuple[FloatArray, FloatArray]:
    """Return (moments rising, angles in deg) of 12 angles in rad, shape (..., 12).

    The load-free angle joins them where it is an equilibrium, at 0 N m.
    """
    order = [11, 10, 9, 8, 7, 6, 0, 1, 2, 3, 4, 5]
    moments = MOMENT[order]
    angles = np.degrees(np.asarray(flexion)[..., order])
    if strain_free:
        moments = np.insert(moments, 6, 0.0)
        angles = np.insert(angles, 6, np.degrees(THETA_0), axis=-1)
    return moments, angles


def moment_axis(moments: FloatArray, marked: Sequence[float] = ()) -> FloatArray:
    """Return the chart's moments, rising: the loads, its two edges and the marked moments."""
    edges = np.array([-MOMENT_LIMIT, MOMENT_LIMIT])
    within = np.clip(np.asarray(marked, dtype=np.float64), edges[0], edges[1])
    return np.unique(np.concatenate([moments, edges, within]))


def angles_at(axis: FloatArray, moments: FloatArray, angles: FloatArray) -> FloatArray:
    """Return one or many curves, angles of shape (..., k), at the moments `axis`.

    NaN beyond the loads.
    """
    position = np.clip(np.searchsorted(moments, axis, side="right") - 1, 0, len(moments) - 2)
    part = (axis - moments[position]) / (moments[position + 1] - moments[position])
    curve = (1.0 - part) * angles[..., position] + part * angles[..., position + 1]
    beyond = (axis < moments[0]) | (axis > moments[-1])
    return np.where(beyond, np.nan, curve)


def mark(axis: FloatArray, at: float, value: float) -> FloatArray:
    """Return a series that is `value` where `axis` is closest to `at`, and NaN elsewhere."""
    series = np.full(len(axis), np.nan)
    series[int(np.argmin(np.abs(axis - at)))] = value
    return series


def nothing(axis: FloatArray) -> FloatArray:
    """Return a series that draws nothing."""
    return np.full(len(axis), np.nan)


def angle_range(curves: Sequence[FloatArray], step: float = 15.0) -> tuple[float, float]:
    """Return a calm range, in deg, that holds all curves: whole steps, at least `ANGLE_RANGE`."""
    shown = [c[np.isfinite(c)] for c in curves]
    values = np.concatenate([*shown, np.array(ANGLE_RANGE)])
    low = step * np.floor(values.min() / step)
    high = step * np.ceil(values.max() / step)
    return float(low), float(high)


def value_limit(values: FloatArray, step: float) -> float:
    """Return the next whole `step` that is at least the largest of `values`, and one step."""
    finite = values[np.isfinite(values)]
    top = float(finite.max()) if len(finite) else 0.0
    return float(step * max(np.ceil(top / step), 1.0))


def angle_axis(
    sweeps: Sequence[Sweep | None], marked: Sequence[float], n_points: int
) -> FloatArray:
    """Return the angles (deg), rising, at which all sweeps have their corners.

    Parameters
    ----------
    sweeps : sequence of Sweep or None
    marked : sequence of float
        Further angles, deg.
    n_points : int
        Length to fill up to, so that a chart's arrays keep their length.
    """
    corners = [np.degrees(s.flexion) for s in sweeps if s is not None]
    axis = np.unique(np.concatenate([*corners, np.asarray(marked, dtype=np.float64)]))
    return np.concatenate([axis, np.full(max(n_points - len(axis), 0), axis[-1])])


def over_angle(axis: FloatArray, sweep: Sweep | None, values: FloatArray | None) -> FloatArray:
    """Return a sweep's `values`, shape (k,), at the angles `axis` (deg); NaN outside its range."""
    if sweep is None or values is None:
        return nothing(axis)
    angles = np.degrees(sweep.flexion)
    order = np.argsort(angles, kind="stable")
    return np.interp(axis, angles[order], values[order], left=np.nan, right=np.nan)


def prediction_error(predicted: FloatArray, true: FloatArray) -> tuple[float, float]:
    """Return (root mean square, largest) difference over the 12 loads, deg, of angles in rad."""
    gap = np.degrees(np.asarray(predicted) - np.asarray(true))
    return float(np.sqrt(np.mean(gap**2))), float(np.abs(gap).max())

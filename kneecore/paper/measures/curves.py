"""Measures of the worst-case pairs' curves: loads in order, forces, positions, bounds.

All are told for each of `Experiments.pairs`: the exact optimum first, then seed by seed.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kneecore.knee.response import LARGEST_FLEXION, MOMENT, Response
from kneecore.paper.experiments import Experiments
from kneecore.paper.finding import Finding
from kneecore.paper.measures.knees import ap_slopes, tension_at
from kneecore.search.result import MODELS, SearchResult

__all__ = [
    "ap_difference_percent",
    "ap_slopes_change",
    "extension_reach",
    "flexion_forces_reversed",
    "flexion_mismatch_percent",
    "loads_in_order",
    "ranges_change_percent",
]

FloatArray = NDArray[np.float64]
Knees = tuple[Response, Response, Response]
_NAN = float("nan")


def _for_pairs(done: Experiments, measure: Callable[[Knees], float]) -> FloatArray:
    """Return a measure of baseline, model 1 and model 2 for each pair; NaN where one failed."""

    def of(pair: SearchResult) -> float:
        baseline, one, two = (pair.responses[name] for name in MODELS)
        failed = not all(np.isfinite(r.flexion).all() for r in (baseline, one, two))
        return _NAN if failed else measure((baseline, one, two))

    return np.array([of(pair) for pair in done.pairs])


def loads_in_order(done: Experiments) -> FloatArray:
    """Count the loads at which model 1 has the smaller angle."""
    return _for_pairs(done, lambda k: float(np.count_nonzero(k[1].flexion < k[2].flexion)))


def flexion_forces_reversed(done: Experiments) -> FloatArray:
    """Of two conditions in flexion, those met: model 1 is tighter than the baseline, 2 slacker.

    By the largest tension, at the largest angle that all three knees reach.
    """

    def met(knees: Knees) -> float:
        reach = min(float(np.degrees(knee.flexion[LARGEST_FLEXION])) for knee in knees)
        usual, one, two = (float(tension_at(knee, reach).max()) for knee in knees)
        return float(one > usual) + float(two < usual)

    return _for_pairs(done, met)


def ap_slopes_change(done: Experiments) -> FloatArray:
    """Worst cases whose contact moves back more steeply beyond the load-free angle than before."""

    def steeper(knee: Response) -> bool:
        before, beyond = ap_slopes(knee)
        return beyond < 0.0 and beyond < before

    return _for_pairs(done, lambda k: float(steeper(k[1])) + float(steeper(k[2])))


def _ends(values: FloatArray) -> FloatArray:
    return np.array([values.min(), values.max()])


def ranges_change_percent(done: Experiments) -> FloatArray:
    """By how much the ends of the ranges of angle and position move, % of the baseline's range.

    The end that moves more, and of the two worst cases and two quantities the least.
    """

    def change(knees: Knees) -> float:
        found = []
        for quantity in ("flexion", "ap_position"):
            usual, *worst = (_ends(getattr(knee, quantity)) for knee in knees)
            found += [float(np.abs(ends - usual).max() / np.ptp(usual)) for ends in worst]
        return 100.0 * min(found)

    return _for_pairs(done, change)


def ap_difference_percent(done: Experiments) -> FloatArray:
    """Largest difference in contact position from the baseline at the same angle.

    In % of the baseline's range, over the angles that both knees reach.
    """

    def largest(knees: Knees) -> float:
        curves = [_ap_curve(knee) for knee in knees]
        (angles, positions), *worst = curves
        found = []
        for other_angles, other_positions in worst:
            low, high = max(angles[0], other_angles[0]), min(angles[-1], other_angles[-1])
            both = np.unique(np.concatenate([angles, other_angles]))
            both = both[(both >= low) & (both <= high)]
            difference = np.interp(both, other_angles, other_positions) - np.interp(
                both, angles, positions
            )
            found.append(float(np.abs(difference).max()) if len(both) else _NAN)
        return 100.0 * max(found) / float(np.ptp(positions))

    return _for_pairs(done, largest)


def _ap_curve(knee: Response) -> tuple[FloatArray, FloatArray]:
    """Return angles in rising order, rad, and the contact's positions there, m."""
    order = np.argsort(knee.flexion)
    return knee.flexion[order], knee.ap_position[order]


def _reaches(done: Experiments, knees: Knees, sign: float) -> FloatArray:
    """Return how far models 1 and 2 are from the sampled mean, in bounds' half-widths, shape (2,).

    The mean over the loads of extension (1) or flexion (-1); 1 is on the bound, mean -+ 3 sd.
    """
    loads = sign * MOMENT > 0
    mean, half = done.sampling.y.mean[loads], 3.0 * done.sampling.y.sd[loads]
    _, one, two = (np.degrees(knee.flexion[loads]) for knee in knees)
    return np.array([np.mean((mean - one) / half), np.mean((two - mean) / half)])


def _reach_told(done: Experiments, sign: float) -> str:
    baseline, one, two = (done.exact["both"].responses[name] for name in MODELS)
    reach = _reaches(done, (baseline, one, two), sign)
    side = "extension" if sign > 0 else "flexion"
    return (
        f"In the exact optimum model 1 reaches {reach[0]:.2f} and model 2 {reach[1]:.2f} "
        f"half-widths in {side}."
    )


def flexion_mismatch_percent(done: Experiments) -> Finding:
    """How far the worst cases are from the sampled bounds in flexion, % of their half-width."""
    return Finding(
        values=_for_pairs(
            done, lambda k: 100.0 * float(np.abs(_reaches(done, k, -1.0) - 1.0).max())
        ),
        told=_reach_told(done, -1.0),
    )


def extension_reach(done: Experiments) -> Finding:
    """How far the nearer worst case reaches in extension, in half-widths of the sampled bounds."""
    return Finding(
        values=_for_pairs(done, lambda k: float(_reaches(done, k, 1.0).min())),
        told=_reach_told(done, 1.0),
    )

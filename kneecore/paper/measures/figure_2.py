"""Measures of the paper's Figure 2: what the worst-case pairs move, turn and stiffen.

All are told for each of `Experiments.pairs`: the exact optimum first, then seed by seed.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kneecore.knee.parameters import LIGAMENTS
from kneecore.paper.experiments import Experiments
from kneecore.paper.finding import Finding
from kneecore.paper.geometry_changes import (
    STRUCTURES,
    GeometryChange,
    geometry_changes,
    place_differences_mm,
)

__all__ = [
    "acl_opposite_across",
    "acl_softer",
    "collaterals_turn_more",
    "cruciates_hardly_turn",
    "geometry_only_lcl",
    "lcl_differs",
    "mcl_opposite_along",
    "mcl_stiffer",
    "pcl_softer",
    "plateau_symmetry_percent",
]

FloatArray = NDArray[np.float64]
Change = GeometryChange
_ACL, _PCL, _MCL, _LCL = range(len(LIGAMENTS))
HARDLY_DEG = 1.0
"""A turn that a drawing hardly shows."""
VISIBLE_MM = 0.5
"""A shift that a drawing shows."""
INDIFFERENT_PERCENT = 0.5
"""A change of f below which a parameter's side is left to chance."""


def _worst_cases(
    done: Experiments, holds: Callable[[Change], bool], told: Callable[[Change], str]
) -> Finding:
    """Count, for each pair, the worst cases of which something holds; say why of the exact ones."""
    changes = [geometry_changes(pair) for pair in done.pairs]
    one, two = (told(change) for change in changes[0])
    return Finding(
        values=np.array([float(sum(holds(change) for change in pair)) for pair in changes]),
        told=f"In the exact optimum, model 1: {one}; model 2: {two}.",
    )


def mcl_opposite_along(done: Experiments) -> Finding:
    """Worst cases in which MCL and circle move in opposite directions along the plateau."""
    return _worst_cases(
        done,
        lambda c: bool(c.ligament_along_mm[_MCL] * c.circle_along_mm < 0.0),
        lambda c: f"MCL {c.ligament_along_mm[_MCL]:+.2f}, circle {c.circle_along_mm:+.2f} mm",
    )


def acl_opposite_across(done: Experiments) -> Finding:
    """Worst cases in which ACL and circle move in opposite directions across the plateau."""
    return _worst_cases(
        done,
        lambda c: bool(c.ligament_across_mm[_ACL] * c.circle_across_mm < 0.0),
        lambda c: (
            f"ACL {c.ligament_across_mm[_ACL]:+.2f} mm (femur {c.across_mm[0]:+.2f}, "
            f"tibia {c.across_mm[1]:+.2f}), circle {c.circle_across_mm:+.2f} mm"
        ),
    )


def _turns(change: Change) -> str:
    return (
        ", ".join(
            f"{name.upper()} {turn:+.1f}"
            for name, turn in zip(LIGAMENTS, change.angle_deg, strict=True)
        )
        + " deg"
    )


def cruciates_hardly_turn(done: Experiments) -> Finding:
    """Worst cases in which ACL and PCL both turn by less than 1 deg."""
    return _worst_cases(
        done, lambda c: bool((np.abs(c.angle_deg[[_ACL, _PCL]]) < HARDLY_DEG).all()), _turns
    )


def collaterals_turn_more(done: Experiments) -> Finding:
    """Worst cases in which LCL and MCL both turn further than ACL and PCL do."""

    def more(change: Change) -> bool:
        turn = np.abs(change.angle_deg)
        return bool(turn[[_LCL, _MCL]].min() > turn[[_ACL, _PCL]].max())

    return _worst_cases(done, more, _turns)


def plateau_symmetry_percent(done: Experiments) -> FloatArray:
    """How symmetric the plateau's turns are: 100 % equal and opposite, 0 % to the same side."""
    found = []
    for pair in done.pairs:
        one, two = (change.slope_deg for change in geometry_changes(pair))
        most = abs(one) + abs(two)
        found.append(100.0 * (1.0 - abs(one + two) / most) if most > 0.0 else 0.0)
    return np.array(found)


def _stiffness_sides(done: Experiments) -> FloatArray:
    """Return each stiffness less the baseline's, shape (pairs, 2, 4), per cent."""
    return np.array(
        [[change.stiffness_percent for change in geometry_changes(pair)] for pair in done.pairs]
    )


def _told(turned: FloatArray) -> str:
    """Say what turning round a stiffness does to f in the exact optimum, and in the seeds."""
    one, two = (f"{value:+.2f} %" for value in turned[0])
    sizes = " and ".join(f"{value:.2f}" for value in np.median(np.abs(turned[1:]), axis=0))
    return (
        f"Turned round in the exact optimum, f changes by {one} (model 1) and {two} (model 2); "
        f"in the seeds by {sizes} % to either side (the middle sizes)."
    )


def _hardly(changes: FloatArray) -> bool:
    """Tell whether the exact optimum's changes, and the seeds' middle one, hardly count."""
    exact, seeds = changes[0], changes[1:]
    exact, seeds = exact[~np.isinf(exact)], seeds[~np.isinf(seeds)]
    small = bool((np.abs(exact) < INDIFFERENT_PERCENT).all())
    return small and (not len(seeds) or bool(np.median(np.abs(seeds)) < INDIFFERENT_PERCENT))


def _on_side(done: Experiments, ligament: int, side: float) -> Finding:
    """Count the worst cases with a stiffness on a side of the baseline's: 1 stiffer, -1 softer."""
    right = side * _stiffness_sides(done)[:, :, ligament] > 0.0
    turned = done.turned_percent[:, :, ligament]
    against = np.where(right, np.inf, turned)  # only what speaks against the claim
    return Finding(
        values=right.sum(axis=1).astype(np.float64),
        indifferent=_hardly(against),
        told=_told(turned),
    )


def acl_softer(done: Experiments) -> Finding:
    """Worst cases with a softer ACL."""
    return _on_side(done, _ACL, -1.0)


def pcl_softer(done: Experiments) -> Finding:
    """Worst cases with a softer PCL."""
    return _on_side(done, _PCL, -1.0)


def mcl_stiffer(done: Experiments) -> Finding:
    """Worst cases with a stiffer MCL."""
    return _on_side(done, _MCL, 1.0)


def lcl_differs(done: Experiments) -> Finding:
    """Return 1 for each pair with one stiffer and one softer LCL, 0 for others."""
    sides = _stiffness_sides(done)[:, :, _LCL]
    opposite = sides[:, 0] * sides[:, 1] < 0.0
    turned = done.turned_percent[:, :, _LCL]
    # Turning either of the two would do.
    against = np.where(opposite, np.inf, np.abs(turned).min(axis=1))
    return Finding(
        values=opposite.astype(np.float64),
        indifferent=_hardly(against[:, None]),
        told=_told(turned),
    )


def geometry_only_lcl(done: Experiments) -> Finding:
    """Of two conditions, those met: the LCL's place differs visibly, and no other's does.

    Between the worst cases of the geometry alone and those of all parameters.
    """
    pairs = zip(done.geometry_pairs, done.pairs, strict=True)
    distances = np.array([place_differences_mm(alone, both) for alone, both in pairs])
    lcl = STRUCTURES.index("lcl")
    seen = distances[:, lcl] > VISIBLE_MM
    others = np.delete(distances, lcl, axis=1).max(axis=1) <= VISIBLE_MM
    parts = ", ".join(
        f"{name.upper() if name in LIGAMENTS else name} {distance:.2f}"
        for name, distance in zip(STRUCTURES, distances[0], strict=True)
    )
    return Finding(
        values=seen.astype(np.float64) + others,
        told=f"In the exact optimum the places differ by, mm: {parts}.",
    )

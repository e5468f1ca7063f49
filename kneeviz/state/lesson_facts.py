"""What each step of the lesson shows, in numbers: the right answer, and what its text tells.

The names of numbers end in their unit: `_deg`, `_n` (newton), `_nm` (newton metre). Each function
gets the state as its step leaves it, and returns None while there is nothing to tell yet.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore import LIGAMENTS, MOMENT
from kneeviz.geometry.sweep import Sweep
from kneeviz.state import results
from kneeviz.state.knee import KneeState
from kneeviz.state.presets import preset_knee

FloatArray = NDArray[np.float64]

_GENTLE = 0.8
"""N m; what straightens the knee of the first step."""
_PAIRS = ((0, 1), (1, 2), (0, 3), (2, 3))
"""The ligaments that the third step offers, in its order."""
_STRAIGHT, _UNLOADED = int(np.argmax(MOMENT)), int(np.argmin(np.abs(MOMENT - 0.1)))
"""The loads of +5 N m and +0.1 N m."""


@dataclass(frozen=True, kw_only=True)
class Fact:
    """What was seen."""

    right: float
    """The right answer: a number, or the place of a choice."""
    values: dict[str, float]
    """What the text tells, by name."""


def _tensions(tension: FloatArray, behind: str = "_n") -> dict[str, float]:
    return {name + behind: float(value) for name, value in zip(LIGAMENTS, tension, strict=True)}


def _baseline(state: KneeState) -> Sweep | None:
    return None if state.baseline is None else state.baseline.sweep


def _rest(state: KneeState) -> Fact | None:
    sweep = _baseline(state)
    if sweep is None:
        return None
    tension = sweep.at_moment(_GENTLE).tension
    return Fact(right=int(np.argmax(tension)), values=_tensions(tension))


def _motion(state: KneeState) -> Fact | None:
    sweep = _baseline(state)
    if sweep is None:
        return None
    rest, small, large = (
        float(np.degrees(sweep.at_moment(moment).flexion)) for moment in (0.0, 0.1, 5.0)
    )
    values = {"small_deg": rest - small, "large_deg": rest - large}
    values["ratio"] = values["large_deg"] / values["small_deg"]
    return Fact(right=values["large_deg"], values=values)


def _load(state: KneeState) -> Fact | None:
    sweep = _baseline(state)
    if sweep is None:
        return None
    straight, bent = (sweep.at_moment(moment).tension for moment in (5.0, -5.0))
    sums = [bent[i] + bent[k] for i, k in _PAIRS]
    values = _tensions(bent) | _tensions(straight, "_straight_n")
    return Fact(right=int(np.argmax(sums)), values=values)


def _millimetre(state: KneeState) -> Fact | None:
    moved = state.solve(preset_knee("ACL 1 bound further forward", state.space))
    if state.baseline is None or moved.sweep is None:
        return None
    before, after = (
        float(np.degrees(one.response.flexion[_STRAIGHT])) for one in (state.baseline, moved)
    )
    change = abs(after - before)
    return Fact(
        right=change, values={"before_deg": before, "after_deg": after, "change_deg": change}
    )


def _spread(state: KneeState) -> dict[str, float] | None:
    """Return how far apart the random knees are under +5 N m, from which the surrogate learned."""
    curves = state.training_curves
    if curves is None:
        return None
    angles = np.degrees(curves[:, _STRAIGHT])
    low, high = float(angles.min()), float(angles.max())
    return {
        "knees": len(angles),
        "lowest_deg": low,
        "highest_deg": high,
        "spread_deg": high - low,
    }


def _random(state: KneeState) -> Fact | None:
    spread = _spread(state)
    return None if spread is None else Fact(right=spread["spread_deg"], values=spread)


def _stand_in(state: KneeState) -> Fact | None:
    solved, predicted = state.solve(state.x), state.predict(state.x)
    if solved.sweep is None or predicted is None:
        return None
    gap = np.degrees(predicted - solved.response.flexion)
    rms = float(np.sqrt(np.mean(gap**2)))
    right = int(np.searchsorted((0.1, 3.0), rms))
    return Fact(right=right, values={"rms_deg": rms, "largest_deg": float(np.abs(gap).max())})


def _extremes(state: KneeState) -> Fact | None:
    spread = _spread(state)
    if state.result is None or spread is None:
        return None
    one, two = (float(angle) for angle in results.angles_deg(state.result)[:, _STRAIGHT])
    apart = abs(two - one)
    found = {"one_deg": one, "two_deg": two, "apart_deg": apart}
    return Fact(right=apart, values=spread | found)


def _meaning(state: KneeState) -> Fact | None:
    if state.result is None:
        return None
    one, two = results.angles_deg(state.result)
    apart = np.abs(two - one)
    most, unloaded = int(np.argmax(apart)), float(apart[_UNLOADED])
    share = unloaded / float(apart[most])
    return Fact(
        right=0 if share >= 0.75 else 1 if share >= 0.1 else 2,
        values={
            "unloaded_deg": unloaded,
            "most_nm": float(MOMENT[most]),
            "most_deg": float(apart[most]),
        },
    )


FACTS: dict[str, Callable[[KneeState], Fact | None]] = {
    "rest": _rest,
    "motion": _motion,
    "load": _load,
    "millimetre": _millimetre,
    "random": _random,
    "stand-in": _stand_in,
    "extremes": _extremes,
    "meaning": _meaning,
}
"""By the step's name."""

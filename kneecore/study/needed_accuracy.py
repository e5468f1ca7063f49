"""How accurately the geometry must be known for every knee to extend far enough.

Examples
--------
>>> import kneecore
>>> need = kneecore.needed_accuracy(within_deg=5.0, solver="equilibrium")
>>> need.answer()[:41]
'Every knee extends to within 5 deg if the'
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from kneecore._threads import thread_count
from kneecore.errors import ModelError, ParameterError
from kneecore.knee.model import KneeModel
from kneecore.knee.response import RestLength, Solver
from kneecore.knee.space import ParameterSpace
from kneecore.numbers import plain
from kneecore.numerics.sampling import uniform
from kneecore.progress import Callback
from kneecore.search.exact_model import exact_extremes
from kneecore.search.result import LARGEST_EXTENSION, versions
from kneecore.study.bound_sweep import (
    Steps,
    checked_bounds,
    settings_told,
    with_geometry_bound,
)

__all__ = ["NeededAccuracy", "needed_accuracy"]

CHECK_SAMPLES = 2000


@dataclass(frozen=True, kw_only=True, eq=False)
class NeededAccuracy:
    """The largest bound on the geometry with which every knee still extends far enough."""

    space: ParameterSpace
    solver: Solver
    rest_length: RestLength
    within_deg: float
    """Flexion that may be left at the largest extension moment, deg."""
    bound_mm: float | None
    """The bound, mm; None if even an exactly known geometry is not enough."""
    reaches_largest: bool
    """Whether the largest bound looked at is still enough, so that the answer is beyond it."""
    largest_angle_deg: float
    """Largest angle of any knee within the bound (within no bound, where there is none)."""
    beyond_mm: float | None
    """A bound that is too wide by little, mm; None if there is none."""
    beyond_deg: float | None
    """Largest angle there: above `within_deg`."""
    sampled_deg: float | None
    """Largest angle of a random sample within the bound: a check from the other side."""
    n_sampled: int
    n_searches: int
    seed: int
    seconds: float
    versions: Mapping[str, str]

    def answer(self) -> str:
        """Return the answer in one sentence."""
        goal = f"Every knee extends to within {self.within_deg:g} deg"
        if self.bound_mm is None:
            return (
                f"Not {goal[0].lower()}{goal[1:]} even if the geometry is known exactly: one stops "
                f"at {self.largest_angle_deg:.2f} deg."
            )
        if self.reaches_largest:
            return (
                f"{goal} even if the geometry is only known to within {self.bound_mm:g} mm, the "
                f"widest bound that was looked at: all reach "
                f"{self.largest_angle_deg:.2f} deg."
            )
        return (
            f"{goal} if the geometry is known to within {self.bound_mm:.3f} mm; at "
            f"{self.beyond_mm:.3f} mm one stops at {self.beyond_deg:.2f} deg."
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the answer as JSON-ready values."""
        return {
            "schema": "kneecore.needed_accuracy/1",
            "answer": self.answer(),
            "within_deg": self.within_deg,
            "bound_mm": self.bound_mm,
            "reaches_largest": self.reaches_largest,
            "largest_angle_deg": plain(self.largest_angle_deg),
            "beyond_mm": self.beyond_mm,
            "beyond_deg": _plain(self.beyond_deg),
            "sampled_largest_angle_deg": _plain(self.sampled_deg),
            "n_sampled": self.n_sampled,
            "n_searches": self.n_searches,
            "seconds": round(self.seconds, 6),
            **settings_told(self.space, self.solver, self.rest_length, self.seed, self.versions),
        }

    def __str__(self) -> str:
        from kneecore.report.sweep import accuracy_report

        return accuracy_report(self)


def _plain(value: float | None) -> Any:
    return None if value is None else plain(value)


def needed_accuracy(
    space: ParameterSpace | None = None,
    *,
    within_deg: float = 5.0,
    largest_mm: float = 2.5,
    tolerance_mm: float = 0.005,
    solver: Solver = "dynamics",
    rest_length: RestLength = "recomputed",
    seed: int = 0,
    threads: int | None = None,
    callback: Callback | None = None,
) -> NeededAccuracy:
    """Find how accurately the geometry must be known for every knee to extend far enough.

    The largest angle at the largest extension moment, over all knees of the space, grows with the
    bound; the bound at which it passes `within_deg` is bracketed by bisection. The answer is the
    bracket's lower end, its upper end is reported too, and the answer is checked by sampling.

    Parameters
    ----------
    space : ParameterSpace, optional
        As for `bound_sweep`.
    within_deg : float
        Flexion that may be left, deg.
    largest_mm : float
        Widest bound to look at, mm.
    tolerance_mm : float
        Width of the bracket at its end, mm.
    solver, rest_length, seed, threads, callback
        As for `bound_sweep`, which raises the same.
    """
    space = space or ParameterSpace()
    (largest,) = checked_bounds([largest_mm])
    if not (np.isfinite(tolerance_mm) and tolerance_mm > 0.0):
        raise ParameterError(f"`tolerance_mm` is {tolerance_mm}; a number above 0 is allowed")
    if not np.isfinite(within_deg):
        raise ParameterError(f"`within_deg` is {within_deg}; a finite number is allowed")
    n_threads = thread_count(threads)
    total = 2 + max(0, int(np.ceil(np.log2(largest / tolerance_mm))))
    steps = Steps(callback, "bracketing the bound", total)
    begun = time.perf_counter()

    def largest_angle(bound_mm: float) -> float:
        steps.begin()
        # Next to nothing stands for nothing: a space needs something that is free to vary.
        found = exact_extremes(
            with_geometry_bound(space, max(bound_mm, 1e-6)),
            LARGEST_EXTENSION,
            solver=solver,
            rest_length=rest_length,
            seed=seed,
            threads=n_threads,
            report=steps,
        )
        steps.begin()
        steps.done += 1
        return float(found.flexion_deg[1, LARGEST_EXTENSION])

    low, high = 0.0, largest
    at_low, at_high = largest_angle(low), largest_angle(high)
    enough, never = at_high <= within_deg, at_low > within_deg
    while not (enough or never) and high - low > tolerance_mm:
        middle = 0.5 * (low + high)
        angle = largest_angle(middle)
        if angle <= within_deg:
            low, at_low = middle, angle
        else:
            high, at_high = middle, angle
    if enough:
        low, at_low = high, at_high
    sampled = None
    if not never and low > 0.0:
        steps.begin()
        sampled = _largest_sampled(
            with_geometry_bound(space, low), solver, rest_length, seed, n_threads
        )
    bracketed = not (enough or never)
    return NeededAccuracy(
        space=space,
        solver=solver,
        rest_length=rest_length,
        within_deg=float(within_deg),
        bound_mm=None if never else low,
        reaches_largest=enough,
        largest_angle_deg=at_low,
        beyond_mm=high if bracketed else None,
        beyond_deg=at_high if bracketed else None,
        sampled_deg=sampled,
        n_sampled=0 if sampled is None else CHECK_SAMPLES,
        n_searches=steps.done,
        seed=seed,
        seconds=time.perf_counter() - begun,
        versions=versions(),
    )


def _largest_sampled(
    space: ParameterSpace, solver: Solver, rest_length: RestLength, seed: int, threads: int
) -> float:
    model = KneeModel(space, rest_length, threads, solver)
    angles = model(uniform(CHECK_SAMPLES, space.n_free, seed))[:, LARGEST_EXTENSION]
    if not np.isfinite(angles).any():
        raise ModelError("no sample within the bound gave an answer")
    return float(np.nanmax(angles))

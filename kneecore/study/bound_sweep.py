"""How the worst case grows with the bound on the geometry, and how accurate it has to be known.

Examples
--------
>>> import kneecore
>>> need = kneecore.needed_accuracy(within_deg=5.0, solver="equilibrium")
>>> need.answer()[:41]
'Every knee extends to within 5 deg if the'
"""

import dataclasses
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore._json import plain
from kneecore._threads import thread_count
from kneecore.errors import ModelError, ParameterError
from kneecore.model.response import RestLength, Solver
from kneecore.numerics.sampling import uniform
from kneecore.search.cancelled import Cancelled
from kneecore.search.exact_knee import ExactWorstCase, exact_extremes, exact_worst_case
from kneecore.search.knee import KneeModel
from kneecore.search.progress import Callback, Progress
from kneecore.search.result import LARGEST_EXTENSION, versions
from kneecore.space import ParameterSpace

__all__ = ["BoundSweep", "NeededAccuracy", "bound_sweep", "needed_accuracy", "with_geometry_bound"]

FloatArray = NDArray[np.float64]
BOUNDS_MM = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5)
"""From below what medical images resolve to the accuracy that the paper quotes for them."""
CHECK_SAMPLES = 2000


def with_geometry_bound(space: ParameterSpace, bound_mm: float) -> ParameterSpace:
    """Return `space` with another bound on the geometry.

    The slope's bound changes in proportion; half-ranges by name of geometric parameters make way.
    The material's and the rest lengths' bounds stay.
    """
    if not space.geometry_bound_mm > 0.0:
        raise ParameterError(
            f"`geometry_bound_mm` is {space.geometry_bound_mm:g} mm; above 0 is needed to vary it"
        )
    if space.case == "material":
        raise ParameterError("`case` is 'material'; 'both' or 'geometry' varies the geometry")
    kept = {
        name: half
        for name, half in (space.half_ranges or {}).items()
        if not name.startswith(("condyle", "plateau")) and not name.endswith(("_x", "_y"))
    }
    return dataclasses.replace(
        space,
        geometry_bound_mm=bound_mm,
        slope_bound_deg=space.slope_bound_deg * bound_mm / space.geometry_bound_mm,
        half_ranges=kept or None,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class BoundSweep:
    """Exact worst cases over bounds on the geometry."""

    space: ParameterSpace
    solver: Solver
    rest_length: RestLength
    bound_mm: FloatArray
    """Half-ranges of every length and coordinate, shape (n,), mm."""
    objective: FloatArray
    """f of the worst pair, deg summed over the 12 loads, shape (n,)."""
    pair_deg: FloatArray
    """Angles of its two knees at the largest extension moment, shape (n, 2), deg."""
    extremes_deg: FloatArray
    """Least and largest angle of any knee there, shape (n, 2), deg."""
    seed: int
    seconds: FloatArray
    """Of each bound's two searches, shape (n,)."""
    versions: Mapping[str, str]

    @property
    def extension_deficit_deg(self) -> FloatArray:
        """What the second knee of the worst pair lacks of straight, shape (n,), deg."""
        return np.maximum(self.pair_deg[:, 1], 0.0)

    @property
    def over_extension_deg(self) -> FloatArray:
        """How far the first knee of the worst pair over-extends, shape (n,), deg."""
        return np.maximum(-self.pair_deg[:, 0], 0.0)

    def to_dict(self) -> dict[str, Any]:
        """Return the sweep as JSON-ready values."""
        return {
            "schema": "kneecore.bound_sweep/1",
            "bound_mm": self.bound_mm.tolist(),
            "objective_model": plain(self.objective),
            "extension_deficit_deg": plain(self.extension_deficit_deg),
            "over_extension_deg": plain(self.over_extension_deg),
            "least_angle_deg": plain(self.extremes_deg[:, 0]),
            "largest_angle_deg": plain(self.extremes_deg[:, 1]),
            "seconds": [round(s, 6) for s in self.seconds.tolist()],
            **_told(self.space, self.solver, self.rest_length, self.seed, self.versions),
        }

    def __str__(self) -> str:
        from kneecore.study.sweep_report import bound_report

        return bound_report(self)


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
            **_told(self.space, self.solver, self.rest_length, self.seed, self.versions),
        }

    def __str__(self) -> str:
        from kneecore.study.sweep_report import accuracy_report

        return accuracy_report(self)


def _told(
    space: ParameterSpace, solver: str, rest_length: str, seed: int, used: Mapping[str, str]
) -> dict[str, Any]:
    return {
        "case": space.case,
        "solver": solver,
        "rest_length": rest_length,
        "slope_bound_deg_per_mm": space.slope_bound_deg / space.geometry_bound_mm,
        "material_bound_percent": space.material_bound_percent,
        "seed": seed,
        "baseline": {"title": space.title, "note": space.note},
        "versions": dict(used),
    }


def _plain(value: float | None) -> Any:
    return None if value is None else plain(value)


def _checked_bounds(bounds_mm: Sequence[float]) -> list[float]:
    bounds = [float(b) for b in bounds_mm]
    if not bounds or not all(np.isfinite(b) and b > 0.0 for b in bounds):
        raise ParameterError(f"`bounds_mm` is {list(bounds_mm)}; numbers above 0 are allowed")
    return bounds


class _Steps:
    """Reports how many of the searches are done, also from within a search."""

    def __init__(self, callback: Callback | None, stage: str, total: int) -> None:
        self._callback, self._stage, self._total = callback, stage, total
        self.done = 0

    def __call__(self, _best: float = 0.0, _n_models: int = 0) -> bool:
        if self._callback is None:
            return False
        report = Progress(stage=self._stage, done=self.done, total=self._total)
        return bool(self._callback(report))

    def begin(self) -> None:
        if self():
            raise Cancelled


def bound_sweep(
    space: ParameterSpace | None = None,
    *,
    bounds_mm: Sequence[float] = BOUNDS_MM,
    solver: Solver = "dynamics",
    rest_length: RestLength = "recomputed",
    seed: int = 0,
    threads: int | None = None,
    callback: Callback | None = None,
) -> BoundSweep:
    """Find the exact worst case for each of several bounds on the geometry.

    Parameters
    ----------
    space : ParameterSpace, optional
        Its bounds on the material and the ratio of slope to length stay; the packaged baseline with
        its default bounds for None.
    bounds_mm : sequence of float
        Half-ranges of every length and coordinate, mm.
    solver, rest_length, seed, threads
        As for `worst_case`.
    callback : callable, optional
        Gets `Progress`; a true result cancels (raises `Cancelled`).

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    ModelError
        If no knee could be evaluated.
    """
    space = space or ParameterSpace()
    bounds = _checked_bounds(bounds_mm)
    spaces = [with_geometry_bound(space, b) for b in bounds]
    steps = _Steps(callback, "searching at each bound", len(bounds))
    used: dict[str, Any] = {"solver": solver, "rest_length": rest_length, "seed": seed}
    used |= {"threads": thread_count(threads), "report": steps}
    objective, pairs, extremes, seconds = [], [], [], []
    for within in spaces:
        steps.begin()
        begun = time.perf_counter()
        worst = exact_worst_case(within, **used)
        steps.begin()
        one_load = exact_extremes(within, LARGEST_EXTENSION, **used)
        steps.begin()  # a search that was ended early is none
        objective.append(worst.objective)
        pairs.append(worst.flexion_deg[:, LARGEST_EXTENSION])
        extremes.append(_wider(one_load, worst))
        seconds.append(time.perf_counter() - begun)
        steps.done += 1
    steps()
    return BoundSweep(
        space=space,
        solver=solver,
        rest_length=rest_length,
        bound_mm=np.array(bounds),
        objective=np.array(objective),
        pair_deg=np.stack(pairs),
        extremes_deg=np.stack(extremes),
        seed=seed,
        seconds=np.array(seconds),
        versions=versions(),
    )


def _wider(one_load: ExactWorstCase, worst: ExactWorstCase) -> FloatArray:
    """Return the least and the largest angle that either search has seen."""
    seen = np.concatenate([found.flexion_deg[:, LARGEST_EXTENSION] for found in (one_load, worst)])
    return np.array([seen.min(), seen.max()])


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
    (largest,) = _checked_bounds([largest_mm])
    if not (np.isfinite(tolerance_mm) and tolerance_mm > 0.0):
        raise ParameterError(f"`tolerance_mm` is {tolerance_mm}; a number above 0 is allowed")
    if not np.isfinite(within_deg):
        raise ParameterError(f"`within_deg` is {within_deg}; a finite number is allowed")
    n_threads = thread_count(threads)
    total = 2 + max(0, int(np.ceil(np.log2(largest / tolerance_mm))))
    steps = _Steps(callback, "bracketing the bound", total)
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

"""How the worst case grows with the bound on the geometry.

Examples
--------
>>> import kneecore
>>> sweep = kneecore.bound_sweep(bounds_mm=(0.5, 1.0), solver="equilibrium")
>>> sweep.objective.round(1)  # deg, summed over the 12 loads
array([209.9, 421.1])
"""

import dataclasses
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore._threads import thread_count
from kneecore.errors import ParameterError
from kneecore.knee.parameters import STRUCTURE
from kneecore.knee.response import RestLength, Solver
from kneecore.knee.space import ParameterSpace
from kneecore.numbers import plain
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.exact_model import ExactWorstCase, exact_extremes, exact_worst_case
from kneecore.search.result import LARGEST_EXTENSION, versions
from kneecore.study.defaults import BOUNDS_MM

__all__ = ["BoundSweep", "bound_sweep", "with_geometry_bound"]

FloatArray = NDArray[np.float64]
_GEOMETRIC = frozenset(row[0] for row in STRUCTURE if row[2] == "geometry")


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
        name: half for name, half in (space.half_ranges or {}).items() if name not in _GEOMETRIC
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
            **settings_told(self.space, self.solver, self.rest_length, self.seed, self.versions),
        }

    def __str__(self) -> str:
        from kneecore.report.sweep import bound_report

        return bound_report(self)


def settings_told(
    space: ParameterSpace, solver: str, rest_length: str, seed: int, used: Mapping[str, str]
) -> dict[str, Any]:
    """Return what a result over the geometry's bounds was made with, as JSON-ready values."""
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


def checked_bounds(bounds_mm: Sequence[float]) -> list[float]:
    """Return bounds (mm) checked: at least one, all above 0."""
    bounds = [float(b) for b in bounds_mm]
    if not bounds or not all(np.isfinite(b) and b > 0.0 for b in bounds):
        raise ParameterError(f"`bounds_mm` is {list(bounds_mm)}; numbers above 0 are allowed")
    return bounds


class Steps:
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
    bounds = checked_bounds(bounds_mm)
    spaces = [with_geometry_bound(space, b) for b in bounds]
    steps = Steps(callback, "searching at each bound", len(bounds))
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

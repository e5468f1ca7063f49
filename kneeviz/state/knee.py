"""What one view knows: the baseline, the bounds, the visitor's knee, the last search's result.

No widget and no thread here; kneecore does every computation. Values are SI.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import kneecore
from kneecore import (
    NAMES,
    Knee,
    ParameterError,
    ParameterSpace,
    Response,
    Trajectory,
    packaged_knee,
    parameter_table,
)
from kneecore.knee.parameters import widened
from kneecore.knee.space import Case
from kneeviz.geometry.sweep import Sweep, sweep_of

FloatArray = NDArray[np.float64]

RestLength = Any  # kneecore's literal: "recomputed" or "fixed"

_TABLE = parameter_table(rest_lengths=True)
WIDTH = len(_TABLE)
"""Entries of the visitor's knee: the changes of its rest lengths are always among them."""
GEOMETRY = np.array([row.kind == "geometry" for row in _TABLE[: len(NAMES)]])
SLOPE = np.array([row.name == "plateau_slope" for row in _TABLE[: len(NAMES)]])
SCALE = np.array([row.scale for row in _TABLE])
TRAINING_SAMPLES = 50


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """How far the parameters may be from the baseline. None keeps the knee file's half-ranges."""

    case: Case = "both"
    geometry_mm: float | None = None
    slope_deg: float | None = None
    material_percent: float | None = None
    rest_length_mm: float | None = None
    rest_length: RestLength = "recomputed"

    def space(self, knee: Knee) -> ParameterSpace:
        """Return the space around a knee file's baseline."""
        given = (self.geometry_mm, self.slope_deg, self.material_percent, self.rest_length_mm)
        geometry, slope, material, rest = (
            default if value is None else value
            for value, default in zip(given, (1.0, 1.0, 10.0, 0.0), strict=True)
        )
        if knee is packaged_knee():  # then no file is needed to name the space
            return ParameterSpace(
                case=self.case,
                geometry_bound_mm=geometry,
                slope_bound_deg=slope,
                material_bound_percent=material,
                rest_length_bound_mm=rest,
            )
        kept = {
            row.name: float(half)
            for i, (row, half) in enumerate(zip(_TABLE, knee.half_ranges, strict=False))
            if given[_bound_of(i)] is None
        }
        return ParameterSpace(
            case=self.case,
            geometry_bound_mm=geometry,
            slope_bound_deg=slope,
            material_bound_percent=material,
            rest_length_bound_mm=rest,
            half_ranges=kept,
            baseline=knee.baseline,
            title=knee.title,
            note=knee.note,
        )


def _bound_of(index: int) -> int:
    if index >= len(NAMES):
        return 3
    if not GEOMETRY[index]:
        return 2
    return 1 if SLOPE[index] else 0


def shown_bounds(knee: Knee) -> tuple[float, float, float, float]:
    """Return the largest half-ranges of a knee file: (mm, deg, % of the value, mm at rest)."""
    all_halves = widened(knee.half_ranges, WIDTH)
    half, rest = all_halves[: len(NAMES)], all_halves[len(NAMES) :]
    size = np.maximum(np.abs(knee.baseline[: len(NAMES)]), 1e-30)
    length = GEOMETRY & ~SLOPE
    return (
        float(1e3 * half[length].max()),
        float(np.degrees(half[SLOPE].max())),
        float(100.0 * (half / size)[~GEOMETRY].max()),
        float(1e3 * rest.max()),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Solved:
    """A knee with kneecore's answer."""

    x: FloatArray
    response: Response
    sweep: Sweep | None
    """None if the model failed."""


class KneeState:
    """Everything that one view shows. One thread owns it."""

    def __init__(self, knee: Knee) -> None:
        self.knee = knee
        self.bounds = Bounds()
        self.space = self.bounds.space(knee)
        start = knee.baseline if knee.current is None else knee.current
        self.x: FloatArray = widened(start, WIDTH)
        self.baseline: Solved | None = None
        self.current: Solved | None = None
        self.surrogate: Any = None
        self.predicted: FloatArray | None = None
        self.result: Any = None
        self.worst: tuple[Solved | None, Solved | None] = (None, None)

    @property
    def strain_free(self) -> bool:
        """Whether every knee is without load in the same pose."""
        changed = self.x[len(NAMES) :].any() or len(self.space.lower) > len(NAMES)
        return bool(self.bounds.rest_length == "recomputed" and not changed)

    @property
    def at_baseline(self) -> bool:
        """Whether the visitor's knee is the baseline."""
        return np.array_equal(self.x, widened(self.space.baseline, WIDTH))

    @property
    def result_is_stale(self) -> bool:
        """Whether the result belongs to other bounds than those set now."""
        return self.result is not None and self.is_stale(self.result)

    def is_stale(self, found: Any) -> bool:
        """Tell whether a result of kneecore's belongs to other bounds than those set now."""
        old, now = found.space, self.space
        if not old.is_around_baseline:
            try:
                now = self.space_around_knee()
            except ParameterError:
                return True
        same = (
            np.array_equal(old.lower, now.lower)
            and np.array_equal(old.upper, now.upper)
            and np.array_equal(old.baseline, now.baseline)
        )
        return not same or found.rest_length != self.bounds.rest_length

    def space_around_knee(self) -> ParameterSpace:
        """Return the present bounds around the visitor's knee instead of the baseline.

        The baseline still fixes the load-free pose, so that the knee in the middle is the one
        whose curve is drawn.

        Raises
        ------
        ParameterError
            If they hold knees that cannot be.
        """
        if self.at_baseline:
            return self.space
        return replace(self.space, centre=widened(self.x, len(self.space.baseline)))

    def solve(self, x: FloatArray) -> Solved:
        """Run kneecore for one knee."""
        response = kneecore.simulate(
            x, baseline=self.space.baseline, rest_length=self.bounds.rest_length
        )
        sweep = sweep_of(x, response, strain_free=self.strain_free)
        return Solved(x=widened(x, WIDTH), response=response, sweep=sweep)

    def predict(self, x: FloatArray) -> FloatArray | None:
        """Return the surrogate's angles for `x`, or None where it knows nothing of it."""
        beyond = x[len(self.space.lower) :].any()
        return None if self.surrogate is None or beyond else self.surrogate.predict(x)

    def update(self, x: FloatArray) -> Solved:
        """Make `x` the visitor's knee, for the true model and the surrogate; return the answer.

        A knee whose model fails leaves the last good answer in `current`.
        """
        self.x = widened(x, WIDTH)
        solved = self.solve(self.x)
        if solved.sweep is not None:
            self.current = solved
        self.predicted = self.predict(self.x)
        return solved

    def preview(self, x: FloatArray) -> None:
        """Show a knee on the way to `self.x` without keeping it."""
        solved = self.solve(x)
        if solved.sweep is not None:
            self.current = solved
        self.predicted = self.predict(x)

    def set_bounds(self, bounds: Bounds, *, keep_surrogate: bool = False) -> None:
        """Take other bounds; the visitor's knee is drawn into them.

        With `keep_surrogate` that of the old bounds stays until the next fit.

        Raises
        ------
        ParameterError
            If no knee fits the bounds; nothing has changed then.
        """
        space = bounds.space(self.knee)
        self.bounds, self.space = bounds, space
        self.x = np.clip(self.x, widened(space.lower, WIDTH), widened(space.upper, WIDTH))
        if not keep_surrogate:
            self.surrogate = self.predicted = None

    def set_knee(self, knee: Knee) -> None:
        """Take another baseline with its own half-ranges, and its current values if it has any."""
        self.__init__(knee)  # type: ignore[misc]

    def solve_baseline(self) -> None:
        """Run kneecore for the baseline knee."""
        self.baseline = self.solve(self.space.baseline)

    def fit(self) -> None:
        """Fit the surrogate of the present bounds; raises `KneecoreError` if it cannot be."""
        self.surrogate = self.predicted = None
        n_samples = max(TRAINING_SAMPLES, self.space.n_free + 2)
        self.surrogate = kneecore.fit_surrogate(
            self.space,
            n_samples=n_samples,
            seed=0,
            rest_length=self.bounds.rest_length,
            threads=1,
        )
        self.predicted = self.predict(self.x)

    def take_result(self, result: Any) -> None:
        """Keep a search's result and prepare its two knees for display."""
        strain_free = result.rest_length == "recomputed" and result.x.shape[1] == len(NAMES)
        worst = []
        for x, response in zip(result.x, (result.model_1, result.model_2), strict=True):
            sweep = sweep_of(x, response, strain_free=strain_free)
            worst.append(Solved(x=np.array(x), response=response, sweep=sweep))
        self.result, self.worst = result, (worst[0], worst[1])

    def trajectory(self, x: FloatArray) -> Trajectory:
        """Return a knee's motion in time."""
        return kneecore.trajectory(
            x, baseline=self.space.baseline, rest_length=self.bounds.rest_length
        )

    def slider_range(self, index: int) -> tuple[float, float]:
        """Return a slider's ends in the parameter's unit; they hold the present value too."""
        value, scale = float(self.x[index]), float(SCALE[index])
        low, high = (
            float(widened(edge, WIDTH)[index]) for edge in (self.space.lower, self.space.upper)
        )
        if high - low < 1e-12 * scale:
            pad = 1e-3 * max(abs(value), scale)
            low, high = low - pad, high + pad
        return min(low, value) / scale, max(high, value) / scale

    def is_free(self, index: int) -> bool:
        """Tell whether the bounds let a parameter vary."""
        return index < len(self.space.free) and bool(self.space.free[index])

    def knee_text(self) -> str:
        """Return the baseline, its half-ranges and the visitor's knee as a knee file."""
        # The lower side: Poisson's upper bound may have been clipped.
        half = self.space.baseline - self.space.lower
        half = np.where(self.space.free, half, widened(self.knee.half_ranges, len(half)))
        plain = not self.x[len(NAMES) :].any() and len(half) == len(NAMES)
        return kneecore.dump_knee(
            baseline=self.space.baseline,
            half_ranges=half,
            sources=self.knee.sources,
            current=self.x[: len(NAMES)] if plain else self.x,
            title=self.knee.title,
            note=self.knee.note,
        )


PRESETS: dict[str, dict[str, float]] = {
    "ACL 1 bound further forward": {"acl_femur_x": 1.0},
    "ACL 1 bound lower on the femur": {"acl_femur_y": -1.0},
    "Steeper plateau": {"plateau_slope": 1.0},
    "Flatter plateau": {"plateau_slope": -1.0},
    "Larger condyle": {"condyle_radius": 1.0},
    "Everything soft": {name: -1.0 for name in NAMES if name.endswith(("stiffness", "modulus"))},
    "Everything stiff": {name: 1.0 for name in NAMES if name.endswith(("stiffness", "modulus"))},
}
"""Telling knees, as shares of the half-range away from the baseline."""


def preset_knee(name: str, space: ParameterSpace) -> FloatArray:
    """Return a preset's parameters within a space."""
    x = np.array(space.baseline)
    for parameter, share in PRESETS[name].items():
        i = NAMES.index(parameter)
        edge = space.upper[i] if share > 0.0 else space.lower[i]
        x[i] += abs(share) * (edge - x[i])
    return x


def random_knee(space: ParameterSpace, rng: np.random.Generator) -> FloatArray:
    """Return a knee drawn uniformly from a space."""
    return space.from_unit(rng.random(len(space.lower)))


def with_bound(bounds: Bounds, name: str, value: Any) -> Bounds:
    """Return `bounds` with one of its fields replaced."""
    return replace(bounds, **{name: value})


def runs_in_time(
    state: KneeState, knees: tuple[Solved | None, ...]
) -> tuple[Trajectory | None, ...]:
    """Return the motions in time of the visitor's knee and the two worst cases."""
    current, *worst = knees
    runs: list[Trajectory | None] = [None if current is None else state.trajectory(current.x)]
    for knee in worst:
        if knee is None or knee.sweep is None:
            runs.append(None)
            continue
        result = state.result
        runs.append(
            kneecore.trajectory(
                knee.x, baseline=result.space.baseline, rest_length=result.rest_length
            )
        )
    return tuple(runs)


def training_curves(state: KneeState) -> Any:
    """Return the surrogate's training curves that did not fail, shape (n, 12), rad, or None."""
    if state.surrogate is None:
        return None
    curves = state.surrogate.training_flexion
    return curves[np.isfinite(curves).all(axis=1)]

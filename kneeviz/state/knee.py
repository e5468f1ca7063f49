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
    KneeFile,
    ParameterError,
    ParameterSpace,
    Response,
    SearchResult,
    TrainedSurrogate,
    Trajectory,
)
from kneecore.knee.parameters import widened
from kneecore.knee.response import Solver
from kneecore.search.settings import enough_samples
from kneeviz.geometry.sweep import Sweep, sweep_of
from kneeviz.jobs.cores import spare_cores
from kneeviz.state import results
from kneeviz.state.bounds import SCALE, WIDTH, Bounds
from kneeviz.state.origin import Origin, digest, of_found, of_space

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Solved:
    """A knee with kneecore's answer."""

    x: FloatArray
    response: Response
    sweep: Sweep | None
    """None if the model failed."""
    origin: Origin


class KneeState:
    """Everything that one view shows. One thread owns it."""

    def __init__(self, knee: KneeFile) -> None:
        self.result: SearchResult | None = None
        self.worst: tuple[Solved | None, Solved | None] = (None, None)
        self.set_knee(knee)

    def set_knee(self, knee: KneeFile) -> None:
        """Take another baseline with its own half-ranges, and its current values if it has any.

        The last search's result stays; it is stale then.
        """
        self.knee = knee
        self.bounds = Bounds()
        self.space = self.bounds.space(knee)
        start = knee.baseline if knee.current is None else knee.current
        self.x: FloatArray = widened(start, WIDTH)
        self.baseline: Solved | None = None
        self.current: Solved | None = None
        self.surrogate: TrainedSurrogate | None = None
        self.predicted: FloatArray | None = None

    @property
    def strain_free(self) -> bool:
        """Whether every knee is without load in the same pose."""
        return self._strain_free(self.x)

    def _strain_free(self, x: FloatArray) -> bool:
        changed = x[len(NAMES) :].any() or len(self.space.lower) > len(NAMES)
        return bool(self.bounds.rest_length == "recomputed" and not changed)

    def knees(self, solver: Solver = "dynamics") -> Knee:
        """Return the knees within the present bounds around the baseline, for long work."""
        return Knee(
            self.space,
            solver=solver,
            rest_length=self.bounds.rest_length,
            threads=spare_cores(),
        )

    @property
    def at_baseline(self) -> bool:
        """Whether the visitor's knee is the baseline."""
        return np.array_equal(self.x, widened(self.space.baseline, WIDTH))

    def origin(self, *, around_knee: bool = False) -> Origin:
        """Return what is computed now is computed for; its bounds are around the visitor's knee."""
        try:
            space = self.space_around_knee() if around_knee else self.space
        except ParameterError:  # no bounds can be there
            return Origin(knee=digest(self.x))
        now = of_space(space, self.bounds.rest_length)
        return replace(now, knee=digest(self.x))

    def is_stale(self, found: Any) -> bool:
        """Tell whether one of kneecore's results belongs to other bounds than those set now."""
        then = of_found(found)
        return bool(then.changed(self.origin(around_knee=then.knee is not None)))

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
        full = widened(x, WIDTH)
        sweep = sweep_of(x, response, strain_free=self._strain_free(full))
        origin = replace(self.origin(), bounds=None, knee=digest(full))
        return Solved(x=full, response=response, sweep=sweep, origin=origin)

    def predict(self, x: FloatArray) -> FloatArray | None:
        """Return the surrogate's angles for `x`, rad, or None where it knows nothing of it."""
        beyond = x[len(self.space.lower) :].any()
        if self.surrogate is None or beyond:
            return None
        return np.radians(self.surrogate.predict(x[: len(self.space.lower)]))

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

    def take_box(self, knee: KneeFile, bounds: Bounds) -> None:
        """Take a baseline and bounds around it; the visitor's knee stays as it is.

        Raises
        ------
        ParameterError
            If no knee fits the bounds; nothing has changed then.
        """
        self.space = bounds.space(knee)
        self.knee, self.bounds = knee, bounds
        self.surrogate = self.predicted = None

    def solve_baseline(self) -> None:
        """Run kneecore for the baseline knee."""
        solved = self.solve(self.space.baseline)
        self.baseline = replace(solved, origin=replace(solved.origin, knee=None))

    def fit(self) -> None:
        """Fit the surrogate of the present bounds; raises `KneecoreError` if it cannot be."""
        self.surrogate = self.predicted = None
        n_samples = enough_samples(self.space.n_free)
        knee = Knee(self.space, rest_length=self.bounds.rest_length, threads=1)
        self.surrogate = kneecore.fit_surrogate(knee, n_samples=n_samples, seed=0)
        self.predicted = self.predict(self.x)

    def take_result(self, result: SearchResult) -> None:
        """Keep a search's result and prepare its two knees for display."""
        recomputed = results.rest_length(result) == "recomputed"
        worst = []
        for x, response in results.knees(result):
            sweep = sweep_of(x, response, strain_free=recomputed and len(x) == len(NAMES))
            worst.append(Solved(x=x, response=response, sweep=sweep, origin=of_found(result)))
        self.result, self.worst = result, (worst[0], worst[1])

    def forget_result(self) -> None:
        """Have no result any more."""
        self.result, self.worst = None, (None, None)

    @property
    def training_curves(self) -> FloatArray | None:
        """The surrogate's training curves that did not fail, shape (n, 12), rad, or None."""
        if self.surrogate is None:
            return None
        curves = np.radians(self.surrogate.training_y)
        kept: FloatArray = curves[np.isfinite(curves).all(axis=1)]
        return kept

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
        plain = not self.x[len(NAMES) :].any() and len(self.space.lower) == len(NAMES)
        return self.space.to_toml(self.x[: len(NAMES)] if plain else self.x)

"""The knee as a model: 28 inputs, one output, the flexion angle over 12 moments.

Examples
--------
>>> import kneecore
>>> knee = kneecore.Knee(kneecore.ParameterSpace(case="material"))
>>> knee.n_free, knee.n_outputs
(6, 12)
>>> knee.simulate(knee.nominal).status
'ok'
"""

import dataclasses
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, Self, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._arguments import choice
from kneecore._arrays import numbers
from kneecore._second_compiler import compile_apart, wait_for
from kneecore.knee import bounds
from kneecore.knee.ahead import AT_REST, IN_MOTION
from kneecore.knee.file import packaged_knee
from kneecore.knee.gradient import flexion_gradient
from kneecore.knee.likely import inputs_of
from kneecore.knee.parameters import ALL_NAMES, N_PARAMETERS, STRUCTURE, widened
from kneecore.knee.physics.dynamics import MAX_REFINEMENTS, flexion_of, respond
from kneecore.knee.physics.equilibrium import equilibria
from kneecore.knee.physics.marks import compile_marks
from kneecore.knee.picture import shapes
from kneecore.knee.response import (
    LARGEST_EXTENSION,
    MOMENT,
    QUANTITIES,
    Response,
    ResponseBatch,
    RestLength,
    Solver,
    check_solver,
    prepare,
    simulate,
    simulate_batch,
)
from kneecore.knee.slopes import settled_slopes
from kneecore.knee.space import ParameterSpace, check_space
from kneecore.knee.step_check import half_step_change
from kneecore.knee.trajectory import Trajectory, trajectory
from kneecore.model import Evaluation, Model, Shape, Slopes
from kneecore.outputs import Output

__all__ = ["Knee"]

FloatArray = NDArray[np.float64]

FLEXION = Output(
    "flexion", unit="deg", axis=tuple(MOMENT), axis_name="external moment", axis_unit="N m"
)
"""Flexion > 0; the moment extends where it is positive."""
ALONG_LOADS = tuple(int(k) for k in np.argsort(-MOMENT, kind="stable"))
"""The loads from the largest extension to the largest flexion."""


class Knee(Model):
    """The knees of a parameter space.

    Parameters
    ----------
    space : ParameterSpace, optional
        The baseline and how far the parameters may be from it; the packaged baseline with its
        default bounds for None.
    solver : {"dynamics", "equilibrium"}
        Whether to integrate the motion over 23 s, as the paper does, or to solve for the knee at
        rest under each load. With "equilibrium", a knee without one is a failed run.
    rest_length : {"recomputed", "fixed"}
        Whether each knee's ligaments are strain-free in its own load-free pose, or all have the
        baseline's rest lengths.
    threads : int, optional
        Threads to use; all available cores for None. The numbers do not depend on it.
    workers : int, str or executor, optional
        Who runs the knees, as for `Model`: for millions of samples on many machines.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """

    can_keep = False
    count_names = ("failed", "refined", "unsettled")
    in_corners = True
    watched = LARGEST_EXTENSION
    picture_unit = "mm"
    size_name = "bound on the geometry"
    size_unit = "mm"
    sizes = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5)
    """From below what medical images resolve to the accuracy that the paper quotes for them."""
    goal = 5.0
    """Flexion that may be left at the largest extension moment, deg."""

    def __init__(
        self,
        space: ParameterSpace | None = None,
        *,
        solver: Solver = "dynamics",
        rest_length: RestLength = "recomputed",
        threads: int | None = None,
        workers: Any = None,
    ) -> None:
        space = ParameterSpace() if space is None else check_space(space)
        self.space = space
        self.solver = check_solver(solver)
        self.rest_length = choice("rest_length", rest_length, get_args(RestLength))
        self._most_halvings = MAX_REFINEMENTS
        super().__init__(
            None,
            inputs_of(space.baseline, space.centre, *space.stated, space.likely),
            [FLEXION],
            name=self.space.title,
            threads=threads,
            workers=workers,
        )

    @property
    def order(self) -> tuple[int, ...]:
        """The loads from the largest extension to the largest flexion."""
        return ALONG_LOADS

    @property
    def groups(self) -> Mapping[str, str]:
        """Which group each parameter belongs to: a ligament, the condyle, the plateau, material."""
        return {row[0]: row[1] for row in STRUCTURE}

    @property
    def measurements(self) -> Mapping[str, str]:
        """Which measurement tells each parameter: the two coordinates of a point are one."""
        return {name: bounds.measurement_of(name) for name in self.names}

    def stated_tolerance(self, name: str) -> tuple[float, str]:
        """Return a parameter's half-range: geometry's in mm or deg, material's in per cent."""
        return bounds.stated_tolerance(self.space, name)

    @property
    def computed(self) -> Mapping[str, str]:
        """Which response, and what the ligaments' rest lengths are."""
        return {"solver": self.solver, "rest length": self.rest_length}

    @property
    def objectives(self) -> Mapping[str, FloatArray]:
        """All loads, those of extension, or those of flexion."""
        return {
            "all": np.ones(len(MOMENT)),
            "extension": np.where(MOMENT > 0, 1.0, 0.0),
            "flexion": np.where(MOMENT > 0, 0.0, 1.0),
        }

    @property
    def size(self) -> float:
        """Half-range of every length and coordinate, mm."""
        return self.space.geometry_bound_mm

    @property
    def identity(self) -> bytes:
        """What tells its runs from those of other knees, or computed in another way."""
        way = f"{self.solver} {self.rest_length}"
        if self._most_halvings < MAX_REFINEMENTS:
            way += f" {self._most_halvings}"
        return b"\0".join([super().identity, way.encode(), self.space.baseline.tobytes()])

    def with_size(self, size: float) -> Self:
        """Return the knees with another bound on the geometry, mm; see `with_geometry_bound`."""
        return self.with_space(bounds.with_geometry_bound(self.space, size))

    def with_widths(self, factors: ArrayLike) -> Self:
        """Return the knees with bounds `factors` times as wide, around the box's centre."""
        return self.with_space(bounds.with_narrower(self.space, self._factors(factors)))

    def with_quantile(self, quantile: float | None) -> Self:
        """Return the knees with bounds that hold so much of each parameter's distribution."""
        return self.with_space(dataclasses.replace(self.space, quantile=quantile))

    def with_space(self, space: ParameterSpace) -> Self:
        """Return the knees of another space, computed in the same way."""
        knee = type(self)(
            space, solver=self.solver, rest_length=self.rest_length, threads=self.threads
        )
        knee._engine, knee._options = self._engine, self._options  # the same workers
        return knee

    @property
    def has_gradient(self) -> bool:
        """Whether exact derivatives are known: at rest they are."""
        return self.solver == "equilibrium"

    @cached_property
    def proxy(self) -> "Knee | None":  # type: ignore[override]
        """The same knees at rest, for knees in motion."""
        if self.has_gradient:
            return None
        return Knee(
            self.space, solver="equilibrium", rest_length=self.rest_length, threads=self.threads
        )

    @property
    def screening(self) -> Self:
        """The same knees; in motion, one that needs the time step halved fails.

        With fixed rest lengths knees are pre-stressed, and many need it halved once: more than once
        fails. Nearly all of those fail in the end, after up to fourteen times the work.
        """
        knee = self._copy()
        knee._most_halvings = 1 if self.rest_length == "fixed" else 0
        return knee

    @property
    def has_picture(self) -> bool:
        """Circle, line and ligaments can be drawn."""
        return True

    def to_free_unit(self, x: ArrayLike) -> FloatArray:
        """Map knees, SI, to the free parameters' unit cube; 28 values change no rest length."""
        unit: FloatArray = self.space.to_unit(x)[..., self.free]
        return unit

    def _points(self, argument: str, x: ArrayLike) -> FloatArray:
        values = numbers(argument, x)
        if values.ndim > 0 and values.shape[-1] in (N_PARAMETERS, len(ALL_NAMES)):
            if values[..., len(self.inputs) :].any():  # rest lengths are changed, but held
                return np.array(values, dtype=np.float64)
            return widened(values, len(self.inputs))
        return super()._points(argument, x)

    def _examine(self, x: FloatArray, *, observe: bool) -> Evaluation:
        """Run the knees, SI, shape (n, 28) or (n, 32); angles in deg, (n, 12)."""
        if observe:
            return self._observed(x)
        rows = prepare(x, self.space.baseline, self.rest_length)
        if self.solver == "equilibrium":
            poses, lost_at = equilibria(rows, self.threads)
            counts = {"failed": int(np.count_nonzero(~np.isnan(lost_at)))}
            return Evaluation(y=np.degrees(flexion_of(poses)), counts=counts)
        poses, settled, refinements = respond(rows, self.threads, self._most_halvings)
        failed = refinements < 0
        return Evaluation(
            y=np.degrees(flexion_of(poses)),
            counts={
                "failed": int(np.count_nonzero(failed)),
                "refined": int(np.count_nonzero(refinements > 0)),
                "unsettled": int(np.count_nonzero(~settled.all(axis=1) & ~failed)),
            },
        )

    def _observed(self, x: FloatArray) -> Evaluation:
        """Run the knees with forces and positions; those without an equilibrium failed."""
        batch = self.simulate_batch(x)
        lost = ~np.isnan(batch.lost_at)
        good = ~(batch.failed | lost)
        y = np.where(good[:, None], np.degrees(batch.flexion), np.nan)
        return Evaluation(
            y=y,
            counts={
                "failed": int(np.count_nonzero(~good)),
                "refined": int(np.count_nonzero(batch.refinements[good] > 0)),
                **_marks(batch, good),
                "lost": int(np.count_nonzero(lost)),
            },
            observed={name: factor * getattr(batch, field) for name, field, factor in QUANTITIES},
        )

    def slopes(self, u: FloatArray, weights: FloatArray) -> Slopes:
        """Return weighted sums of the angles at rest with their gradients, deg; see `Model`."""
        return settled_slopes(self.space, self.rest_length, self.threads, u, weights)

    def responses(self, x: FloatArray) -> Sequence[Response]:
        """Return each knee's whole response."""
        batch = simulate_batch(
            x,
            baseline=self.space.baseline,
            rest_length=self.rest_length,
            solver=self.solver,
            threads=1,
        )
        return list(batch)

    def marks(self, x: FloatArray) -> Mapping[str, int]:
        """Return how many knees, SI, shape (n, 28), bear each mark at some load."""
        batch = self.simulate_batch(x)
        return _marks(batch, ~batch.failed)

    def simulate(self, x: ArrayLike) -> Response:
        """Return one knee's response, `x` of shape (28,) or (32,), SI."""
        return simulate(
            x,
            baseline=self.space.baseline,
            rest_length=self.rest_length,
            solver=self.solver,
        )

    def simulate_batch(self, x: ArrayLike) -> ResponseBatch:
        """Return the responses of many knees, `x` of shape (n, 28) or (n, 32), SI."""
        return simulate_batch(
            x,
            baseline=self.space.baseline,
            rest_length=self.rest_length,
            solver=self.solver,
            threads=self.threads,
        )

    def trajectory(self, x: ArrayLike) -> Trajectory:
        """Return one knee's motion in time, `x` of shape (28,) or (32,), SI."""
        return trajectory(x, baseline=self.space.baseline, rest_length=self.rest_length)

    def half_step_change(self, x: ArrayLike) -> FloatArray:
        """Return by how much half the time step moves each angle of the motion, (n, 12), rad."""
        return half_step_change(
            x, baseline=self.space.baseline, rest_length=self.rest_length, threads=self.threads
        )

    def draw(self, x: ArrayLike) -> Sequence[Shape]:
        """Return circle, plateau and ligaments in the load-free pose, femur frame, mm."""
        return shapes(x, self.space.baseline, self.rest_length)

    def warm_up(self, *, gradient: bool = False) -> None:
        """Run each of the knee's kernels once."""
        if gradient:
            compile_apart(AT_REST)
        if self.solver == "dynamics":  # while another process may be at the motion
            compile_marks()
        wait_for(IN_MOTION)
        simulate(self.space.baseline, solver=self.solver)
        if gradient:
            wait_for(AT_REST)
            flexion_gradient(self.space.baseline)


def _marks(batch: ResponseBatch, chosen: NDArray[np.bool_]) -> dict[str, int]:
    """Return how many of the chosen knees (n,) bear each mark at some load."""
    return {
        "unsettled": int(np.count_nonzero(~batch.settled[chosen].all(axis=1))),
        "not_at_rest": int(np.count_nonzero(~batch.at_rest[chosen].all(axis=1))),
        "implausible": int(np.count_nonzero(batch.implausible[chosen].any(axis=1))),
    }


def compile_at_rest() -> None:
    """Compile the larger half of an exact search's kernels."""
    simulate(packaged_knee().baseline, solver="equilibrium")

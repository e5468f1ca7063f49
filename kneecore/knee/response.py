"""The response of a knee to the load programme: one model, or many at once.

Examples
--------
>>> import numpy as np
>>> from kneecore import ParameterSpace, simulate
>>> knee = simulate(ParameterSpace().baseline)
>>> knee.status
'ok'
>>> np.round(np.degrees(knee.flexion[5]), 2)  # at 5 N m of extension: over-extended
np.float64(-3.72)
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._arguments import choice
from kneecore.errors import ParameterError
from kneecore.knee.file import packaged_knee
from kneecore.knee.parameters import check_physical
from kneecore.knee.physics.dynamics import MOMENTS, flexion_of, respond
from kneecore.knee.physics.equilibrium import settle
from kneecore.knee.physics.marks import at_rest, implausible
from kneecore.knee.physics.observe import observe
from kneecore.knee.physics.pose import ORIGIN_X, ORIGIN_Y, constants, rest_lengths
from kneecore.presented import Presented

__all__ = [
    "LARGEST_EXTENSION",
    "LARGEST_FLEXION",
    "MOMENT",
    "QUANTITIES",
    "Response",
    "ResponseBatch",
    "RestLength",
    "Solver",
    "simulate",
    "simulate_batch",
    "status_text",
]

RestLength = Literal["recomputed", "fixed"]
Solver = Literal["dynamics", "equilibrium"]
FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

MOMENT: FloatArray = np.array([*MOMENTS, *(-m for m in MOMENTS)])
"""The 12 moments in the order of every response, N m: 6 of extension, then 6 of flexion."""
MOMENT.setflags(write=False)


LARGEST_EXTENSION = int(np.argmax(MOMENT))
LARGEST_FLEXION = int(np.argmin(MOMENT))
QUANTITIES = (
    ("tension_n", "tension", 1.0),
    ("contact_force_n", "contact_force", 1.0),
    ("ap_position_mm", "ap_position", 1e3),
)
"""What studies observe beside the angles: name with its unit, field of a response, factor."""


def status_text(refinements: int) -> str:
    """Return `ok`, `refined` or `failed` for a number of step halvings (-1: failed)."""
    return "failed" if refinements < 0 else ("refined" if refinements else "ok")


@dataclass(frozen=True, kw_only=True, eq=False)
class Response(Presented):
    """One knee at the end of each of the 12 loads. A failed model's numbers are NaN."""

    flexion: FloatArray
    """Flexion angle, shape (12,), rad; negative is over-extension."""
    moment: FloatArray
    """External moment, shape (12,), N m; extension positive."""
    tension: FloatArray
    """Ligament tensions, shape (12, 4), N: ACL, PCL, MCL, LCL."""
    contact_force: FloatArray
    """Shape (12,), N."""
    indentation: FloatArray
    """Of the condyle into the plateau, shape (12,), m."""
    ap_position: FloatArray
    """Of the contact along the plateau from its reference point, shape (12,), m; anterior > 0."""
    tibia_position: FloatArray
    """Origin of the tibia in the femur frame, shape (12, 2), m."""
    settled: BoolArray
    """Whether the angle changed by less than 0.2 deg in the load's last 0.5 s, shape (12,); true of
    every equilibrium."""
    refinements: int
    """How often the time step was halved; -1 if the model failed all the same."""
    rest_length: FloatArray
    """Of the four ligaments, shape (4,), m."""
    load_free_position: FloatArray
    """Origin of the tibia in the load-free pose (54.79 deg), shape (2,), m."""
    at_rest: BoolArray | None = None
    """Whether the angle is within 0.1 deg of the equilibrium that the same knee has at that load,
    shape (12,); false where it has none. None if read from a file that does not tell."""
    implausible: BoolArray | None = None
    """Whether the pose is none of a knee: flexion outside -60 to 170 deg, or an indentation above
    half the radius; shape (12,). None if read from a file that does not tell."""
    half_step_change: FloatArray | None = None
    """By how much half the time step moves each angle, shape (12,), rad; None if not asked for."""
    lost_at: float = math.nan
    """Moment (N m, extension positive) at which no equilibrium was left to follow: this response is
    then the dynamics'. NaN if all were found, or never asked for."""

    @property
    def status(self) -> str:
        """`ok`, `refined` (a smaller time step was needed) or `failed`."""
        return status_text(self.refinements)

    @property
    def n_unsettled(self) -> int:
        """Number of loads at which the knee had not come to rest; 0 for a failed model."""
        return 0 if self.refinements < 0 else int(np.count_nonzero(~self.settled))

    @property
    def n_not_at_rest(self) -> int:
        """Number of loads at which the angle is not the equilibrium's; 0 for a failed model."""
        if self.at_rest is None or self.refinements < 0:
            return 0
        return int(np.count_nonzero(~self.at_rest))

    @property
    def n_implausible(self) -> int:
        """Number of loads at which the pose is none of a knee."""
        return 0 if self.implausible is None else int(np.count_nonzero(self.implausible))

    def __repr__(self) -> str:
        angles = ", ".join(f"{a:.2f}" for a in np.degrees(self.flexion))
        return f"Response(status={self.status!r}, flexion in deg: {angles})"


@dataclass(frozen=True, kw_only=True, eq=False)
class ResponseBatch:
    """The responses of n knees; the fields of `Response` with a leading axis n."""

    flexion: FloatArray
    """Shape (n, 12), rad."""
    moment: FloatArray
    """Shape (12,), N m."""
    tension: FloatArray
    """Shape (n, 12, 4), N."""
    contact_force: FloatArray
    """Shape (n, 12), N."""
    indentation: FloatArray
    """Shape (n, 12), m."""
    ap_position: FloatArray
    """Shape (n, 12), m."""
    tibia_position: FloatArray
    """Shape (n, 12, 2), m."""
    settled: BoolArray
    """Shape (n, 12)."""
    at_rest: BoolArray
    """Shape (n, 12)."""
    implausible: BoolArray
    """Shape (n, 12)."""
    refinements: NDArray[np.int8]
    """Shape (n,); -1 for a failed model."""
    rest_length: FloatArray
    """Shape (n, 4), m."""
    load_free_position: FloatArray
    """Shape (n, 2), m."""
    lost_at: FloatArray
    """Shape (n,), N m; NaN where no equilibrium was lost."""

    def __len__(self) -> int:
        return len(self.refinements)

    def __getitem__(self, index: int) -> Response:
        return Response(
            flexion=self.flexion[index],
            moment=self.moment,
            tension=self.tension[index],
            contact_force=self.contact_force[index],
            indentation=self.indentation[index],
            ap_position=self.ap_position[index],
            tibia_position=self.tibia_position[index],
            settled=self.settled[index],
            at_rest=self.at_rest[index],
            implausible=self.implausible[index],
            refinements=int(self.refinements[index]),
            rest_length=self.rest_length[index],
            load_free_position=self.load_free_position[index],
            lost_at=float(self.lost_at[index]),
        )

    def __iter__(self) -> Iterator[Response]:
        return (self[i] for i in range(len(self)))

    @property
    def status(self) -> tuple[str, ...]:
        """`ok`, `refined` or `failed` for each model."""
        return tuple(status_text(int(r)) for r in self.refinements)

    @property
    def failed(self) -> BoolArray:
        """Which models failed, shape (n,)."""
        return self.refinements < 0

    @property
    def n_failed(self) -> int:
        """Number of models that failed."""
        return int(np.count_nonzero(self.failed))

    @property
    def n_lost(self) -> int:
        """Number of models that lost their equilibrium, failed ones included."""
        return int(np.count_nonzero(~np.isnan(self.lost_at)))

    @property
    def n_unsettled(self) -> int:
        """Number of models, failed ones apart, that had not come to rest at some load."""
        return int(np.count_nonzero(~self.settled.all(axis=1) & ~self.failed))

    @property
    def n_not_at_rest(self) -> int:
        """Number of models, failed ones apart, with an angle that is not the equilibrium's."""
        return int(np.count_nonzero(~self.at_rest.all(axis=1) & ~self.failed))

    @property
    def n_implausible(self) -> int:
        """Number of models with a pose that is none of a knee."""
        return int(np.count_nonzero(self.implausible.any(axis=1)))

    def __repr__(self) -> str:
        return (
            f"ResponseBatch({len(self)} models: {self.n_failed} failed, "
            f"{self.n_unsettled} with an unsettled load, {self.n_lost} without an equilibrium)"
        )


def check_solver(solver: Solver) -> Solver:
    """Return `solver`, or raise a `ParameterError` if it is none."""
    return choice("solver", solver, get_args(Solver))


def prepare(
    models: ArrayLike, baseline: ArrayLike | None, rest_length: str, argument: str = "X"
) -> FloatArray:
    """Return the kernels' constants of checked `models`, shape (n, 36)."""
    choice("rest_length", rest_length, get_args(RestLength))
    checked = np.atleast_2d(check_physical(models, argument))
    given = packaged_knee().baseline if baseline is None else baseline
    fixes_pose = check_physical(given, "baseline")
    if fixes_pose.ndim != 1:
        raise ParameterError(f"`baseline` has shape {fixes_pose.shape}; (28,) is allowed")
    return constants(checked, fixes_pose, rest_length == "fixed")


def simulate_batch(
    X: ArrayLike,
    *,
    baseline: ArrayLike | None = None,
    rest_length: RestLength = "recomputed",
    solver: Solver = "dynamics",
    threads: int | None = None,
) -> ResponseBatch:
    """Simulate many knees through the load programme, both directions.

    Parameters
    ----------
    X : array_like, shape (n, 28) or (n, 32)
        Parameter values, SI, in the table's order; 32 with the changes of the rest lengths.
    baseline : array_like, shape (28,), optional
        The knee that fixes the load-free pose; the packaged baseline for None.
    rest_length : {"recomputed", "fixed"}
        Whether each model's ligaments are strain-free in its own load-free pose, or all models
        have the baseline's rest lengths.
    solver : {"dynamics", "equilibrium"}
        Whether to integrate the motion over 23 s, as the paper does, or to solve for the knee at
        rest under each load. A knee that has no equilibrium to follow gets the dynamics' response,
        marked by `lost_at`.
    threads : int, optional
        Threads to use; all cores for None. The numbers do not depend on it.

    Returns
    -------
    ResponseBatch

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    check_solver(solver)
    rows = prepare(X, baseline, rest_length)
    if solver == "equilibrium":
        poses, settled, refinements, lost_at = settle(rows, threads)
        rests, lost = np.ones_like(settled), ~np.isnan(lost_at)
        if lost.any():
            rests[lost] = at_rest(rows[lost], poses[lost], threads)
    else:
        poses, settled, refinements = respond(rows, threads)
        lost_at = np.full(len(rows), np.nan)
        rests = at_rest(rows, poses, threads)
    seen = observe(rows, poses)
    return ResponseBatch(
        flexion=flexion_of(poses),
        moment=MOMENT,
        settled=settled,
        at_rest=rests,
        implausible=implausible(rows, poses, seen["indentation"]),
        refinements=refinements,
        rest_length=rest_lengths(rows),
        load_free_position=rows[:, [ORIGIN_X, ORIGIN_Y]],
        lost_at=lost_at,
        **seen,
    )


def simulate(
    x: ArrayLike,
    *,
    baseline: ArrayLike | None = None,
    rest_length: RestLength = "recomputed",
    solver: Solver = "dynamics",
) -> Response:
    """Simulate one knee through the load programme; `simulate_batch` for one `x` of shape (28,).

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    checked = check_physical(x, "x")
    if checked.ndim != 1:
        raise ParameterError(f"`x` has shape {checked.shape}; (28,) or (32,) is allowed")
    return simulate_batch(checked[None], baseline=baseline, rest_length=rest_length, solver=solver)[
        0
    ]

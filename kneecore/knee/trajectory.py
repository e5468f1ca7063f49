"""The whole motion of one knee through the load programme, for animation and for plots in time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._arguments import whole_number
from kneecore.errors import ModelError, ParameterError
from kneecore.knee.file import packaged_knee
from kneecore.knee.parameters import check_physical
from kneecore.knee.physics.dynamics import MOMENTS, PLATEAU_STEPS, flexion_of, respond_by_run
from kneecore.knee.physics.lanes import TIME_STEP, integrate
from kneecore.knee.physics.observe import observe
from kneecore.knee.physics.pose import START_X, START_Y
from kneecore.knee.response import RestLength, prepare

__all__ = ["Trajectory", "compile_motion", "trajectory"]

FloatArray = NDArray[np.float64]
_ALLOWED_STEPS = (1, 2, 5, 10, 25, 50, 125, 250)


@dataclass(frozen=True, kw_only=True, eq=False)
class Trajectory:
    """One knee in time. The first axis of length 2 is the direction: extension, flexion."""

    time: FloatArray
    """Shape (n,), s; the load-free pose at 0."""
    moment: FloatArray
    """In force in the step that led to each frame, shape (2, n), N m; 0 at the first."""
    flexion: FloatArray
    """Shape (2, n), rad."""
    tibia_position: FloatArray
    """Origin of the tibia in the femur frame, shape (2, n, 2), m."""
    tension: FloatArray
    """ACL, PCL, MCL, LCL, shape (2, n, 4), N."""
    contact_force: FloatArray
    """Shape (2, n), N."""
    indentation: FloatArray
    """Shape (2, n), m."""
    ap_position: FloatArray
    """Shape (2, n), m."""

    def __repr__(self) -> str:
        return f"Trajectory({len(self.time)} frames in 2 directions, 0 to {self.time[-1]:g} s)"


def trajectory(
    x: ArrayLike,
    *,
    baseline: ArrayLike | None = None,
    rest_length: RestLength = "recomputed",
    frame_steps: int = 10,
) -> Trajectory:
    """Return the whole motion of one knee in both directions.

    Parameters
    ----------
    x, baseline, rest_length
        As for `simulate`.
    frame_steps : int
        Time steps of 4 ms between frames; a divisor of 250, 10 (0.04 s) by default.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    ModelError
        If the model fails, whatever the time step.
    """
    allowed = f"one of {', '.join(map(str, _ALLOWED_STEPS))}"
    frame_steps = whole_number("frame_steps", frame_steps, 1, max(_ALLOWED_STEPS), allowed)
    if frame_steps not in _ALLOWED_STEPS:
        raise ParameterError(f"`frame_steps` is {frame_steps}; {allowed} is allowed")
    checked = check_physical(x, "x")
    if checked.ndim != 1:
        raise ParameterError(f"`x` has shape {checked.shape}; (28,) or (32,) is allowed")
    rows = prepare(checked, baseline, rest_length, "x")
    halvings = respond_by_run(rows)[2][0]
    if halvings.min() < 0:
        raise ModelError("the model fails: it dislocates, or rings however small the time step")
    sizes = np.repeat(np.array(MOMENTS), np.array(PLATEAU_STEPS) // frame_steps)
    steps = np.full(len(sizes), frame_steps)
    states = np.empty((2, len(steps), 6))
    # Each run with its own time step, so that it ends bit by bit where the response is read.
    for refinements in np.unique(halvings):
        runs = np.flatnonzero(halvings == refinements)
        states[runs], _ = integrate(rows, runs, steps, sizes, refinements=int(refinements))
    start = np.broadcast_to([rows[0, START_X], rows[0, START_Y], 0.0], (2, 1, 3))
    poses = np.concatenate([start, states[:, :, :3]], axis=1)
    moment = np.concatenate([[0.0], sizes])
    return Trajectory(
        time=np.arange(len(moment), dtype=np.float64) * (frame_steps * TIME_STEP),
        moment=np.stack([moment, -moment]),
        flexion=flexion_of(poses),
        **observe(np.repeat(rows, 2, axis=0), poses),
    )


def compile_motion() -> None:
    """Compile what moves a knee."""
    trajectory(packaged_knee().baseline)

"""Where the knees on screen are: the visitor's and both worst cases, all at one moment."""

from kneecore import Trajectory
from kneeviz.geometry.mechanism import Pose
from kneeviz.geometry.sweep import pose_in_time
from kneeviz.state import results
from kneeviz.state.knee import KneeState, Solved
from kneeviz.state.playback import Playback

Knees = tuple[Solved | None, Solved | None, Solved | None]
"""The visitor's knee, worst case 1 and 2; None for what is not shown."""
Poses = tuple[Pose | None, Pose | None, Pose | None]
Runs = tuple[Trajectory | None, Trajectory | None, Trajectory | None]


class Motion:
    """The knees' poses. Runs in time are computed once and kept until they are forgotten."""

    def __init__(self) -> None:
        self._runs: Runs | None = None

    def forget(self) -> None:
        """Compute the runs in time anew: the knees have changed."""
        self._runs = None

    def poses(self, state: KneeState, knees: Knees, playback: Playback) -> Poses:
        """Return the poses of `knees` where `playback` is; none at all without a visitor's knee."""
        current = state.current
        if current is None or current.sweep is None:
            return None, None, None
        if playback.mode == "sweep":
            moment = current.sweep.moment_at(playback.share)
            one, two, three = (
                None if k is None or k.sweep is None else k.sweep.at_moment(moment) for k in knees
            )
            return one, two, three
        if self._runs is None:
            self._runs = runs_in_time(state, knees)
        direction = 0 if playback.mode == "extension" else 1
        one, two, three = (
            None if r is None else pose_in_time(r, direction, playback.share * r.time[-1])
            for r in self._runs
        )
        return one, two, three


def runs_in_time(state: KneeState, knees: Knees) -> Runs:
    """Return the motions in time of the visitor's knee and the two worst cases."""
    current, *worst = knees
    one, two = (
        None
        if knee is None or knee.sweep is None or state.result is None
        else results.motion(state.result, knee.x)
        for knee in worst
    )
    return None if current is None else state.trajectory(current.x), one, two

"""A knee's motion as something to play: through the loads, or in time. Pure functions.

kneecore gives the knee at twelve loads and its load-free pose. Between neighbouring loads the
screen interpolates linearly in the moment: angle, tensions and the contact's coordinates, so that
the drawn circle stays on the drawn plateau. In time, kneecore's own frames are shown.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore import Response, Trajectory
from kneecore.knee.physics.forces import THETA_0
from kneeviz.geometry.mechanism import Pose, contact_coordinates, tibia_at_contact

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Sweep:
    """One knee through the loads, from full extension (+5 N m) to full flexion (-5 N m)."""

    x: FloatArray
    """Parameter values, shape (28,), SI."""
    moment: FloatArray
    """Falling, shape (k,), N m."""
    flexion: FloatArray
    """Shape (k,), rad."""
    along: FloatArray
    """Contact along the plateau, shape (k,), m."""
    depth: FloatArray
    """Indentation, shape (k,), m."""
    tension: FloatArray
    """Shape (k, 4), N."""
    contact_force: FloatArray
    """Shape (k,), N."""

    def at_moment(self, moment: float) -> Pose:
        """Return the pose under `moment` (N m), held at the ends beyond 5 N m."""
        rising = -self.moment  # np.interp wants it so
        flexion, along, depth, force = (
            float(np.interp(-moment, rising, values))
            for values in (self.flexion, self.along, self.depth, self.contact_force)
        )
        return Pose(
            flexion=flexion,
            moment=moment,
            tibia_position=tibia_at_contact(self.x, flexion, along, depth),
            tension=np.array([np.interp(-moment, rising, self.tension[:, i]) for i in range(4)]),
            contact_force=force,
        )

    @property
    def _shares(self) -> FloatArray:
        """Shares of the way at the corners, shape (k,), rising."""
        way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(self.flexion)) + 1e-9)])
        shares: FloatArray = way / way[-1]
        return shares

    def moment_at(self, share: float) -> float:
        """Return the moment at a share in [0, 1] of the way; equal shares turn equal angles."""
        return float(np.interp(share, self._shares, self.moment))

    def share_at(self, moment: float) -> float:
        """Return the share of the way at which `moment` acts: `moment_at` turned round."""
        return float(np.interp(-moment, -self.moment, self._shares))

    def share_bent(self, flexion: float) -> float:
        """Return the share of the way at which the knee is bent by `flexion`, rad."""
        order = np.argsort(self.flexion, kind="stable")
        return float(np.interp(flexion, self.flexion[order], self._shares[order]))


def sweep_of(x: FloatArray, response: Response, *, strain_free: bool = True) -> Sweep | None:
    """Return the sweep of a knee, or None if its model failed.

    Parameters
    ----------
    x : ndarray, shape (28,)
        Parameter values, SI.
    response : Response
        kneecore's answer for `x`.
    strain_free : bool
        Whether the load-free pose is the equilibrium without load, so that it belongs to the
        sweep; with fixed rest lengths it is only where the runs start.
    """
    if response.refinements < 0:
        return None
    order = [5, 4, 3, 2, 1, 0, 6, 7, 8, 9, 10, 11]
    moment, flexion = response.moment[order], response.flexion[order]
    origin, tension = response.tibia_position[order], response.tension[order]
    force = response.contact_force[order]
    if strain_free:
        moment, flexion = np.insert(moment, 6, 0.0), np.insert(flexion, 6, THETA_0)
        origin = np.insert(origin, 6, response.load_free_position, axis=0)
        tension, force = np.insert(tension, 6, 0.0, axis=0), np.insert(force, 6, 0.0)
    contact = np.array([contact_coordinates(x, t, o) for t, o in zip(flexion, origin, strict=True)])
    return Sweep(
        x=np.array(x, dtype=np.float64),
        moment=moment,
        flexion=flexion,
        along=contact[:, 0],
        depth=contact[:, 1],
        tension=tension,
        contact_force=force,
    )


def pose_in_time(run: Trajectory, direction: int, time: float) -> Pose:
    """Return the pose of a run at `time` (s), between frames by linear interpolation.

    Parameters
    ----------
    run : Trajectory
    direction : int
        0 for the extension run, 1 for the flexion run.
    time : float
        Held at the run's ends.
    """
    at = np.clip(time / run.time[-1], 0.0, 1.0) * (len(run.time) - 1)
    left = min(int(at), len(run.time) - 2)
    part = float(at - left)

    def between(values: FloatArray) -> FloatArray:
        both = values[direction, left : left + 2]
        mean: FloatArray = (1.0 - part) * both[0] + part * both[1]
        return mean

    return Pose(
        flexion=float(between(run.flexion)),
        moment=float(run.moment[direction, left + 1]),
        tibia_position=between(run.tibia_position),
        tension=between(run.tension),
        contact_force=float(between(run.contact_force)),
        time=float(run.time[0] + at * (run.time[1] - run.time[0])),
    )

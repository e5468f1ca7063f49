"""The knee at rest as an exact search sees it: weighted sums of the angles with their gradients."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kneecore._threads import run_all, thread_count
from kneecore.knee.gradient import weighted_gradients
from kneecore.knee.physics.dynamics import flexion_of
from kneecore.knee.physics.equilibrium import equilibria
from kneecore.knee.response import RestLength, prepare
from kneecore.knee.space import ParameterSpace

__all__ = ["SettledKnee"]

FloatArray = NDArray[np.float64]


@dataclass(eq=False)
class SettledKnee:
    """Slopes (see `kneecore.numerics.box_climb`) of a space's knees in equilibrium, in deg.

    A knee that has lost its equilibrium counts as a failure. It counts `n_simulated` and `n_lost`.
    """

    space: ParameterSpace
    rest_length: RestLength = "recomputed"
    threads: int | None = None
    n_simulated: int = field(default=0, init=False)
    n_lost: int = field(default=0, init=False)

    def __call__(
        self, u: FloatArray, weights: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the values of sum w y, their gradients and y of `u`, shape (n, n_free)."""
        space = self.space
        x = space.from_free_unit(u)
        rows = prepare(x, space.baseline, self.rest_length)
        poses, lost_at = equilibria(rows, self.threads)
        gradients = np.empty((len(x), 1, x.shape[1]))
        fixed = self.rest_length == "fixed"
        centre = space.baseline.copy()  # a read-only array would be compiled for once more
        each = np.ascontiguousarray(weights[:, None, :])
        size = max(64, -(-len(x) // (2 * thread_count(self.threads))))

        def work(first: int) -> None:
            k = slice(first, first + size)
            weighted_gradients(x[k], rows[k], poses[k], centre, fixed, each[k], gradients[k])

        run_all(work, range(0, len(x), size), self.threads)
        self.n_simulated += len(x)
        self.n_lost += int(np.count_nonzero(~np.isnan(lost_at)))
        y = np.degrees(flexion_of(poses))
        values = (weights * y).sum(axis=1)
        width = np.degrees(space.upper - space.lower)[space.free]
        slopes = np.where(np.isnan(gradients[:, 0]), 0.0, gradients[:, 0])[:, space.free] * width
        return np.where(np.isnan(values), -np.inf, values), slopes, y

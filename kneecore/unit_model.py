"""A model on the unit cube of its free inputs: what searches and studies see of it."""

import numpy as np
from numpy.typing import NDArray

from kneecore.model import Model

__all__ = ["UnitModel"]

FloatArray = NDArray[np.float64]


class UnitModel:
    """A model on the unit cube of its free inputs, which counts its runs.

    Attributes
    ----------
    model : Model
    n_simulated : int
        Runs so far.
    counts : dict
        What became of them, by `Model.count_names`.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.n_simulated = 0
        self.counts = dict.fromkeys(model.count_names, 0)

    def __call__(self, u: FloatArray) -> FloatArray:
        """Return outputs of points, shape (n, n_free) -> (n, m)."""
        done = self.model.examine(self.model.from_free_unit(u))
        self.n_simulated += len(u)
        for name, count in done.counts.items():
            self.counts[name] += count
        return done.y

    def copy(self) -> "UnitModel":
        """Return one that goes on counting by itself."""
        copied = UnitModel(self.model)
        copied.n_simulated, copied.counts = self.n_simulated, dict(self.counts)
        return copied

    @property
    def told(self) -> dict[str, int]:
        """The counts as results have them."""
        return {
            "models_simulated": self.n_simulated,
            **{f"models_{name}": count for name, count in self.counts.items()},
        }

"""A model on the unit cube of its free inputs: what searches and studies see of it."""

import numpy as np
from numpy.typing import NDArray

from kneecore.model import Model
from kneecore.record import Arrays, current_record

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
    seconds_before : float
        What a search took that was stopped and then went on.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.n_simulated = 0
        self.seconds_before = 0.0
        self.counts = dict.fromkeys(model.count_names, 0)

    def __call__(self, u: FloatArray) -> FloatArray:
        """Return outputs of points, shape (n, n_free) -> (n, m)."""
        x, record = self.model.from_free_unit(u), current_record()
        if record is None:
            done = self._run(x)
        else:
            done = record.run("runs", self.model.identity, {"x": x}, lambda: self._run(x))
        self.n_simulated += len(u)
        for name, count in zip(self.counts, done["counts"], strict=True):
            self.counts[name] += int(count)
        y: FloatArray = np.asarray(done["y"], dtype=np.float64)
        return y

    def _run(self, x: FloatArray) -> Arrays:
        done = self.model.examine(x)
        counts = [done.counts.get(name, 0) for name in self.counts]
        return {"y": done.y, "counts": np.array(counts, dtype=np.int64)}

    @property
    def told(self) -> dict[str, int]:
        """The counts as results have them."""
        return {
            "models_simulated": self.n_simulated,
            **{f"models_{name}": count for name, count in self.counts.items()},
        }

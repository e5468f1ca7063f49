"""A model on the unit cube of its free inputs: what searches and studies see of it."""

import numpy as np
from numpy.typing import NDArray

from kneecore.model import Model
from kneecore.progress import Cancelled
from kneecore.record import Arrays, current_record
from kneecore.runs.evaluation import Watch

__all__ = ["UnitModel"]

FloatArray = NDArray[np.float64]


class UnitModel:
    """A model on the unit cube of its free inputs, which counts its runs.

    Parameters
    ----------
    model : Model
    drawn : bool
        Whether the unit cube is that of the inputs' distributions (`Model.drawn`), not of their
        bounds.
    every_mark : bool
        Whether marks are counted too that cost some per cent more: a search does without.

    Attributes
    ----------
    model : Model
    drawn : bool
    n_simulated : int
        Runs so far.
    counts : dict
        What became of them, by `Model.count_names`.
    seconds_before : float
        What a search took that was stopped and then went on.
    """

    def __init__(self, model: Model, *, drawn: bool = False, every_mark: bool = False) -> None:
        self.model, self.drawn = model, drawn
        self._every_mark = every_mark
        self.n_simulated = 0
        self.seconds_before = 0.0
        self.counts = dict.fromkeys(model.count_names, 0)

    def __call__(self, u: FloatArray, watch: Watch | None = None) -> FloatArray:
        """Return outputs of points, shape (n, n_free) -> (n, m).

        `watch` gets the number of runs done, now and then; a true result cancels (raises
        `Cancelled`).
        """
        x = self.model.drawn(u) if self.drawn else self.model.from_free_unit(u)
        record = current_record()
        if record is None:
            done = self._run(x, watch)
        else:
            done = record.run("runs", self.model.identity, {"x": x}, lambda: self._run(x, watch))
        self.n_simulated += len(u)
        for name, count in done.items():
            if name != "y":
                self.counts[name] = self.counts.get(name, 0) + int(count)
        y: FloatArray = np.asarray(done["y"], dtype=np.float64)
        return y

    def _run(self, x: FloatArray, watch: Watch | None) -> Arrays:
        # As a stream, for a model that examines in a way of its own need not know of a watch.
        done = next(self.model.stream([x], observe=self._every_mark, watch=watch), None)
        if done is None or len(done.y) < len(x):
            raise Cancelled
        return {"y": done.y, **{name: np.array(n) for name, n in done.counts.items()}}

    def copy(self) -> "UnitModel":
        """Return one that goes on counting by itself."""
        copied = UnitModel(self.model, drawn=self.drawn, every_mark=self._every_mark)
        copied.n_simulated, copied.counts = self.n_simulated, dict(self.counts)
        return copied

    @property
    def told(self) -> dict[str, int]:
        """The counts as results have them."""
        return {
            "models_simulated": self.n_simulated,
            **{f"models_{name}": count for name, count in self.counts.items()},
        }

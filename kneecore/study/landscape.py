"""A slice of a model: its outputs over two inputs, the others held.

The true model's outputs and, beside them, a surrogate's.

Examples
--------
>>> import kneecore
>>> slice_ = kneecore.landscape(kneecore.Knee(), ("condyle_x", "pcl_femur_x"), n_points=5)
>>> slice_.y.shape
(5, 5, 12)
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._arguments import callback_or_none, shown
from kneecore._version import versions
from kneecore.budget import check_budget
from kneecore.errors import ParameterError
from kneecore.model import Model
from kneecore.numerics.sampling_options import check_count
from kneecore.presented import Presented
from kneecore.progress import Callback, Cancelled, Clock, Progress
from kneecore.search.arguments import check_model
from kneecore.search.training import TrainedSurrogate
from kneecore.study.budget import grid_budget
from kneecore.study.partial import count_partial

__all__ = ["Landscape", "landscape"]

FloatArray = NDArray[np.float64]
BATCH = 512
"""Models that are run between two reports."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Landscape(Presented):
    """The m outputs over a grid of two inputs."""

    model: Model
    """What was run. Read from a file, a model that is no knee has no function."""
    names: tuple[str, str]
    """The two inputs."""
    x: FloatArray
    """The point whose other values are held, shape (d,)."""
    axes: tuple[FloatArray, FloatArray]
    """The two inputs' values from bound to bound, shapes (n,) and (k,): as many as were asked for,
    or fewer where fewer are allowed."""
    y: FloatArray
    """The true model's outputs, shape (n, k, m), the first input along the first axis; NaN where
    the model failed."""
    y_surrogate: FloatArray | None
    """The surrogate's outputs, shape (n, k, m), or None where there is no surrogate."""
    counts: Mapping[str, int]
    """Models of the grid by what became of them, as in `MonteCarloResult`; empty where an older
    file did not tell."""
    versions: dict[str, str]

    @property
    def n_models(self) -> int:
        """Number of models that were run."""
        return int(self.y[..., 0].size)

    @property
    def n_failed(self) -> int:
        """Number of models that failed in all outputs; one that failed costs a hole in its own."""
        return int(np.count_nonzero(~np.isfinite(self.y).any(axis=-1)))

    @property
    def error(self) -> FloatArray | None:
        """Surrogate less true model, shape (n, k, m); NaN where the model failed."""
        return None if self.y_surrogate is None else self.y_surrogate - self.y


def _places(names: Any, model: Model) -> tuple[int, int]:
    """Return where the two inputs stand."""
    free = model.free_names
    listed = isinstance(names, Sequence) and not isinstance(names, str)
    texts = listed and all(isinstance(name, str) for name in names)
    if not texts or len(names) != 2 or names[0] == names[1] or not set(names) <= set(free):
        told = shown(tuple(names) if listed else names)
        raise ParameterError(
            f"`names` is {told}; two different of the free inputs are allowed: {', '.join(free)}"
        )
    return model.names.index(names[0]), model.names.index(names[1])


def _run(
    model: Model, points: FloatArray, callback: Callback | None
) -> tuple[FloatArray, dict[str, int]]:
    """Run a model for points (n, d), with a report after every few; count what became of them."""
    clock, total = Clock(), len(points)

    def watch(done: int) -> object:
        left = clock.left(done, total - done)
        report = Progress(stage="sampling", done=done, total=total, seconds_left=left)
        return callback is not None and callback(report)

    if watch(0):
        raise Cancelled
    batches = (points[first : first + BATCH] for first in range(0, len(points), BATCH))
    counts: Counter[str] = Counter()
    parts = []
    for done in model.stream(batches, observe=True, watch=watch):
        parts.append(done.y)
        counts.update(done.counts)
        count_partial(counts, done.y)
    if sum(map(len, parts)) < len(points):
        raise Cancelled
    watch(len(points))
    return np.concatenate(parts), dict(counts)


def landscape(
    model: Model,
    names: Sequence[str],
    *,
    x: ArrayLike | None = None,
    surrogate: TrainedSurrogate | None = None,
    n_points: int = 33,
    callback: Callback | None = None,
) -> Landscape:
    """Run a grid of models that differ from `x` in two inputs only.

    Parameters
    ----------
    model : Model
        Its bounds are the ends of the grid.
    names : sequence of 2 str
        The two inputs; they must be free.
    x : array_like, shape (d,), optional
        The point around which the slice is laid; the nominal one for None.
    surrogate : TrainedSurrogate, optional
        To be evaluated on the same grid.
    n_points : int
        Grid points along each input, at least 2; fewer where there are fewer values.
    callback : callable, optional
        Gets `Progress`; a true result cancels (raises `Cancelled`).

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    check_model(model)
    callback_or_none(callback)
    first, second = _places(names, model)
    centre = model.point(model.nominal if x is None else x)
    model.check_allowed(centre)
    if check_count("n_points", n_points) < 2:
        raise ParameterError(f"`n_points` is {n_points}; at least 2 are allowed")
    check_budget(grid_budget(n_points, model))
    if surrogate is not None and not isinstance(surrogate, TrainedSurrogate):
        raise ParameterError(
            f"`surrogate` is {shown(surrogate)}; what kneecore.fit_surrogate returns is allowed"
        )
    axes = [model.values_along(i, n_points) for i in (first, second)]
    points = np.tile(centre, (len(axes[0]), len(axes[1]), 1))
    points[..., first], points[..., second] = axes[0][:, None], axes[1][None, :]
    flat = points.reshape(-1, len(centre))
    shape = (*points.shape[:2], model.n_outputs)
    y, counts = _run(model, flat, callback)
    return Landscape(
        model=model,
        names=(names[0], names[1]),
        x=centre,
        axes=(axes[0], axes[1]),
        y=y.reshape(shape),
        y_surrogate=None if surrogate is None else surrogate.predict(flat).reshape(shape),
        counts=counts,
        versions=versions(),
    )

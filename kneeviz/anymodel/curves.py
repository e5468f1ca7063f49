"""From outputs to what charts draw: curves over an output's axis, and single numbers. Pure."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore import Model, Output
from kneeviz.anymodel.state import ModelState

FloatArray = NDArray[np.float64]

MOST_POINTS = 600
"""Points of a curve that are sent to a browser."""
_DECADES = 2.0
"""An axis that spans so many powers of ten is drawn by them."""
_SPARE = 0.06
"""Of a chart's height, above and below what is drawn."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Curves:
    """What is known of all outputs, shape (m,) each; None for what is not known or not shown."""

    low: FloatArray | None
    """The sampled band's edges."""
    high: FloatArray | None
    nominal: FloatArray | None
    own: FloatArray | None
    """The model, for the sliders' point."""
    predicted: FloatArray | None
    """The surrogate, for the same point."""
    one: FloatArray | None
    """Worst model 1."""
    two: FloatArray | None
    last: FloatArray | None
    """The last run of a model that is too slow to follow the sliders."""

    @property
    def lines(self) -> tuple[FloatArray | None, ...]:
        """All of them, in the order in which they are drawn."""
        return (
            self.low, self.high, self.nominal, self.own, self.predicted, self.one, self.two,
            self.last,
        )  # fmt: skip

    @property
    def known(self) -> list[FloatArray]:
        """Those that are known."""
        return [line for line in self.lines if line is not None]


def curves_of(state: ModelState) -> Curves:
    """Return what a page's charts show now."""
    result = state.result if state.overlay else None
    sampled = state.sampled if state.band else None
    last = None if state.last is None else state.last.y
    return Curves(
        low=None if sampled is None else sampled.y.percentile_lower,
        high=None if sampled is None else sampled.y.percentile_upper,
        nominal=state.nominal,
        own=None if state.slow else last,
        predicted=state.predicted,
        one=None if result is None else result.y[0],
        two=None if result is None else result.y[1],
        last=last if state.slow else None,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Place:
    """Where an output's numbers stand among the model's, and on its axis."""

    output: Output
    columns: NDArray[np.int64]
    """Those that are drawn, in the order of the axis."""
    axis: FloatArray
    """Rising."""

    @property
    def logarithmic(self) -> bool:
        """Whether the axis is better drawn by powers of ten."""
        low, high = float(self.axis[0]), float(self.axis[-1])
        return low > 0.0 and math.log10(high / low) >= _DECADES


def places(model: Model) -> tuple[list[Place], list[int]]:
    """Return the outputs that are curves, and the columns of those that are single numbers."""
    curves, single, first = [], [], 0
    for output in model.outputs:
        columns = np.arange(first, first + output.n_columns)
        first += output.n_columns
        axis = np.zeros(1) if output.axis is None else np.array(output.axis)
        order = np.argsort(axis, kind="stable")
        if len(np.unique(axis)) < 2:
            single += columns.tolist()
            continue
        if len(order) > MOST_POINTS:
            order = order[np.linspace(0, len(order) - 1, MOST_POINTS).round().astype(int)]
        curves.append(Place(output=output, columns=columns[order], axis=axis[order]))
    return curves, single


def span(values: Sequence[FloatArray]) -> tuple[float, float] | None:
    """Return a range that holds all values, with some room; None without any."""
    every = np.concatenate([np.asarray(v).ravel() for v in values] or [np.zeros(0)])
    every = every[np.isfinite(every)]
    if not len(every):
        return None
    low, high = float(every.min()), float(every.max())
    room = _SPARE * (high - low) or 0.5 * abs(high) * _SPARE or 1.0
    return low - room, high + room


def kept_span(
    old: tuple[float, float] | None, needed: tuple[float, float] | None
) -> tuple[float, float]:
    """Return the old range while it serves: a new one makes a new chart, so rarely."""
    if needed is None:
        return old or (0.0, 1.0)
    if old is None:
        return needed
    holds = old[0] <= needed[0] and needed[1] <= old[1]
    if holds and old[1] - old[0] <= 4.0 * (needed[1] - needed[0]):
        return old
    spare = 0.1 * (needed[1] - needed[0])
    return needed[0] - spare, needed[1] + spare

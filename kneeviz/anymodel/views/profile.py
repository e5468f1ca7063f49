"""A single number over one input, where no output is a curve: the surrogate's line, and dots."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneeviz.anymodel import curves
from kneeviz.anymodel.curves import Curves
from kneeviz.anymodel.dials import Dial
from kneeviz.anymodel.state import ModelState
from kneeviz.jobs.messages import Post
from kneeviz.views import theme
from kneeviz.views.charts.styles import axis_style, axis_told, line_style, switched, told
from kneeviz.views.tabs.events import on_value

FloatArray = NDArray[np.float64]

_POINTS = 81
_HEIGHT = 400


def along(state: ModelState, one: Dial) -> tuple[FloatArray, FloatArray | None]:
    """Return points along an input, the others as the sliders are, and the surrogate there.

    Returns
    -------
    tuple of ndarray
        The input, shape (n,), in the unit shown; the surrogate's output that was chosen, (n,).
    """
    x = np.tile(state.x, (_POINTS, 1))
    x[:, one.index] = np.linspace(one.lower, one.upper, _POINTS)
    y = None if state.surrogate is None else state.surrogate.predict(x)[:, state.column]
    return x[:, one.index] / one.scale, y


class ProfileChart:
    """One number over one input, both to be chosen."""

    def __init__(
        self, gui: Any, post: Post, colours: theme.Palette, state: ModelState, labels: Any
    ) -> None:
        self._colours, self._state = colours, state
        self._range: tuple[float, float] | None = None
        self.column = gui.add_dropdown("Output", labels, visible=len(labels) > 1)
        names = tuple(one.name for one in state.dials)
        self.input = gui.add_dropdown(
            "Along", names, hint="The other inputs stay as the sliders are."
        )
        axis, _ = along(state, self._dial)
        self.handle = gui.add_uplot(
            data=(axis, *(np.zeros(len(axis)) for _ in range(4))),
            series=tuple(self._series()),
            scales=self._scales((0.0, 1.0)),
            axes=self._axes(),
            legend={"show": False},
            cursor={"points": {"show": False}, "drag": {"x": False, "y": False}},
            padding=(8, 14, 0, 0),
            height=_HEIGHT,
        )
        on_value(self.column, post, "column")
        on_value(self.input, post, "chart")

    @property
    def _dial(self) -> Dial:
        return next(one for one in self._state.dials if one.name == self.input.value)

    def _series(self) -> list[dict[str, Any]]:
        c, one, column = self._colours, self._dial, self._state.model.columns[self._state.column]
        dots = [
            switched(
                {
                    "stroke": h,
                    "width": 0,
                    "points": {"show": True, "size": 10, "fill": h, "space": 0},
                },
                key,
            )
            for h, key in ((c.current, "current"), (c.model_1, "model_1"), (c.model_2, "model_2"))
        ]
        line = line_style(c.surrogate, 2.0, dash=(7, 5))
        unit = column.output.unit
        return [
            axis_told(one.label, "", None),
            told(line, "surrogate", "surrogate", unit, None),
            *dots,
        ]

    def _scales(self, span: tuple[float, float]) -> dict[str, Any]:
        one = self._dial
        ends = one.lower / one.scale, one.upper / one.scale
        return {"x": {"time": False, "range": ends}, "y": {"range": span}}

    def _axes(self) -> tuple[dict[str, Any], ...]:
        column = self._state.model.columns[self._state.column]
        upright = f"{column.title} ({column.output.unit})" if column.output.unit else column.title
        return (
            axis_style(self._dial.label, side=2, scale="x", size=30, colours=self._colours),
            axis_style(upright, side=3, scale="y", size=52, colours=self._colours),
        )

    def repaint(self, colours: theme.Palette) -> None:
        """Take the colours of a theme."""
        self._colours = colours
        self.handle.series = tuple(self._series())
        self.handle.axes = self._axes()

    def update(self, shown: Curves) -> None:
        """Draw the line and the points that are known."""
        one = self._dial
        axes = self._axes()
        if tuple(self.handle.axes) != axes:
            self.handle.axes, self._range = axes, None
            self.handle.series = tuple(self._series())
        axis, line = along(self._state, one)
        dots = self._dots(shown, one)
        every = np.unique(np.concatenate([axis, [x for x, _ in dots if np.isfinite(x)]]))
        nothing = np.full(len(every), np.nan)
        drawn = [nothing if line is None else np.interp(every, axis, line)]
        drawn += [np.where(every == x, y, np.nan) for x, y in dots]
        span = curves.kept_span(self._range, curves.span(drawn))
        if span != self._range:
            self._range = span
            self.handle.scales = self._scales(span)
        self.handle.data = (every, *drawn)

    def _dots(self, shown: Curves, one: Dial) -> list[tuple[float, float]]:
        """Return the last run and both worst models, (input, output) each; NaN if not known."""
        state = self._state
        own = shown.last if shown.own is None else shown.own
        xs = [None if state.last is None else state.last.x, None, None]
        if state.result is not None:
            xs[1:] = list(state.result.x)
        return [
            (np.nan, np.nan)
            if x is None or y is None
            else (float(x[one.index]) / one.scale, float(y[state.column]))
            for x, y in zip(xs, (own, shown.one, shown.two), strict=True)
        ]

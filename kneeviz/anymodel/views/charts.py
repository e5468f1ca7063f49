"""The outputs that are curves, each in a chart of its own."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneeviz.anymodel import curves
from kneeviz.anymodel.curves import Curves, Place
from kneeviz.views import theme
from kneeviz.views.charts.styles import axis_style, axis_told, knee_lines, line_style, told

FloatArray = NDArray[np.float64]

MOST_AT_ONCE = 3
"""Charts that stand below one another; of more, one is shown at a time."""
_HEIGHTS = {1: 400, 2: 235, 3: 170}


class OutputChart:
    """One output over its axis."""

    def __init__(self, gui: Any, colours: theme.Palette, place: Place, *, height: int) -> None:
        self._colours, self._place = colours, place
        self._range: tuple[float, float] | None = None
        nothing = np.zeros(len(place.axis))
        self.handle = gui.add_uplot(
            data=(place.axis, *(nothing for _ in self._series()[1:])),
            series=tuple(self._series()),
            scales=self._scales((0.0, 1.0)),
            axes=self._axes(),
            bands=self._bands(),
            legend={"show": False},
            cursor={"points": {"show": False}, "drag": {"x": False, "y": False}},
            padding=(8, 22, 0, 0),
            height=height,
        )

    def _series(self) -> list[dict[str, Any]]:
        c, output = self._colours, self._place.output
        unit = output.unit
        nominal, own, one, two = knee_lines(c, unit, None, called=("nominal", "model"))
        edge = line_style(c.band_edge, 1.0)
        surrogate = line_style(c.surrogate, 2.0, dash=(7, 5))
        dots = {
            "stroke": c.current,
            "width": 0,
            "points": {"show": True, "size": 6, "fill": c.current, "space": 0},
        }
        return [
            axis_told(output.axis_name or "axis", output.axis_unit, None),
            told(edge, "band", "band from", unit, None),
            told(edge, "band", "band to", unit, None),
            nominal,
            own,
            told(surrogate, "surrogate", "surrogate", unit, None),
            one,
            two,
            told(dots, "current", "last run", unit, None),
        ]

    def _bands(self) -> tuple[dict[str, Any], ...]:
        return ({"series": (2, 1), "fill": self._colours.band},)

    def _scales(self, span: tuple[float, float]) -> dict[str, Any]:
        # A range of its own: a chart that is made anew twice in a moment forgets to look for one.
        low, high = float(self._place.axis[0]), float(self._place.axis[-1])
        x: dict[str, Any] = {"time": False, "range": (low, high)}
        if self._place.logarithmic:
            x |= {"distr": 3, "log": 10}
        return {"x": x, "y": {"range": span}}

    def _axes(self) -> tuple[dict[str, Any], ...]:
        c, output = self._colours, self._place.output
        return (
            axis_style(
                with_unit(output.axis_name or "axis", output.axis_unit),
                side=2, scale="x", size=30, colours=c,
            ),
            axis_style(
                with_unit(output.name, output.unit), side=3, scale="y", size=52, colours=c
            ),
        )  # fmt: skip

    def repaint(self, colours: theme.Palette) -> None:
        """Take the colours of a theme."""
        self._colours = colours
        self.handle.series = tuple(self._series())
        self.handle.bands = self._bands()
        self.handle.axes = self._axes()

    def update(self, shown: Curves) -> None:
        """Draw what is known of the output."""
        columns = self._place.columns
        lines = [None if v is None else v[columns] for v in shown.lines]
        span = curves.kept_span(self._range, curves.span([v for v in lines if v is not None]))
        if span != self._range:
            self._range = span
            self.handle.scales = self._scales(span)
        nothing = np.full(len(columns), np.nan)
        self.handle.data = (self._place.axis, *(nothing if v is None else v for v in lines))


class Charts:
    """All of them."""

    def __init__(self, gui: Any, colours: theme.Palette, shown: list[Place], *, wide: bool) -> None:
        many = len(shown) > MOST_AT_ONCE
        height = _HEIGHTS[1] if many or not shown else _HEIGHTS[len(shown)]
        names = tuple(place.output.name for place in shown)
        self.choice = gui.add_dropdown("Output", names) if many else None
        height += 40 if wide else 0
        self.charts = [OutputChart(gui, colours, place, height=height) for place in shown]
        self._names = names
        self.show_chosen()

    def show_chosen(self) -> None:
        """Show the chart that was chosen, where one is shown at a time."""
        if self.choice is None:
            return
        for name, chart in zip(self._names, self.charts, strict=True):
            chart.handle.visible = name == self.choice.value


def with_unit(name: str, unit: str) -> str:
    """Return a name with its unit in brackets."""
    return f"{name} ({unit})" if unit else name

"""The moment-angle chart: created once, then fed with new numbers."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneeviz.geometry.sweep import Sweep
from kneeviz.state.ghosts import MOST
from kneeviz.state.shown import Markers, Shown
from kneeviz.views import theme
from kneeviz.views.charts import series
from kneeviz.views.charts.styles import (
    axis_style,
    axis_told,
    dots,
    knee_lines,
    line_style,
    switched,
    told,
)

FloatArray = NDArray[np.float64]


class CurveChart:
    """External moment against flexion angle; sampling band and training curves faintly behind."""

    def __init__(self, gui: Any, colours: theme.Palette, *, height: int) -> None:
        self._colours, self._n_training = colours, 0
        self._range = series.ANGLE_RANGE
        axis = series.moment_axis(series.with_load_free(np.zeros(12), strain_free=True)[0])
        # Numbers, not NaN: a chart that is born without any never labels its second axis.
        data = (axis, *(np.zeros(len(axis)) for _ in self._series()[1:]))
        self.handle = gui.add_uplot(
            data=data,
            series=tuple(self._series()),
            scales=self._scales(),
            axes=self._axes(),
            bands=self._bands(),
            legend={"show": False},
            cursor={"points": {"show": False}, "drag": {"x": False, "y": False}},
            padding=(8, 14, 0, 0),
            height=height,
        )

    def _series(self) -> list[dict[str, Any]]:
        c = self._colours
        baseline, current, one, two = knee_lines(c, "°")
        ghost = line_style(c.ghost, 1.5 * c.size, dash=(2, 4))
        edge = line_style(c.band_edge, 1.0)
        surrogate = line_style(c.surrogate, 2.0 * c.size, dash=(7, 5))
        return [
            axis_told("External moment", "N·m", digits=2),
            line_style("rgba(0,0,0,0)", 0.0),
            line_style(c.zero, 1.0, dash=(4, 4)),
            told(edge, "band", "band from", "°"),
            told(edge, "band", "band to", "°"),
            *(switched(line_style(c.training, 1.0), "training") for _ in range(self._n_training)),
            *(told(ghost, "ghosts", f"earlier knee {i}", "°") for i in range(1, MOST + 1)),
            baseline,
            current,
            told(surrogate, "surrogate", "surrogate", "°"),
            one,
            two,
            *dots(c),
        ]

    def _bands(self) -> tuple[dict[str, Any], ...]:
        c = self._colours
        return {"series": (2, 1), "fill": c.beyond}, {"series": (4, 3), "fill": c.band}

    def _scales(self) -> dict[str, Any]:
        limit = series.MOMENT_LIMIT
        return {
            # The moments stand upright, so that all curves can share them.
            "x": {"time": False, "ori": 1, "range": (-limit, limit)},
            "y": {"ori": 0, "range": self._range},
        }

    def _axes(self) -> tuple[dict[str, Any], ...]:
        c = self._colours
        return (
            axis_style("External moment (N·m)", side=3, scale="x", size=32, colours=c),
            axis_style("Knee angle (°), flexion positive", side=2, scale="y", size=30, colours=c),
        )

    def repaint(self, colours: theme.Palette) -> None:
        """Take the colours of a theme."""
        self._colours = colours
        self.handle.series = tuple(self._series())
        self.handle.bands = self._bands()
        self.handle.axes = self._axes()

    def update(self, shown: Shown, markers: Markers) -> None:
        """Draw `shown`, with the poses on screen marked."""
        n_training = self._n_training if shown.training is None else len(shown.training)
        if n_training != self._n_training:
            self._n_training = n_training
            self.handle.series = tuple(self._series())
        axis, behind, in_front = self._data(shown, markers)
        span = series.angle_range([*behind, *in_front])
        if span != self._range:  # rarely: a new scale makes a new chart
            self._range = span
            self.handle.scales = self._scales()
        edge = np.full(len(axis), span[0])
        self.handle.data = (axis, edge, np.zeros(len(axis)), *behind, *in_front)

    def _data(
        self, shown: Shown, markers: Markers
    ) -> tuple[FloatArray, list[FloatArray], list[FloatArray]]:
        moments = series.with_load_free(np.zeros(12), strain_free=shown.strain_free)[0]
        poses = [pose for pose in markers.poses if pose is not None]
        axis = series.moment_axis(moments, [pose.moment for pose in poses])

        def curve(flexion: FloatArray | None) -> FloatArray:
            if flexion is None:
                return series.nothing(axis)
            angles = series.with_load_free(flexion, strain_free=shown.strain_free)[1]
            return series.angles_at(axis, moments, angles)

        def knee_curve(sweep: Sweep | None) -> FloatArray:
            if sweep is None:
                return series.nothing(axis)
            return series.angles_at(axis, sweep.moment[::-1], np.degrees(sweep.flexion[::-1]))

        training = [curve(None)] * self._n_training  # other lines would make another chart
        if shown.training is not None:
            training = list(curve(shown.training))
        band = [curve(None), curve(None)]
        if shown.band is not None:
            edges = (shown.band.lower_deg, shown.band.upper_deg)
            band = [curve(np.radians(edge)) for edge in edges]
        missing = [None] * (MOST - len(shown.ghosts))
        ghosts = [knee_curve(sweep) for sweep in (*shown.ghosts, *missing)]
        baseline, current, one, two = (knee_curve(sweep) for sweep in shown.sweeps)
        lines = [baseline, current, curve(shown.predicted), one, two]
        dots = [
            series.nothing(axis)
            if pose is None
            else series.mark(axis, pose.moment, float(np.degrees(pose.flexion)))
            for pose in markers.poses
        ]
        return axis, [*band, *training, *ghosts], [*lines, *dots]

"""The charts over the flexion angle: tensions and the contact's place."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneeviz.geometry.mechanism import Pose, contact_coordinates
from kneeviz.geometry.sweep import Sweep
from kneeviz.state.shown import KNEES, Markers, Shown
from kneeviz.views import theme
from kneeviz.views.charts import series
from kneeviz.views.charts.styles import axis_style, axis_told, dots, knee_lines, line_style

FloatArray = NDArray[np.float64]

_AFTER_ZERO = 1e-3  # deg
_CORNERS = 13 * len(KNEES) + 4 + 3


class AngleChart:
    """A quantity against the flexion angle, one line for each knee."""

    def __init__(
        self,
        gui: Any,
        colours: theme.Palette,
        *,
        label: str,
        unit: str,
        height: int,
        limits: tuple[float, float],
        step: float,
        with_angle_label: bool = True,
    ) -> None:
        self._label, self._unit, self._limits, self._step = label, unit, limits, step
        self._colours, self._with_angle_label = colours, with_angle_label
        self._angles = series.ANGLE_RANGE
        axis = np.linspace(*series.ANGLE_RANGE, _CORNERS)
        self.handle = gui.add_uplot(
            data=(axis, *(np.zeros(len(axis)) for _ in range(9))),
            series=tuple(self._series()),
            scales=self._scales(),
            axes=self._axes(),
            bands=({"series": (1, 2), "fill": colours.beyond},),
            legend={"show": False},
            cursor={"points": {"show": False}, "drag": {"x": False, "y": False}},
            padding=(6, 12, 0, 0),
            height=height,
        )

    def _series(self) -> list[dict[str, Any]]:
        c = self._colours
        clear = "rgba(0,0,0,0)"
        digits = 0 if self._unit == "N" else 1
        return [
            axis_told("Knee angle", "°"),
            line_style(clear, 0.0),
            line_style(clear, 0.0),
            *knee_lines(c, self._unit, digits),
            *dots(c),
        ]

    def _scales(self) -> dict[str, Any]:
        return {
            "x": {"time": False, "range": self._angles},
            "y": {"range": self._limits},
        }

    def _axes(self) -> tuple[dict[str, Any], ...]:
        c = self._colours
        below = "Knee angle (°)" if self._with_angle_label else ""
        bottom = axis_style(below, side=2, scale="x", size=24, colours=c)
        if not below:
            bottom["labelSize"] = 0
        return bottom, axis_style(
            f"{self._label} ({self._unit})", side=3, scale="y", size=36, colours=c
        )

    def repaint(self, colours: theme.Palette) -> None:
        """Take the colours of a theme."""
        self._colours = colours
        self.handle.series = tuple(self._series())
        self.handle.bands = ({"series": (1, 2), "fill": colours.beyond},)
        self.handle.axes = self._axes()

    def update(
        self,
        sweeps: Sequence[Sweep | None],
        values: Sequence[FloatArray | None],
        dots: Sequence[tuple[float, float] | None],
    ) -> None:
        """Draw one line for each knee.

        Parameters
        ----------
        sweeps, values
            Four knees and their quantity at the sweep's corners, shape (k,).
        dots : sequence of (deg, value) or None
            Poses on screen: the visitor's knee, worst case 1 and 2.
        """
        low, high = self._angles
        marked = [low, 0.0, _AFTER_ZERO, high, *(d[0] for d in dots if d is not None)]
        axis = series.angle_axis(sweeps, marked, _CORNERS)
        lines = [series.over_angle(axis, s, v) for s, v in zip(sweeps, values, strict=True)]
        marks = [series.nothing(axis) if d is None else series.mark(axis, *d) for d in dots]
        self._fit(sweeps, lines)
        bottom, top = self._limits
        # The shade is the band between these two; right of zero it has no height.
        upper = np.full(len(axis), top)
        lower = np.where(axis <= 0.0, bottom, top)
        self.handle.data = (axis, upper, lower, *lines, *marks)

    def _fit(self, sweeps: Sequence[Sweep | None], lines: Sequence[FloatArray]) -> None:
        """Widen the scales when a curve leaves them; a new scale makes a new chart, so rarely."""
        angles = series.angle_range([np.degrees(s.flexion) for s in sweeps if s is not None])
        every = np.concatenate([*lines, np.array(self._limits)])
        high = series.value_limit(every, self._step)
        low = -series.value_limit(-every, self._step) if self._limits[0] < 0.0 else 0.0
        if angles != self._angles or (low, high) != self._limits:
            self._angles, self._limits = angles, (low, high)
            self.handle.scales = self._scales()


class ForceCharts:
    """Tension against the angle: one small chart for each ligament."""

    def __init__(self, gui: Any, colours: theme.Palette, *, height: int) -> None:
        self.charts = [
            AngleChart(
                gui,
                colours,
                label=label,
                unit="N",
                height=height,
                limits=(0.0, 300.0),
                step=100.0,
                with_angle_label=label == theme.LIGAMENT_LABELS[-1],
            )
            for label in theme.LIGAMENT_LABELS
        ]

    def repaint(self, colours: theme.Palette) -> None:
        """Take the colours of a theme."""
        for chart in self.charts:
            chart.repaint(colours)

    def update(self, shown: Shown, markers: Markers) -> None:
        """Draw the tensions of all knees."""
        for i, chart in enumerate(self.charts):
            values = [None if s is None else s.tension[:, i] for s in shown.sweeps]
            dots = [
                None if p is None else (float(np.degrees(p.flexion)), float(p.tension[i]))
                for p in markers.poses
            ]
            chart.update(shown.sweeps, values, dots)


class ApChart(AngleChart):
    """Anterior-posterior place of the contact on the plateau against the angle."""

    def __init__(self, gui: Any, colours: theme.Palette, *, height: int) -> None:
        super().__init__(
            gui,
            colours,
            label="Contact, anterior +",
            unit="mm",
            height=height,
            limits=(-30.0, 10.0),
            step=5.0,
        )

    def show(self, shown: Shown, markers: Markers) -> None:
        """Draw the contact's place for all knees."""
        values = [None if s is None else 1e3 * s.along for s in shown.sweeps]
        knees = (shown.sweeps[1], shown.sweeps[2], shown.sweeps[3])
        dots = [_ap_dot(s, p) for s, p in zip(knees, markers.poses, strict=True)]
        self.update(shown.sweeps, values, dots)


def _ap_dot(sweep: Sweep | None, pose: Pose | None) -> tuple[float, float] | None:
    if sweep is None or pose is None:
        return None
    along, _ = contact_coordinates(sweep.x, pose.flexion, pose.tibia_position)
    return float(np.degrees(pose.flexion)), 1e3 * along

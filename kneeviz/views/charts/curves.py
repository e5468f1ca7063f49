"""The charts and tables of the left panel: created once, then fed with new numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneeviz.geometry.mechanism import Pose
from kneeviz.geometry.sweep import Sweep
from kneeviz.views import theme
from kneeviz.views.charts import series

FloatArray = NDArray[np.float64]

KNEES = ("baseline", "current", "model_1", "model_2")
"""The knees of every chart, in the order in which they are drawn."""
_AFTER_ZERO = 1e-3  # deg
_CORNERS = 13 * len(KNEES) + 4 + 3


@dataclass(frozen=True, kw_only=True, eq=False)
class Band:
    """Where 99.7 % of sampled knees lie, load by load."""

    lower_deg: FloatArray
    """Shape (12,), in the response's order of loads."""
    upper_deg: FloatArray
    """Shape (12,)."""
    text: str
    """What was sampled and how, for people: "2,000 samples, settled"."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Shown:
    """What the charts show now. A missing knee is None."""

    sweeps: tuple[Sweep | None, ...]
    """Baseline, the visitor's knee, worst case 1 and 2."""
    flexion: FloatArray | None
    """The visitor's knee's 12 angles, rad."""
    predicted: FloatArray | None
    """The surrogate's 12 angles for the visitor's knee, rad."""
    training: FloatArray | None
    """The surrogate's training curves, shape (n, 12), rad."""
    strain_free: bool
    """Whether all knees share the load-free pose."""
    band: Band | None = None
    """The sampling band behind the curves."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Markers:
    """The poses on screen: the visitor's knee, worst case 1 and 2."""

    poses: tuple[Pose | None, Pose | None, Pose | None]


def _line(colour: str, width: float, *, dash: tuple[float, ...] | None = None) -> dict[str, Any]:
    line: dict[str, Any] = {"stroke": colour, "width": width, "points": {"show": False}}
    if dash is not None:
        line["dash"] = dash
    return line


def _knee_lines(colours: theme.Palette) -> list[dict[str, Any]]:
    return [
        _line(colours.baseline, 1.5),
        _line(colours.current, 2.5),
        _line(colours.model_1, 2.0),
        _line(colours.model_2, 2.0),
    ]


def _dots(colours: theme.Palette) -> list[dict[str, Any]]:
    hues = (colours.current, colours.model_1, colours.model_2)
    return [
        {"stroke": hue, "width": 0, "points": {"show": True, "size": 10, "fill": hue, "space": 0}}
        for hue in hues
    ]


def _axis(
    label: str, *, side: int, scale: str, size: int, colours: theme.Palette
) -> dict[str, Any]:
    return {
        "label": label,
        "side": side,
        "scale": scale,
        "size": size,
        "labelSize": 18,
        "gap": 4,
        "font": "11px sans-serif",
        "labelFont": "12px sans-serif",
        "stroke": colours.text,
        "grid": {"stroke": colours.rule, "width": 1},
        "ticks": {"stroke": colours.rule, "size": 4, "width": 1},
    }


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
        baseline, current, one, two = _knee_lines(c)
        return [
            {},
            _line("rgba(0,0,0,0)", 0.0),
            _line(c.zero, 1.0, dash=(4, 4)),
            _line(c.band_edge, 1.0),
            _line(c.band_edge, 1.0),
            *(_line(c.training, 1.0) for _ in range(self._n_training)),
            baseline,
            current,
            _line(c.surrogate, 2.0, dash=(7, 5)),
            one,
            two,
            *_dots(c),
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
            _axis("External moment (N·m)", side=3, scale="x", size=32, colours=c),
            _axis("Knee angle (deg), flexion positive", side=2, scale="y", size=30, colours=c),
        )

    def repaint(self, colours: theme.Palette) -> None:
        """Take the colours of a theme."""
        self._colours = colours
        self.handle.series = tuple(self._series())
        self.handle.bands = self._bands()
        self.handle.axes = self._axes()

    def update(self, shown: Shown, markers: Markers) -> None:
        """Draw `shown`, with the poses on screen marked."""
        n_training = 0 if shown.training is None else len(shown.training)
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

        training = [] if shown.training is None else list(curve(shown.training))
        band = [curve(None), curve(None)]
        if shown.band is not None:
            edges = (shown.band.lower_deg, shown.band.upper_deg)
            band = [curve(np.radians(edge)) for edge in edges]
        baseline, current, one, two = (knee_curve(sweep) for sweep in shown.sweeps)
        lines = [baseline, current, curve(shown.predicted), one, two]
        dots = [
            series.nothing(axis)
            if pose is None
            else series.mark(axis, pose.moment, float(np.degrees(pose.flexion)))
            for pose in markers.poses
        ]
        return axis, [*band, *training], [*lines, *dots]


class AngleChart:
    """A quantity against the flexion angle, one line for each knee."""

    def __init__(
        self,
        gui: Any,
        colours: theme.Palette,
        *,
        label: str,
        height: int,
        limits: tuple[float, float],
        step: float,
        with_angle_label: bool = True,
    ) -> None:
        self._label, self._limits, self._step = label, limits, step
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
        return [{}, _line(clear, 0.0), _line(clear, 0.0), *_knee_lines(c), *_dots(c)]

    def _scales(self) -> dict[str, Any]:
        return {
            "x": {"time": False, "range": self._angles},
            "y": {"range": self._limits},
        }

    def _axes(self) -> tuple[dict[str, Any], ...]:
        c = self._colours
        below = "Knee angle (deg)" if self._with_angle_label else ""
        bottom = _axis(below, side=2, scale="x", size=24, colours=c)
        if not below:
            bottom["labelSize"] = 0
        return bottom, _axis(self._label, side=3, scale="y", size=36, colours=c)

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
                label=f"{label} (N)",
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
            label="Contact, anterior + (mm)",
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
    from kneeviz.geometry.mechanism import contact_coordinates

    if sweep is None or pose is None:
        return None
    along, _ = contact_coordinates(sweep.x, pose.flexion, pose.tibia_position)
    return float(np.degrees(pose.flexion)), 1e3 * along

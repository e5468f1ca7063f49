"""The chart of moment against angle as SVG, with a dot for each knee."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from kneeviz.export.film import Film
from kneeviz.views.html.pieces import number

FloatArray = NDArray[np.float64]

WIDTH, HEIGHT = 460.0, 380.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 52.0, 12.0, 12.0, 46.0
_ROOM = 0.04  # of the range, beyond the curves


@dataclass(frozen=True, kw_only=True)
class Scale:
    """From an axis's values to the drawing."""

    low: float
    high: float
    start: float
    end: float

    def __call__(self, values: FloatArray | float) -> FloatArray:
        """Return where values stand."""
        share = (np.asarray(values) - self.low) / (self.high - self.low)
        return np.asarray(self.start + share * (self.end - self.start))

    def ticks(self) -> FloatArray:
        """Return round values on the axis."""
        values = np.array(MaxNLocator(nbins=7).tick_values(self.low, self.high))
        return values[(values >= self.low) & (values <= self.high)]


def scales(film: Film) -> tuple[Scale, Scale]:
    """Return the scales of the angle (deg) and of the moment (N m) that hold all curves."""
    angle = np.concatenate([knee.angle_deg for knee in film.knees])
    room = max(_ROOM * float(np.ptp(angle)), 1.0)
    across = Scale(
        low=float(angle.min()) - room,
        high=float(angle.max()) + room,
        start=_LEFT,
        end=WIDTH - _RIGHT,
    )
    most = 1.1 * float(np.abs(film.moment).max())
    return across, Scale(low=-most, high=most, start=HEIGHT - _BOTTOM, end=_TOP)


def chart(film: Film) -> str:
    """Return the chart; the dots have the classes `dot` and the knee's name."""
    across, up = scales(film)
    parts = [_beyond(across), _grid(across, up), _titles()]
    for knee in film.knees:
        curve = " ".join(
            f"{x:.1f},{y:.1f}"
            for x, y in zip(
                across(np.degrees(knee.sweep.flexion)), up(knee.sweep.moment), strict=True
            )
        )
        parts.append(f'<polyline class="curve {knee.name}" points="{curve}"/>')
    parts += [f'<circle class="dot {knee.name}" r="5.5"/>' for knee in film.knees]
    return (
        f'<svg class="chart" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" '
        f'aria-label="External moment against knee angle of the knees">{"".join(parts)}</svg>'
    )


def _beyond(across: Scale) -> str:
    """Return the shade over over-extension, left of zero."""
    end = float(np.clip(across(0.0), across.start, across.end))
    return (
        f'<rect class="beyond" x="{across.start:g}" y="{_TOP:g}" '
        f'width="{end - across.start:.1f}" height="{HEIGHT - _TOP - _BOTTOM:g}"/>'
    )


def _grid(across: Scale, up: Scale) -> str:
    bottom, right = HEIGHT - _BOTTOM, WIDTH - _RIGHT
    vertical = [
        _line(x, _TOP, x, bottom, zero=value == 0.0) + _text(x, bottom + 17, value, "middle")
        for value, x in _placed(across)
    ]
    level = [
        _line(_LEFT, y, right, y, zero=value == 0.0) + _text(_LEFT - 7, y + 4.5, value, "end")
        for value, y in _placed(up)
    ]
    return "".join(vertical + level)


def _placed(scale: Scale) -> Sequence[tuple[float, float]]:
    ticks = scale.ticks()
    return list(zip(ticks.tolist(), scale(ticks).tolist(), strict=True))


def _line(x1: float, y1: float, x2: float, y2: float, *, zero: bool) -> str:
    kind = "zero" if zero else "grid"
    return f'<line class="{kind}" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>'


def _text(x: float, y: float, value: float, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{number(value, 0)}</text>'


def _titles() -> str:
    middle = 0.5 * (_TOP + HEIGHT - _BOTTOM)
    return (
        f'<text x="{0.5 * (_LEFT + WIDTH - _RIGHT):g}" y="{HEIGHT - 8:g}" text-anchor="middle">'
        "knee angle, ° (flexion &gt; 0)</text>"
        f'<text transform="translate(14 {middle:g}) rotate(-90)" text-anchor="middle">'
        "external moment, N·m (extension &gt; 0)</text>"
    )

"""The search's methods side by side: a convergence plot as SVG and a table. Pure functions."""

import math
from collections.abc import Sequence

import numpy as np

from kneecore import MethodTrace
from kneeviz.views import theme
from kneeviz.views.html import pieces

_WIDTH, _HEIGHT = 362.0, 200.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 40.0, 8.0, 8.0, 34.0
_NAMES = {
    "ga": "genetic, true model",
    "ga_surrogate": "genetic, surrogate",
    "exact": "exact gradients",
    "repair": "self-repairing surrogate",
}


def _hue(name: str, colours: theme.Palette) -> str:
    own = {"ga": colours.genetic, "exact": colours.exact, "repair": colours.repair}
    return own.get(name, colours.surrogate)


class _Axes:
    """Where models (log) and f (deg) lie in the drawing."""

    def __init__(self, traces: Sequence[MethodTrace]) -> None:
        models = np.concatenate([t.n_models for t in traces])
        values = np.concatenate([t.objective for t in traces])
        self.decades = (math.floor(math.log10(models.min())), math.ceil(math.log10(models.max())))
        self.step = _round_step(float(np.ptp(values)) / 4.0)
        self.low = self.step * math.floor(values.min() / self.step)
        self.high = self.step * max(math.ceil(values.max() / self.step), self.low / self.step + 1.0)

    def x(self, n_models: float) -> float:
        first, last = self.decades
        share = (math.log10(n_models) - first) / max(last - first, 1)
        return _LEFT + share * (_WIDTH - _LEFT - _RIGHT)

    def y(self, value: float) -> float:
        share = (value - self.low) / (self.high - self.low)
        return float(_HEIGHT - _BOTTOM - share * (_HEIGHT - _TOP - _BOTTOM))


def _round_step(rough: float) -> float:
    """Return 1, 2 or 5 times a power of ten, at least `rough`."""
    power = 10.0 ** math.floor(math.log10(max(rough, 1e-3)))
    return next(s * power for s in (1.0, 2.0, 5.0, 10.0) if s * power >= rough * (1.0 - 1e-9))


def _label(x: float, y: float, text: str, anchor: str, extra: str = "") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {extra}>{text}</text>'


def _grid(axes: _Axes, colours: theme.Palette) -> str:
    parts = []
    bottom, right = _HEIGHT - _BOTTOM, _WIDTH - _RIGHT
    for decade in range(axes.decades[0], axes.decades[1] + 1):
        x = axes.x(10.0**decade)
        parts.append(f'<path d="M{x:.1f} {_TOP}V{bottom}" stroke="{colours.rule}"/>')
        anchor = "end" if decade == axes.decades[1] else "middle"
        parts.append(_label(min(x, right), bottom + 13, f"{10**decade:,}", anchor))
    n_lines = round((axes.high - axes.low) / axes.step)
    for k in range(n_lines + 1):
        value = axes.low + k * axes.step
        y = axes.y(value)
        parts.append(f'<path d="M{_LEFT} {y:.1f}H{right}" stroke="{colours.rule}"/>')
        digits = max(0, -math.floor(math.log10(axes.step)))
        parts.append(_label(_LEFT - 4, y + 3.5, pieces.number(value, digits), "end"))
    middle = 0.5 * (_LEFT + right)
    parts.append(_label(middle, _HEIGHT - 8, "True models run (log scale)", "middle"))
    turned = f'transform="rotate(-90 9 {0.5 * bottom:.0f})"'
    parts.append(_label(9, 0.5 * bottom, "Best f (°)", "middle", turned))
    return "".join(parts)


def _steps(trace: MethodTrace, axes: _Axes, hue: str) -> str:
    """Return a line that rises where a better pair was found, with a dot at its end."""
    x = [axes.x(float(n)) for n in trace.n_models]
    y = [axes.y(float(f)) for f in trace.objective]
    path = f"M{x[0]:.1f} {y[0]:.1f}" + "".join(
        f"H{a:.1f}V{b:.1f}" for a, b in zip(x[1:], y[1:], strict=True)
    )
    return (
        f'<path d="{path}" fill="none" stroke="{hue}" stroke-width="2"/>'
        f'<circle cx="{x[-1]:.1f}" cy="{y[-1]:.1f}" r="4" fill="{hue}"/>'
        + "".join(_pointed(trace, k, x[k], y[k]) for k in range(len(x)))
    )


def _pointed(trace: MethodTrace, k: int, x: float, y: float) -> str:
    """Return what a pointer is told at one better pair; nothing is seen of it."""
    value = pieces.number(float(trace.objective[k]), 1, "°")
    words = f"{_NAMES[trace.method]}: f {value} after {round(float(trace.n_models[k])):,} models"
    return (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill-opacity="0"><title>{words}</title></circle>'
    )


def plot(traces: Sequence[MethodTrace], colours: theme.Palette) -> str:
    """Return the convergence plot; traces without any answer are left out."""
    known = [t for t in traces if t.n_models]
    if not known:
        return ""
    axes = _Axes(known)
    lines = "".join(_steps(t, axes, _hue(t.method, colours)) for t in known)
    return (
        f'<svg viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" width="100%" style="display:block" '
        f'fill="currentColor" font-size="10.5" role="img" aria-label="Best f of each method '
        f'against the true models that it ran">{_grid(axes, colours)}{lines}</svg>'
    )


def table(traces: Sequence[MethodTrace], colours: theme.Palette) -> str:
    """Return f, its shortfall from the best of all, the models and the seconds of each method."""
    known = [t for t in traces if t.n_models]
    best = max((t.objective[-1] for t in known), default=math.nan)
    rows = []
    for trace in traces:
        name, short = trace.method, trace.shortfall_percent(best)
        label = pieces.coloured(_NAMES[name], _hue(name, colours))
        if short is None:
            rows.append((label, *["\u2013"] * 4))
            continue
        rows.append(
            (
                label,
                pieces.number(float(trace.objective[-1]), 1, "°"),
                pieces.number(max(short, 0.0), 1, "%"),
                f"{round(float(trace.n_models[-1])):,}",
                pieces.number(trace.seconds, 2, "s"),
            )
        )
    return pieces.table(("", "f", "short by", "models", "time"), rows)


def promises(traces: Sequence[MethodTrace]) -> str:
    """Return what the searches in a surrogate had promised, each with the truth beside it."""
    told = []
    for trace in traces:
        name, promised = trace.method, trace.promised
        if promised is None or not trace.objective:
            continue
        true = pieces.number(float(trace.objective[-1]), 1, "°")
        told.append(
            f"{_NAMES[name].capitalize()}: it promised {pieces.number(promised, 1, '°')}, "
            f"the true model says {true}."
        )
    return " ".join(told)

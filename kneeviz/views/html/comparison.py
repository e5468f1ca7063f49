"""The parameters of several knees side by side."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kneecore import NAMES, Parameter, ParameterSpace, parameter_table
from kneecore.knee.parameters import display_values, widened
from kneeviz.views import theme
from kneeviz.views.html.labels import parameter_label, unit_of
from kneeviz.views.html.pieces import box, coloured, escape, faint, number

FloatArray = NDArray[np.float64]


def comparison(
    space: ParameterSpace,
    knees: Sequence[tuple[str, str, FloatArray | None]],
    *,
    precision: int = 2,
) -> str:
    """Return the parameters side by side: where each knee lies within its bounds.

    Parameters
    ----------
    space : ParameterSpace
        Its bounds are the ends of each line.
    knees : sequence of (label, colour, x or None)
        The last is drawn on top.
    """
    n = len(space.lower)
    shown = [
        (label, colour, widened(x, max(n, len(x)))[:n])
        for label, colour, x in knees
        if x is not None
    ]
    placed = [(colour, space.to_unit(x), display_values(x)) for _, colour, x in shown]
    low, high = display_values(space.lower), display_values(space.upper)
    rows = []
    for i, row in enumerate(parameter_table(rest_lengths=n > len(NAMES))):
        entries = [(colour, float(unit[i]), float(value[i])) for colour, unit, value in placed]
        bounds = f"{low[i]:.{precision}f} to {high[i]:.{precision}f}"
        rows.append(_row(row, bounds, entries, precision))
    key = " · ".join(coloured(label, colour) for label, colour, _ in shown)
    return box(
        f'<div style="margin-bottom:4px">{key}</div>' + "".join(rows), style="font-size:11.5px"
    )


def _row(
    row: Parameter, bounds: str, entries: list[tuple[str, float, float]], precision: int
) -> str:
    """Return one parameter's strip; an entry is a colour, a place between 0 and 1, and a value."""
    dots = "".join(_strip_dot(colour, place) for colour, place, _ in entries)
    digits = 3 if row.unit == "-" else precision
    values = " ".join(
        f'<span style="color:{theme.ink(hue)}">{number(value, digits)}</span>'
        for hue, _, value in entries[1:]
    )
    unit = unit_of(row.name)
    label = f"{parameter_label(row.name)}{faint(unit)}"
    return (
        f'<div style="display:flex;align-items:center;gap:6px;height:17px" '
        f'title="{escape(row.meaning)}: {bounds}{unit}">'
        f'<span style="width:122px;white-space:nowrap;overflow:hidden">{label}</span>'
        f'<span style="position:relative;flex:1;height:2px;background:rgba(128,128,128,.35)">'
        f'{dots}</span><span style="width:118px;text-align:right;font-size:10px;'
        f'white-space:nowrap;font-variant-numeric:tabular-nums">{values}</span></div>'
    )


def _strip_dot(colour: str, share: float) -> str:
    place = 100.0 * min(max(share, 0.0), 1.0)
    return (
        f'<span style="position:absolute;left:{place:.1f}%;top:-4px;width:9px;height:9px;'
        f'margin-left:-4px;border-radius:50%;background:{colour};opacity:.85"></span>'
    )

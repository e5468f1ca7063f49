"""The parameters of several knees side by side."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kneecore import NAMES, Parameter, ParameterSpace, parameter_table
from kneecore.knee.parameters import display_values, widened
from kneeviz.views.html.labels import parameter_label, unit_of
from kneeviz.views.html.pieces import box, coloured, escape, faint, number
from kneeviz.views.html.strips import strip

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
    digits = 3 if row.unit == "-" else precision
    unit = unit_of(row.name)
    return strip(
        f"{parameter_label(row.name)}{faint(unit)}",
        f"{escape(row.meaning)}: {bounds}{unit}",
        [(hue, place, number(value, digits)) for hue, place, value in entries],
    )

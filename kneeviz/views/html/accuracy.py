"""Which measurement must be how good, drawn as SVG: one tolerance for all beside the cheapest."""

import numpy as np

from kneecore import AccuracyAllocation
from kneecore.knee.parameters import STRUCTURE
from kneecore.report.accuracy_allocation import checks, summary
from kneeviz.views import theme
from kneeviz.views.html.labels import parameter_label
from kneeviz.views.html.pieces import box, escape, faint, number, plain
from kneeviz.views.html.svg import LABELS, ROW, WIDTH, drawing, rect, text

_GROUP_OF = {row[0]: row[1] for row in STRUCTURE}
_VALUES = 62.0  # width of the column of tolerances


def tolerances(found: AccuracyAllocation, colours: theme.Palette) -> str:
    """Return the answer in words and as bars, the tightest first."""
    head = f"<b>{plain(summary(found, called=parameter_label))}</b>"
    if found.factors is None:
        return box(head)
    cost = (
        "Pale: as stated (the bounds of the tab “Knee”); thin grey: one tolerance for all; "
        "coloured: the cheapest, where half the tolerance costs twice as much. "
    )
    foot = cost + " ".join(plain(one) for one in checks(found))
    return box(head + bars(found, colours) + faint(foot))


def bars(found: AccuracyAllocation, colours: theme.Palette) -> str:
    """Return the tolerances as shares of what was stated, with their values."""
    assert found.factors is not None
    left, right = LABELS + 4.0, WIDTH - _VALUES
    parts = []
    for row, k in enumerate(np.argsort(found.factors, kind="stable").tolist()):
        y = 4.0 + ROW * row
        hue = theme.group_colour(_GROUP_OF[found.inputs[k][0]], colours)
        label = escape(parameter_label(found.names[k]))
        one_for_all = 0.0 if found.equal_factors is None else min(found.equal_factors[k], 1.0)
        parts.append(
            f"<g><title>{label}: {_told(found, k)}</title>"
            + text(LABELS, y + 0.76 * ROW, label, anchor="end")
            + rect(left, y + 1.0, right - left, ROW - 2.0, hue, 0.14)
            + rect(left, y + 2.0, (right - left) * found.factors[k], ROW - 6.0, hue, 1.0)
            + rect(left, y + ROW - 3.5, (right - left) * one_for_all, 2.0, colours.baseline, 1.0)
            + text(WIDTH, y + 0.76 * ROW, _tolerance(found, found.factors, k), anchor="end")
            + "</g>"
        )
    return drawing(8.0 + ROW * len(found.names), "".join(parts))


def _tolerance(found: AccuracyAllocation, factors: np.ndarray, k: int) -> str:
    value = float(found.stated[k] * factors[k])
    digits = 2 if value < 1.0 else 1
    unit = found.units[k].replace("deg", "°")
    return "±\u202f" + number(value, digits, unit)


def _told(found: AccuracyAllocation, k: int) -> str:
    """Return a measurement's numbers in words."""
    assert found.factors is not None
    words = f"cheapest {_tolerance(found, found.factors, k)}"
    if found.as_stated[k]:
        words += ", as stated"
    if found.equal_factors is not None:
        words += f"; one for all {_tolerance(found, found.equal_factors, k)}"
    if found.gains is not None:
        words += f"; adds {number(float(found.gains[k]), 2, '°')} to the worst knee"
    if found.enlarged is not None and np.isfinite(found.enlarged[k]):
        words += f"; 10 % wider alone: {number(float(found.enlarged[k]), 2, '°')}"
    return words

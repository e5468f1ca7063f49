"""Which parameters decide, drawn as SVG: sorted bars with intervals, and a heat map.

Every parameter has its group's hue, the ligaments that of the scene.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore import MOMENT, InfluenceResult, WorstCaseSlopes
from kneecore.knee.parameters import STRUCTURE
from kneecore.report.influence import gaps
from kneeviz.views import theme
from kneeviz.views.html import marks, pieces
from kneeviz.views.html.labels import parameter_label
from kneeviz.views.html.svg import LABELS, ROW, WIDTH, drawing, rect
from kneeviz.views.html.svg import text as label_at

FloatArray = NDArray[np.float64]

_GROUP_OF = {row[0]: row[1] for row in STRUCTURE}
_ORDER = np.argsort(-MOMENT)
_TITLES = {"acl": "ACL", "pcl": "PCL", "mcl": "MCL", "lcl": "LCL"}


def _hue(name: str, colours: theme.Palette) -> str:
    return theme.group_colour(_GROUP_OF[name], colours)


def _percent(value: float) -> str:
    return pieces.number(100.0 * max(value, 0.0), 0)


def _scale_end(values: FloatArray) -> float:
    """Return the axis's end: whole tenths that hold all values."""
    finite = values[np.isfinite(values)]
    return max(0.1, 0.1 * float(np.ceil(10.0 * finite.max() - 1e-9))) if len(finite) else 1.0


def bars(
    found: InfluenceResult,
    load: int,
    colours: theme.Palette,
    *,
    called: Callable[[str], str] = parameter_label,
    hue_of: Callable[[str, theme.Palette], str] = _hue,
    quantity: str = "the angle",
    most: int | None = None,
) -> str:
    """Return the total indices at a load (index), sorted, with 95 % intervals where known.

    The solid part of a bar is what the parameter explains alone. `called` names an input,
    `hue_of` gives its colour; `most` are shown.
    """
    total, first = found.indices.total_order[load], found.indices.first_order[load]
    if not np.isfinite(total).all():
        why = "failed too often" if found.indices.unknown[load] else "does not vary here"
        return pieces.box(f"{quantity[:1].upper()}{quantity[1:]} {why}.")
    interval = found.indices.total_order_interval
    whisker = None if interval is None else interval[:, load]
    end = _scale_end(total if whisker is None else np.maximum(total, whisker[1]))
    order = np.argsort(-total, kind="stable")[:most]
    top, left, right = 4.0, LABELS + 4.0, WIDTH - 34.0
    bottom = top + ROW * len(order)

    def at(value: float) -> float:
        return left + (right - left) * min(max(value / end, 0.0), 1.0)

    parts = [_bar_axis(at, end, top, bottom, quantity)]
    for row, k in enumerate(order):
        label, y = pieces.escape(called(found.names[k])), top + ROW * row
        hue = hue_of(found.names[k], colours)
        both = [("total", total[k], interval), ("alone", first[k], None)]
        if found.indices.first_order_interval is not None:
            both[1] = ("alone", first[k], found.indices.first_order_interval)
        told = "; ".join(_told(word, value, span, load, k) for word, value, span in both)
        parts.append(
            f"<g><title>{label}: {told}</title>"
            + label_at(LABELS, y + 0.76 * ROW, label, anchor="end")
            + rect(left, y + 2.0, at(total[k]) - left, ROW - 4.0, hue, 0.38)
            + rect(left, y + 2.0, at(min(first[k], total[k])) - left, ROW - 4.0, hue, 1.0)
            + ("" if whisker is None else _whisker(at, whisker[:, k], y + 0.5 * ROW))
            + label_at(WIDTH, y + 0.76 * ROW, f"{_percent(total[k])} %", anchor="end")
            + "</g>"
        )
    return drawing(bottom + 30.0, "".join(parts))


def _told(word: str, value: float, interval: FloatArray | None, load: int, k: int) -> str:
    if interval is None:
        return f"{word} {100.0 * value:.1f} %"
    low, high = 100.0 * interval[:, load, k]
    return f"{word} {100.0 * value:.1f} % (95 %: {low:.1f} to {high:.1f})"


def _whisker(at: Any, interval: FloatArray, y: float) -> str:
    low, high = at(interval[0]), at(interval[1])
    ends = "".join(f"M{x:.1f} {y - 2.5:.1f}v5" for x in (low, high))
    return f'<path d="M{low:.1f} {y:.1f}H{high:.1f}{ends}" stroke="currentColor" fill="none"/>'


def _bar_axis(at: Any, end: float, top: float, bottom: float, quantity: str) -> str:
    step = 0.1 if end <= 0.65 else 0.2
    parts = []
    for value in np.arange(0.0, end + 1e-9, step):
        x = at(float(value))
        parts.append(
            f'<path d="M{x:.1f} {top:.1f}V{bottom:.1f}" stroke="currentColor" '
            f'stroke-opacity="0.15"/>'
            + label_at(x, bottom + 11.0, _percent(float(value)), anchor="middle")
        )
    title = f"Share of the variance of {pieces.escape(quantity)} (total Sobol index), %"
    return "".join(parts) + label_at(WIDTH, bottom + 25.0, title, anchor="end")


def heat_map(found: InfluenceResult, load: int, colours: theme.Palette) -> str:
    """Return the total indices of all parameters at all loads; the chosen load is framed."""
    total = found.indices.total_order
    end = _scale_end(total)
    left, top = LABELS + 4.0, 30.0
    cell = (WIDTH - left) / len(MOMENT)
    bottom = top + ROW * len(found.names)
    parts = [label_at(left, 10.0, "External moment (N·m), extension +")]
    for column, k in enumerate(_ORDER):
        x = left + cell * column
        text = ("+" if MOMENT[k] > 0 else "\u2212") + f"{abs(MOMENT[k]):g}"
        parts.append(
            label_at(x + 0.5 * cell, top - 5.0, text, anchor="middle", extra='font-size="9"')
        )
    for row, name in enumerate(found.names):
        y, label = top + ROW * row, pieces.escape(parameter_label(name))
        parts.append(label_at(LABELS, y + 0.76 * ROW, label, anchor="end"))
        hue = _hue(name, colours)
        for column, k in enumerate(_ORDER):
            parts.append(_cell(left + cell * column, y, cell, total[k, row], end, hue, label, k))
    framed = left + cell * int(_ORDER.tolist().index(load))
    parts.append(
        f'<rect x="{framed:.1f}" y="{top:.1f}" width="{cell:.1f}" height="{bottom - top:.1f}" '
        'fill="none" stroke="currentColor" stroke-width="1.2"/>'
    )
    return drawing(bottom + 4.0, "".join(parts))


def _cell(
    x: float, y: float, width: float, value: float, end: float, hue: str, label: str, load: int
) -> str:
    known = bool(np.isfinite(value))
    share = min(max(value / end, 0.0), 1.0) if known else 0.0
    told = f"{100.0 * value:.1f} %" if known else "the angle does not vary"
    body = f"<title>{label} at {MOMENT[load]:+g} N·m: {told}</title>"
    body += rect(x + 0.5, y + 0.5, width - 1.0, ROW - 1.0, hue, 0.05 + 0.95 * share)
    if known and value >= 0.05:
        ink = 'font-size="8.5"' + (' fill="#fff"' if share > 0.5 else "")
        body += label_at(
            x + 0.5 * width, y + 0.74 * ROW, _percent(value), anchor="middle", extra=ink
        )
    return f"<g>{body}</g>"


def groups(found: InfluenceResult, load: int, colours: theme.Palette) -> str:
    """Return one strip of what each group explains alone, and what is left for interactions."""
    sums = {name: float(np.nan_to_num(values[load])) for name, values in found.groups.items()}
    sums = {name: max(value, 0.0) for name, value in sums.items()}
    scale = max(sum(sums.values()), 1.0)
    pieces = "".join(
        f'<span title="{_group_title(n)}: {100.0 * v:.0f} %" style="width:{100.0 * v / scale:.1f}%;'
        f'background:{theme.group_colour(n, colours)}"></span>'
        for n, v in sums.items()
    )
    key = " ".join(_group_key(n, v, colours) for n, v in _largest_first(sums))
    left = max(1.0 - sum(sums.values()), 0.0)
    key += f'<span style="white-space:nowrap">{_percent(left)} % only together</span>'
    return (
        f'<div style="display:flex;height:9px;background:{colours.rule};margin:3px 0">{pieces}'
        f'</div><div style="font-size:11px;line-height:1.4">{key}</div>'
    )


def _largest_first(sums: dict[str, float]) -> Sequence[tuple[str, float]]:
    return sorted(sums.items(), key=lambda item: -item[1])


def _group_title(name: str) -> str:
    return _TITLES.get(name, name)


def _group_key(name: str, value: float, colours: theme.Palette) -> str:
    return (
        f'<span style="white-space:nowrap;margin-right:8px"><span style="display:inline-block;'
        f"width:8px;height:8px;background:{theme.group_colour(name, colours)};margin-right:3px"
        f'"></span>{_group_title(name)} {_percent(value)} %</span>'
    )


def caption(found: InfluenceResult, *, bars: bool) -> str:
    """Return what the chart shows and what it is made of."""
    used = found.indices
    failed = f", {used.n_failed_rows:,} rows replaced since a model failed" * bool(
        used.n_failed_rows
    )
    what = (
        "Solid: alone; pale: with the others; whisker: 95 % interval."
        if bars
        else "Total indices in %; the frame is the chosen load."
    )
    marked = f": {told}" if (told := marks.counted(found.counts)) else ""
    gappy = "".join(f" {pieces.escape(line)}" for line in gaps(found))
    told = f"{used.n_evaluations:,} models, seed {found.settings.seed}{failed}{marked}."
    return f"{what} {told}{gappy}"


def slopes(found: WorstCaseSlopes, load: int, colours: theme.Palette) -> str:
    """Return what one half-range more of each parameter does to both worst cases at a load."""
    values = found.slopes[:, load]
    order = np.argsort(-np.abs(values).sum(axis=0), kind="stable")
    end = max(float(np.abs(values).max()), 1e-9)
    left, top = LABELS + 4.0, 18.0
    middle = 0.5 * (left + WIDTH)
    half, bottom = 0.5 * (WIDTH - left), top + ROW * len(order)
    parts = [
        f'<path d="M{middle:.1f} {top - 2.0:.1f}V{bottom:.1f}" stroke="currentColor" '
        'stroke-opacity="0.5"/>',
        label_at(left, 10.0, "more extended"),
        label_at(WIDTH, 10.0, "more flexed", anchor="end"),
    ]
    for row, k in enumerate(order):
        y = top + ROW * row
        label = pieces.escape(parameter_label(found.names[k]))
        one, two = (pieces.number(float(v), 2, "°") for v in values[:, k])
        parts.append(f"<g><title>{label}: model 1 {one}, model 2 {two}</title>")
        parts.append(label_at(LABELS, y + 0.76 * ROW, label, anchor="end"))
        for m, hue in enumerate((colours.model_1, colours.model_2)):
            size = half * float(values[m, k]) / end
            start = middle + min(size, 0.0)
            parts.append(rect(start, y + 1.5 + 5.0 * m, abs(size), 4.5, hue, 1.0))
        parts.append("</g>")
    words = (
        f"Change of the angle at {MOMENT[load]:+g} N·m for one half-range more of each parameter, "
        f"at {pieces.coloured('model 1', colours.model_1)} and "
        f"{pieces.coloured('model 2', colours.model_2)}; "
        f"the longest bar is {pieces.number(end, 1)}°."
    )
    return f"<div>{words}</div>" + drawing(bottom + 2.0, "".join(parts))

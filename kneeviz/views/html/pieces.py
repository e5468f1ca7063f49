"""Small pieces of HTML for the panels: pure functions from numbers to text.

Text that a visitor brought along (titles, file names, messages about them) is escaped here.
"""

import html
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore import LIGAMENTS, NAMES, parameter_table
from kneecore.knee.parameters import display_values, widened
from kneeviz.geometry.mechanism import TAUT_TENSION, Pose
from kneeviz.views import theme

FloatArray = NDArray[np.float64]

_BOX = "font-size:12.5px;line-height:1.45;padding:2px 14px 4px 14px"
_F = '<span title="The angles between the two models, summed over the loads that count">f</span>'


def box(content: str, *, style: str = "") -> str:
    """Return `content` as a block in the panels' text size."""
    return f'<div style="{_BOX};{style}">{content}</div>'


def faint(text: str) -> str:
    """Return text in the quieter tone."""
    return f'<span style="opacity:.68">{text}</span>'


def escape(text: str) -> str:
    """Return foreign text that no browser takes for markup."""
    return html.escape(str(text), quote=True)


def number(value: float, digits: int, unit: str = "") -> str:
    """Return a number with a true minus sign and its unit; a dash for what is not known."""
    if not np.isfinite(value):
        return "\u2013"
    text = f"{value:.{digits}f}"
    if float(text) == 0.0:
        text = text.lstrip("-")
    gap = "" if unit in ("", "°") else " "
    return text.replace("-", "\u2212") + gap + unit


def angle_words(flexion_deg: float) -> str:
    """Return what an angle means."""
    if flexion_deg < -0.5:
        return "over-extended"
    return "straight" if flexion_deg < 0.5 else "flexed"


def moment_words(moment: float) -> str:
    """Return what a moment does."""
    if abs(moment) < 5e-3:
        return "no load"
    return "extending" if moment > 0.0 else "flexing"


def readout(pose: Pose, colours: theme.Palette) -> str:
    """Return angle, moment and the four tensions of the pose on screen."""
    angle = float(np.degrees(pose.flexion))
    sign = "+" if pose.moment > 5e-3 else ""
    when = "" if pose.time is None else f" · {pose.time:.1f} s"
    head = (
        f'<div style="display:flex;justify-content:space-between;align-items:baseline">'
        f'<span><b style="font-size:19px">{number(angle, 1)}°</b> {angle_words(angle)}</span>'
        f"<span><b>{sign}{number(pose.moment, 2)} N·m</b> {moment_words(pose.moment)}{when}</span>"
        f"</div>"
    )
    bars = "".join(_tension_bar(i, float(pose.tension[i]), colours) for i in range(4))
    grid = "display:grid;grid-template-columns:1fr 1fr;gap:2px 14px;margin-top:3px"
    return box(head + f'<div style="{grid}">{bars}</div>', style="padding-top:6px")


def _tension_bar(index: int, tension: float, colours: theme.Palette) -> str:
    hue = theme.LIGAMENT_COLOURS[index] if tension >= TAUT_TENSION else colours.baseline
    label, width = theme.LIGAMENT_LABELS[index], 100.0 * min(tension / 300.0, 1.0)
    return (
        f'<div style="display:flex;align-items:center;gap:6px">'
        f'<span style="width:27px;font-weight:600;color:{hue}">{label}</span>'
        f'<span style="flex:1;height:6px;border-radius:3px;background:{colours.rule}">'
        f'<span style="display:block;height:6px;border-radius:3px;width:{width:.0f}%;'
        f'background:{hue}"></span></span>'
        f'<span style="width:38px;text-align:right">{number(tension, 0)} N</span></div>'
    )


def _swatch(colour: str, *, dashed: bool = False) -> str:
    style = "dashed" if dashed else "solid"
    return (
        f'<span style="display:inline-block;width:20px;border-top:3px {style} {colour};'
        f'vertical-align:middle;margin-right:5px"></span>'
    )


def _patch(fill: str, edge: str) -> str:
    return (
        f'<span style="display:inline-block;width:20px;height:9px;background:{fill};'
        f'border:1px solid {edge};vertical-align:middle;margin-right:5px"></span>'
    )


def legend(colours: theme.Palette, *, overlays: bool, curve: bool, band: str | None = None) -> str:
    """Return the charts' key.

    `curve` adds what only the moment-angle chart shows, `band` what its band was sampled from.
    """
    items = [(colours.current, False, "your knee, true model")]
    if curve:
        items.append((colours.surrogate, True, "its surrogate"))
    items.append((colours.baseline, False, "baseline"))
    if curve:
        items.append((colours.training, False, "training knees"))
    if overlays:
        items += [(colours.model_1, False, "model 1"), (colours.model_2, False, "model 2")]
    shown = "".join(
        f'<span style="white-space:nowrap;margin-right:12px">{_swatch(c, dashed=d)}{text}</span>'
        for c, d, text in items
    )
    if band is not None:
        shown += (
            f'<span style="white-space:nowrap" title="{escape(band)}">'
            f"{_patch(colours.band, colours.band_edge)}99.7 % band</span>"
        )
    return box(shown, style="font-size:11.5px")


def error_line(error: tuple[float, float] | None, loo_rms_deg: float | None) -> str:
    """Return the surrogate's error now, in words; (rms, largest) in deg."""
    if error is None or loo_rms_deg is None:
        return box(faint("The surrogate is not ready."))
    rms, largest = error
    return box(
        f"Surrogate's error now: <b>{number(rms, 1)}°</b> rms, {number(largest, 1)}° at worst. "
        + faint(f"Expected from its training knees: {number(loo_rms_deg, 1)}°.")
    )


def status(text: str, *, kind: str = "calm") -> str:
    """Return the line that says what the app is doing; `kind` is calm, busy or bad."""
    colour = {"calm": "#2b8a3e", "busy": "#e08a00", "bad": "#d6336c"}[kind]
    dot = (
        f'<span style="display:inline-block;width:8px;height:8px;border-radius:50%;'
        f'background:{colour};margin-right:7px"></span>'
    )
    line = "white-space:nowrap;overflow:hidden;text-overflow:ellipsis;padding-top:0"
    plain = text.replace('"', "&quot;")
    return f'<div title="{plain}">{box(dot + text, style=line)}</div>'


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a compact table; the first column is text, the others are numbers."""
    cells = "".join(f'<th style="text-align:{_side(i)}">{h}</th>' for i, h in enumerate(head))
    body = "".join(
        "<tr>"
        + "".join(
            f'<td style="text-align:{_side(i)};padding:1px 4px">{c}</td>' for i, c in enumerate(row)
        )
        + "</tr>"
        for row in rows
    )
    return (
        f'<table style="width:100%;border-collapse:collapse;font-size:12px;'
        f'font-variant-numeric:tabular-nums"><thead><tr>{cells}</tr></thead>'
        f"<tbody>{body}</tbody></table>"
    )


def _side(column: int) -> str:
    return "left" if column == 0 else "right"


def _coloured(text: str, colour: str) -> str:
    return f'<span style="color:{colour};font-weight:600">{text}</span>'


def differences(result: Any, colours: theme.Palette) -> str:
    """Return the table of what differs between the two worst cases."""
    one, two = result.model_1, result.model_2
    head = ("", _coloured("model 1", colours.model_1), _coloured("model 2", colours.model_2))
    straight = [float(np.degrees(r.flexion[5])) for r in (one, two)]
    bent = [float(np.degrees(r.flexion[11])) for r in (one, two)]
    rows = [
        ("Angle at +5 N·m", *(number(a, 1, "°") for a in straight)),
        ("Over-extension", *(number(max(-a, 0.0), 1, "°") for a in straight)),
        ("Extension deficit", *(number(max(a, 0.0), 1, "°") for a in straight)),
        ("Angle at \u22125 N·m", *(number(a, 1, "°") for a in bent)),
    ]
    for i, name in enumerate(LIGAMENTS):
        rows.append(
            (f"{name.upper()} at +5 N·m", *(number(r.tension[5, i], 0, "N") for r in (one, two)))
        )
    rows.append(("Contact at +5 N·m", *(number(r.contact_force[5], 0, "N") for r in (one, two))))
    bounds = np.stack([result.space.at_bounds(x) for x in result.x])
    free = int(result.space.n_free)
    rows.append(("Parameters at a bound", *(f"{int((b != 0).sum())} of {free}" for b in bounds)))
    return table(head, rows)


def objective_line(result: Any) -> str:
    """Return f with the true model's value beside the surrogate's, never one without the other."""
    model = result.objective_model
    true = "not known (the model failed there)" if model is None else number(model, 0, "°")
    rest = " at rest" if result.solver == "equilibrium" else ""
    if result.objective_surrogate is None:
        return f"{_F} = <b>{true}</b>, searched in the true model{rest}."
    gap = "" if result.gap_percent is None else f" (gap {number(result.gap_percent, 1)} %)"
    return (
        f"{_F}: surrogate {number(result.objective_surrogate, 0, '°')}, "
        f"true model{rest} <b>{true}</b>{gap}."
    )


def evidence_line(result: Any) -> str:
    """Return what an exact search says about how good its f is; nothing for another."""
    evidence = result.evidence
    if evidence is None:
        return ""
    where = "" if result.search_space == "model" else " in the surrogate"
    share = number(100.0 * evidence.share_reached, 0, "%")
    parts = [f"{share} of {evidence.n_climbs} climbs{where} end here"]
    if evidence.second_best is not None:
        parts.append(f"second basin {number(evidence.second_best, 1, '°')}")
    sides = np.stack([result.space.at_bounds(x) for x in result.x])
    inside = int((sides == 0)[:, result.space.free].sum())
    total = 2 * int(result.space.n_free)
    parts.append(f"{total - inside} of {total} values on a bound")
    if evidence.objective_before_climb is not None and result.objective_model is not None:
        gain = result.objective_model - evidence.objective_before_climb
        parts.append(f"{number(gain, 1, '°')} gained in motion")
    if evidence.n_lost:
        parts.append(f"{evidence.n_lost:,} knees without an equilibrium left out")
    return f"<br>{faint('; '.join(parts) + '.')}"


def repair_line(result: Any) -> str:
    """Return how a surrogate was repaired; nothing for one that was not."""
    repair = result.repair
    if repair is None:
        return ""
    gaps = [r.gap_percent for r in repair.rounds if r.gap_percent is not None]
    first = (
        f": the gap went from {number(gaps[0], 1)} to {number(gaps[-1], 1, '%')}" if gaps else ""
    )
    missed = "" if repair.reached else f" (its goal, {repair.goal_percent:g} %, was not reached)"
    return f"<br>{faint(f'Repaired with {repair.n_models} more models{first}{missed}.')}"


def live_note(sampled: str) -> str:
    """Return what the live search shows, in words."""
    return (
        "Live, settled: every knee at rest under its load, within the bounds around yours. "
        f"The pale band holds 99.7 % of {sampled}."
    )


def command_line(command: str) -> str:
    """Return a shell command in a box that one click selects."""
    style = (
        "display:block;user-select:all;white-space:pre-wrap;word-break:break-word;font-size:11px;"
        "border:1px solid rgba(128,128,128,.35);border-radius:4px;padding:4px 6px;margin-top:3px"
    )
    return f'<code style="{style}">{escape(command)}</code>'


def comparison(
    space: Any, knees: Sequence[tuple[str, str, FloatArray | None]], *, precision: int = 2
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
    units = [(c, space.to_unit(x), display_values(x)) for _, c, x in shown]
    low, high = display_values(space.lower), display_values(space.upper)
    rows = []
    for i, row in enumerate(parameter_table(rest_lengths=n > len(NAMES))):
        dots = "".join(_strip_dot(colour, float(u[i])) for colour, u, _ in units)
        digits = 3 if row.unit == "-" else precision
        values = " ".join(
            f'<span style="color:{hue}">{number(v[i], digits)}</span>' for hue, _, v in units[1:]
        )
        bounds = f"{low[i]:.{precision}f} to {high[i]:.{precision}f}"
        unit = "" if row.unit == "-" else f" {row.unit}"
        rows.append(
            f'<div style="display:flex;align-items:center;gap:6px;height:17px" '
            f'title="{escape(row.meaning)}: {bounds}{unit}">'
            f'<span style="width:122px;white-space:nowrap;overflow:hidden">{_short(row.name)}'
            f"{faint(unit)}</span>"
            f'<span style="position:relative;flex:1;height:2px;background:rgba(128,128,128,.35)">'
            f'{dots}</span><span style="width:118px;text-align:right;font-size:10px;'
            f'white-space:nowrap;font-variant-numeric:tabular-nums">{values}</span></div>'
        )
    key = " · ".join(_coloured(label, colour) for label, colour, _ in shown)
    return box(
        f'<div style="margin-bottom:4px">{key}</div>' + "".join(rows), style="font-size:11.5px"
    )


def _strip_dot(colour: str, share: float) -> str:
    place = 100.0 * min(max(share, 0.0), 1.0)
    return (
        f'<span style="position:absolute;left:{place:.1f}%;top:-4px;width:9px;height:9px;'
        f'margin-left:-4px;border-radius:50%;background:{colour};opacity:.85"></span>'
    )


def _short(name: str) -> str:
    words = name.split("_")
    lead = words[0].upper() if words[0] in LIGAMENTS else words[0].capitalize()
    return (
        " ".join([lead, *words[1:]])
        .replace("Poissons", "Poisson's")
        .replace("Youngs", "Young's")
        .replace("rest length change", "rest length")
    )


def parameter_label(name: str) -> str:
    """Return a parameter's name for people."""
    return _short(name)


def bound_names(result: Any) -> str:
    """Return which parameters have the two models at opposite bounds."""
    sides = np.stack([result.space.at_bounds(x) for x in result.x]).astype(int)
    opposite = [_short(result.space.names[i]) for i in np.flatnonzero(sides[0] * sides[1] < 0)]
    if not opposite:
        return "No parameter lies at opposite bounds in the two."
    return f"At opposite bounds ({len(opposite)}): {', '.join(opposite)}."


def sparkline(values: Sequence[float], colour: str) -> str:
    """Return the best f so far as a small rising curve."""
    finite = [v for v in values if np.isfinite(v)]
    if len(finite) < 2:
        return ""
    low, high = min(finite), max(finite)
    span = max(high - low, 1e-9)
    n = len(finite) - 1
    points = " ".join(
        f"{290 * i / n:.1f},{44 - 40 * (v - low) / span:.1f}" for i, v in enumerate(finite)
    )
    return (
        f'<svg viewBox="0 0 296 48" width="100%" height="48" style="display:block">'
        f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2"/></svg>'
    )

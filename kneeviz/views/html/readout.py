"""Words and numbers beside the knee and its charts: the pose, the key, the surrogate's error."""

import numpy as np

from kneeviz.geometry.mechanism import TAUT_TENSION, Pose
from kneeviz.views import theme
from kneeviz.views.html.labels import moment_words
from kneeviz.views.html.pieces import box, curve_switch, faint, number


def angle_words(flexion_deg: float) -> str:
    """Return what an angle means."""
    if flexion_deg < -0.5:
        return "over-extended"
    return "straight" if flexion_deg < 0.5 else "flexed"


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
        f'<span style="width:27px;font-weight:600;color:{theme.ink(hue)}">{label}</span>'
        f'<span style="flex:1;height:6px;border-radius:3px;background:{colours.rule}">'
        f'<span style="display:block;height:6px;border-radius:3px;width:{width:.0f}%;'
        f'background:{hue}"></span></span>'
        f'<span style="width:38px;text-align:right">{number(tension, 0)} N</span></div>'
    )


def _swatch(colour: str, style: str) -> str:
    return (
        f'<span style="display:inline-block;width:20px;border-top:3px {style} {colour};'
        f'vertical-align:middle;margin-right:5px"></span>'
    )


def _patch(fill: str, edge: str) -> str:
    return (
        f'<span style="display:inline-block;width:20px;height:9px;background:{fill};'
        f'border:1px solid {edge};vertical-align:middle;margin-right:5px"></span>'
    )


def legend(
    colours: theme.Palette,
    *,
    overlays: bool,
    curve: bool,
    band: str | None = None,
    ghosts: bool = False,
) -> str:
    """Return the charts' key.

    `curve` adds what only the moment-angle chart shows, `band` what its band was sampled from.
    """
    items = [("current", colours.current, "solid", "your knee, true model")]
    if curve:
        items.append(("surrogate", colours.surrogate, "dashed", "its surrogate"))
    items.append(("baseline", colours.baseline, "solid", "baseline"))
    if curve:
        items.append(("training", colours.training, "solid", "training knees"))
    if overlays:
        items += [
            ("model_1", colours.model_1, "solid", "model 1"),
            ("model_2", colours.model_2, "solid", "model 2"),
        ]
    if ghosts:
        items.append(("ghosts", colours.ghost, "dotted", "earlier knees"))
    shown = "".join(
        curve_switch(key, _swatch(colour, style) + text) for key, colour, style, text in items
    )
    if band is not None:
        patch = _patch(colours.band, colours.band_edge)
        shown += curve_switch("band", f"{patch}99.7 % band", hint=f"{band}.")
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

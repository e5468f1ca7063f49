"""What the study says, as HTML: the sampling's numbers and the landscape's key."""

from typing import Any

import numpy as np

from kneecore import MOMENT, Landscape
from kneecore.knee.parameters import STRUCTURE
from kneecore.study.landscape import DEFICIT, READINGS
from kneeviz.geometry.surfaces import Box, Picture, box_around
from kneeviz.views import theme
from kneeviz.views.html import pieces as markup

_UNITS = {row[0]: row[3].replace("^2", "²") for row in STRUCTURE}
STALE = "<b>Bounds changed since.</b><br>"
STALE_STYLE = "opacity:.45"


def with_unit(name: str) -> str:
    """Return a parameter's name for people, with its unit."""
    unit = _UNITS[name]
    label = markup.parameter_label(name)
    return label if unit == "-" else f"{label} ({unit})"


def load_label(moment: float) -> str:
    """Return a load for people: "+5 N·m, extending"."""
    sign = "+" if moment > 0.0 else "\u2212"
    return f"{sign}{abs(moment):g} N·m, {markup.moment_words(moment)}"


LOADS = {load_label(float(m)): float(m) for m in MOMENT[np.argsort(-MOMENT)]}
"""The 12 loads by their label, from extension to flexion."""


def _reading_label(name: str) -> str:
    return "Extension deficit" if name == DEFICIT else f"Angle at {load_label(float(name[:-4]))}"


HEIGHTS = {_reading_label(name): name for name in READINGS}
"""kneecore's readings by their label."""


def height_title(name: str) -> str:
    """Return the upright axis's title for one of kneecore's readings."""
    if name == DEFICIT:
        return "Extension deficit (deg)"
    return f"Knee angle at {load_label(float(name[:-4])).split(',')[0]} (deg)"


def sampling(found: Any, *, stale: bool) -> str:
    """Return what a Monte-Carlo study found at the largest moments, failures counted."""
    spread = found.flexion_deg
    rows = [
        (
            f"{'+' if MOMENT[k] > 0 else ''}{markup.number(float(MOMENT[k]), 0)} N·m",
            markup.number(spread.mean[k], 1),
            markup.number(spread.sd[k], 1),
            markup.number(spread.percentile_lower[k], 1),
            markup.number(spread.percentile_upper[k], 1),
        )
        for k in (5, 11)
    ]
    head = ("Angle, deg", "mean", "sd", "0.15 %", "99.85 %")
    note = (
        f"{found.n_samples:,} knees, {found.sampling}, seed {found.seed}: "
        f"<b>{found.n_failed:,} failed</b> (left out), {found.n_unsettled:,} not at rest at some "
        "load (kept)."
    )
    return markup.box(
        (STALE if stale else "") + markup.table(head, rows) + markup.faint(note),
        style=STALE_STYLE if stale else "",
    )


def judged(words: str, *, stale: bool) -> str:
    """Return what became of the paper's claims."""
    return markup.box(
        (STALE if stale else "") + f"The paper: {markup.escape(words)}",
        style=STALE_STYLE if stale else "",
    )


def _dot(colour: str, size: int = 9) -> str:
    return (
        f'<span style="display:inline-block;width:{size}px;height:{size}px;border-radius:50%;'
        f'background:{colour};margin:0 {14 - size}px 0 2px"></span>'
    )


def _patch(colour: str) -> str:
    return (
        f'<span style="display:inline-block;width:12px;height:9px;background:{colour};'
        f'opacity:.6;margin-right:4px"></span>'
    )


def error_words(found: Landscape, name: str) -> str:
    """Return how far the surrogate is off over the slice, in words."""
    error = found.error(name)
    if error is None:
        return "There is no surrogate for these bounds: the true model alone is shown."
    size = np.abs(error[np.isfinite(error)])
    if len(size) == 0:
        return "The true model fails everywhere on this slice."
    return (
        f"Surrogate against true model on this slice: <b>{markup.number(size.mean(), 2)}°</b> off "
        f"on average, <b>{markup.number(size.max(), 2)}°</b> at worst."
    )


def landscape_key(
    found: Landscape, shown: Picture, name: str, colours: theme.Palette, *, zoom: bool
) -> str:
    """Return the landscape's key and the surrogate's error."""
    box = box_around(shown, zoom=zoom)
    failed = f", {found.n_failed} failed (holes)" if found.n_failed else ""
    lines = [f"{_patch(colours.current)}true model: {found.n_models:,} knees simulated{failed}"]
    if shown.surrogate is not None:
        lines.append(f"{_patch(colours.surrogate)}surrogate, asked for the same knees")
    own = f"{_dot(colours.current)}your knee"
    if shown.predicted is not None:
        own += f" {_dot(colours.surrogate, 7)}what the surrogate says of it"
    lines.append(own)
    beside = _worst_words(shown, box, colours) + _training_words(shown, box, colours)
    off = f"Both sheets have your knee's other {len(found.space.names) - 2} parameters."
    if beside:
        off += " Training knees and worst cases have their own: they lie off the sheets."
    body = "".join(f'<div style="line-height:1.5">{line}</div>' for line in lines + beside)
    words = f'<div style="margin-top:4px">{error_words(found, name)}</div>'
    return markup.box(body + words + markup.faint(off))


def _worst_words(shown: Picture, box: Box, colours: theme.Palette) -> list[str]:
    hues = (colours.model_1, colours.model_2)
    words = []
    for k, (mark, hue) in enumerate(zip(shown.worst, hues, strict=True)):
        if mark is not None:
            where = "" if box.has(mark) else f" at {markup.number(mark.value, 1)}°, beyond"
            words.append(f"{_dot(hue)}model {k + 1}{where}")
    return [" ".join(words)] if words else []


def _training_words(shown: Picture, box: Box, colours: theme.Palette) -> list[str]:
    count = len(shown.training)
    if count == 0:
        return []
    inside = int(box.holds(shown.training[:, 2]).sum())
    what = f"the {count} knees" if inside == count else f"{inside} of the {count} knees"
    return [f"{_dot(colours.baseline, 7)}{what} that the surrogate learned from"]

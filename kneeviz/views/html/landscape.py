"""The landscape's key: what is shown, and how far the surrogate is off."""

import numpy as np

from kneecore import Landscape, reading
from kneeviz.geometry.picture import Picture
from kneeviz.geometry.surfaces import Box, box_around
from kneeviz.views import theme
from kneeviz.views.html import marks, pieces


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
    if found.y_surrogate is None:
        return "There is no surrogate for these bounds: the true model alone is shown."
    error = reading(found.y_surrogate, name) - reading(found.y, name)
    size = np.abs(error[np.isfinite(error)])
    if len(size) == 0:
        return "The true model fails everywhere on this slice."
    return (
        f"Surrogate against true model on this slice: <b>{pieces.number(size.mean(), 2)}°</b> off "
        f"on average, <b>{pieces.number(size.max(), 2)}°</b> at worst."
    )


def landscape_key(
    found: Landscape, shown: Picture, name: str, colours: theme.Palette, *, zoom: bool
) -> str:
    """Return the landscape's key and the surrogate's error."""
    box = box_around(shown, zoom=zoom)
    failed = f", {found.n_failed} failed (holes)" if found.n_failed else ""
    marked = f", {told}" if (told := marks.counted(found.counts)) else ""
    became = f"{found.n_models:,} knees simulated{failed}{marked}"
    lines = [f"{_patch(colours.current)}true model: {became}"]
    if shown.surrogate is not None:
        lines.append(f"{_patch(colours.surrogate)}surrogate, asked for the same knees")
    own = f"{_dot(colours.current)}your knee"
    if shown.predicted is not None:
        own += f" {_dot(colours.surrogate, 7)}what the surrogate says of it"
    lines.append(own)
    beside = _worst_words(shown, box, colours) + _training_words(shown, box, colours)
    off = f"Both sheets have your knee's other {len(found.model.names) - 2} parameters."
    if beside:
        off += " Training knees and worst cases have their own: they lie off the sheets."
    body = "".join(f'<div style="line-height:1.5">{line}</div>' for line in lines + beside)
    words = f'<div style="margin-top:4px">{error_words(found, name)}</div>'
    return pieces.box(body + words + pieces.faint(off))


def _worst_words(shown: Picture, box: Box, colours: theme.Palette) -> list[str]:
    hues = (colours.model_1, colours.model_2)
    words = []
    for k, (mark, hue) in enumerate(zip(shown.worst, hues, strict=True)):
        if mark is not None:
            where = "" if box.has(mark) else f" at {pieces.number(mark.value, 1)}°, beyond"
            words.append(f"{_dot(hue)}model {k + 1}{where}")
    return [" ".join(words)] if words else []


def _training_words(shown: Picture, box: Box, colours: theme.Palette) -> list[str]:
    count = len(shown.training)
    if count == 0:
        return []
    inside = int(box.holds(shown.training[:, 2]).sum())
    what = f"the {count} knees" if inside == count else f"{inside} of the {count} knees"
    return [f"{_dot(colours.baseline, 7)}{what} that the surrogate learned from"]

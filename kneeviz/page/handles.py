"""Brings the handles of a page up to date with its knee and bounds."""

import numpy as np
from numpy.typing import NDArray

from kneeviz.geometry.handles import (
    DIGITS,
    HANDLES,
    Box,
    Handle,
    Loupe,
    corners,
    gain_for,
    loupe_around,
    place,
)
from kneeviz.geometry.mechanism import Pose
from kneeviz.page.page import Page
from kneeviz.state.handles import bound_name, box_of, scales, values_of, why_fixed
from kneeviz.views.html.hints import hints
from kneeviz.views.html.pieces import number
from kneeviz.views.scene.handles import hit_radius
from kneeviz.views.scene.loupe import LoupeShown

FloatArray = NDArray[np.float64]

_UNITS = {"geometry_mm": "mm", "slope_deg": "°"}


def are_shown(page: Page) -> bool:
    """Tell whether the handles are to be seen: not on a knee that moves by itself."""
    still = not page.playback.playing or bool(page.handles.grabs)
    return page.handles.wanted and still and not page.landscape.shown


def loupe_of(page: Page, handle: Handle, pose: Pose) -> Loupe:
    """Return the loupe in which a handle stands, magnified only if it is chosen or held."""
    grab, state = page.handles.grabs.get(handle.name), page.state
    if grab is not None:
        return grab.loupe
    now, values = place(handle, state.x, pose), values_of(state, handle)
    if handle is not page.handles.chosen or page.handles.opened_at is None:
        return loupe_around(now, values, values, 1.0)
    gain = gain_for(box_of(state, handle), now.directions)
    return loupe_around(now, values, page.handles.opened_at, gain)


def draw_handles(page: Page, pose: Pose | None) -> None:
    """Draw the handles of the visitor's knee in `pose`, or hide them."""
    view, state = page.view.handles, page.state
    if pose is None or not are_shown(page):
        view.hide()
        return
    boxes = [box_of(state, handle) for handle in HANDLES]
    points, small, chosen = [], [], None
    for i, (handle, box) in enumerate(zip(HANDLES, boxes, strict=True)):
        now, values = place(handle, state.x, pose), values_of(state, handle)
        loupe = loupe_of(page, handle, pose)
        points.append(loupe.at(values))
        small.append(corners(loupe_around(now, values, values, 1.0), box))
        if handle is page.handles.chosen:
            chosen = LoupeShown(
                number=i,
                corners=corners(loupe, box),
                text=_loupe_text(page, handle, box, loupe.gain),
                n_edges=0 if box.is_fixed else 2 * len(values),
            )
    fixed = np.array([box.is_fixed for box in boxes])
    spatial = page.view.scene.spatial
    view.draw(np.array(points), np.array(small), fixed, chosen, spatial=spatial)


def write_hints(page: Page) -> None:
    """Keep what each handle says under a pointer; the chosen one says it beside its loupe."""
    others = [handle for handle in HANDLES if handle is not page.handles.chosen]
    texts = {handle.name: _text(page, handle, box_of(page.state, handle)) for handle in others}
    size = page.view.colours.size
    page.view.hints.content = hints(texts, reach=hit_radius(size), size=size)


def _text(page: Page, handle: Handle, box: Box) -> str:
    """Return a handle's name, value and bound, for people, line by line."""
    state, unit = page.state, _UNITS[bound_name(handle)]
    if box.is_fixed:
        return f"{handle.label}\nheld fixed\n{why_fixed(state, handle)}"
    now = values_of(state, handle)
    lines = [
        f"{_axis(name)}{number(float(value), DIGITS, unit)}{_where(i, now, box)}"
        for i, (name, value) in enumerate(zip(handle.parameters, now / scales(handle), strict=True))
    ]
    half = float((0.5 * (box.high - box.low) / scales(handle)).max())
    return "\n".join([handle.label, *lines, f"bound \u00b1{number(half, DIGITS, unit)}"])


def _loupe_text(page: Page, handle: Handle, box: Box, gain: float) -> str:
    text = _text(page, handle, box)
    return text if box.is_fixed else f"{text}\n{gain:g}\u00d7 magnified"


def _axis(name: str) -> str:
    return f"{name[-1]} " if name.endswith(("_x", "_y")) else ""


def _where(i: int, now: FloatArray, box: Box) -> str:
    if now[i] == box.home[i]:
        return ", home"
    return ", at its bound" if now[i] in (box.low[i], box.high[i]) else ""

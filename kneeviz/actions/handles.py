"""Handles: a hand on the knee or on its bounds. Runs on the session's worker.

A drag is one change of the knee or the bounds: it begins in `_start` and ends in `_let_go`.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneeviz.actions.knee import change_bound, name_knee
from kneeviz.geometry.handles import BY_NAME, Handle, half_range_at, on_plane, settle
from kneeviz.jobs.messages import Asked
from kneeviz.page.handles import draw_handles, loupe_of
from kneeviz.page.page import Page
from kneeviz.state.handles import (
    Edge,
    Grab,
    bound_name,
    bound_now,
    box_of,
    scales,
    values_of,
    why_fixed,
)
from kneeviz.state.presets import OWN_KNEE
from kneeviz.views.scene.handles import depth_of

FloatArray = NDArray[np.float64]


def _pointed_at(page: Page, value: Asked, handle: Handle, which: str) -> FloatArray | None:
    """Return the place in the handle's plane that a hand points at; complain if there is none."""
    pointer, depth = value.value, depth_of(handle, page.view.scene.spatial)
    found = on_plane(pointer.eye, getattr(pointer, which), depth)
    if found is None:
        page.notices.complain(value.client_id, value.handle, f"{handle.label}: no place on screen")
    return found


def _start(page: Page, value: Asked, name: str, edge: Edge | None, client_id: int) -> None:
    handle, pose = BY_NAME[name], page.poses[0]
    taken_at = _pointed_at(page, value, handle, "start")
    if pose is None or taken_at is None or not _may_hold(page, handle, client_id):
        return
    _choose(page, value, name)
    state = page.state
    grab = Grab(
        client_id=client_id,
        handle=handle,
        edge=edge,
        loupe=loupe_of(page, handle, pose),
        taken_at=taken_at,
        values=np.array(values_of(state, handle)),
        knee=np.array(state.x),
        bounds=state.bounds,
        was_playing=page.playback.playing,
        over=box_of(state, handle).is_fixed,
    )
    page.handles.grabs[name] = grab
    page.playback.play(False)
    _update(page, value, name, edge, client_id)


def _may_hold(page: Page, handle: Handle, client_id: int) -> bool:
    """Tell whether nobody else holds a handle; who comes second is told so."""
    grab = page.handles.grabs.get(handle.name)
    if grab is None or grab.client_id == client_id or grab.client_id not in page.clients():
        return True
    page.notices.tell(client_id, "Not now", f"{handle.label} is in another visitor's hand.")
    return False


def _update(page: Page, value: Asked, name: str, edge: Edge | None, client_id: int) -> None:
    grab = page.handles.held_by(BY_NAME[name], client_id)
    if grab is None or grab.edge != edge or grab.over:
        return
    point = _pointed_at(page, value, grab.handle, "end")
    if point is None:
        return
    if edge is None:
        _move(page, grab, point)
    else:
        _move_edge(page, grab, point, edge)


def _move(page: Page, grab: Grab, point: FloatArray) -> None:
    """Give a handle's parameters the values that a hand means."""
    wanted = grab.values + grab.loupe.value_at(point) - grab.loupe.value_at(grab.taken_at)
    settled = settle(wanted, box_of(page.state, grab.handle), scales(grab.handle))
    _put(page, grab.handle, settled.value)


def _put(page: Page, handle: Handle, values: FloatArray) -> None:
    if not np.array_equal(values, values_of(page.state, handle)):
        page.put(dict(zip(handle.indices, values.tolist(), strict=True)))
        name_knee(page, OWN_KNEE)


def _move_edge(page: Page, grab: Grab, point: FloatArray, edge: Edge) -> None:
    """Give a handle's bound, which it shares with its group, the size that a hand means."""
    box, name = box_of(page.state, grab.handle), bound_name(grab.handle)
    widget, scale = page.view.knee.bounds[name], scales(grab.handle)[edge[0]]
    half = half_range_at(point, grab.loupe, box, edge) / scale
    # Never closed: a box of no size could not be taken hold of again.
    wanted = min(max(round(half / widget.step) * widget.step, widget.step), widget.max)
    wanted = round(wanted, 6)
    if wanted != bound_now(page.state, name):
        _set_bound(page, name, wanted, grab.client_id)


def _set_bound(page: Page, name: str, wanted: float | None, client_id: int) -> None:
    change_bound(page, name, wanted, client_id, in_hand=True)
    page.view.knee.bounds[name].value = round(bound_now(page.state, name), 4)
    draw_handles(page, page.poses[0])


def _end(page: Page, value: Asked, name: str, edge: Edge | None, client_id: int) -> None:
    _update(page, value, name, edge, client_id)
    grab = page.handles.held_by(BY_NAME[name], client_id)
    if grab is not None and grab.edge == edge:
        _let_go(page, grab)


def _let_go(page: Page, grab: Grab) -> None:
    """End a drag: the handle follows the knee again."""
    del page.handles.grabs[grab.handle.name]
    if grab.was_playing:
        page.playback.play(True)


def _choose(page: Page, value: Asked, name: str) -> None:
    """Open a handle's loupe; if it cannot be moved, say why."""
    handle = BY_NAME[name]
    page.handles.choose(handle, values_of(page.state, handle))
    if box_of(page.state, handle).is_fixed:
        why = why_fixed(page.state, handle)
        page.notices.tell(
            value.client_id, "It does not move", f"{handle.label} is held fixed: {why}."
        )


def _home(page: Page, value: Asked, name: str) -> None:
    """Give a handle's parameters the baseline's values."""
    handle = BY_NAME[name]
    if _may_hold(page, handle, value.client_id) and not box_of(page.state, handle).is_fixed:
        _put(page, handle, box_of(page.state, handle).home)


def _escape(page: Page, value: Asked) -> None:
    """Put back what this visitor's drags have changed; without one, close the loupe."""
    held = [g for g in page.handles.grabs.values() if g.client_id == value.client_id]
    for grab in held:
        _undo(page, grab)
    if not held:
        page.handles.leave()


def _undo(page: Page, grab: Grab) -> None:
    if grab.over:
        return
    grab.over = True
    if grab.edge is None:
        _put(page, grab.handle, grab.values)
        return
    name = bound_name(grab.handle)
    _set_bound(page, name, getattr(grab.bounds, name), grab.client_id)
    changed = np.flatnonzero(page.state.x != grab.knee)  # a narrower bound had drawn it in
    page.put({int(i): float(grab.knee[i]) for i in changed})


def _show(page: Page, value: Asked) -> None:
    page.handles.wanted = bool(value.value)


ACTIONS: dict[str, Callable[..., Any]] = {
    "grab_start": _start,
    "grab_update": _update,
    "grab_end": _end,
    "handle_choose": _choose,
    "handle_home": _home,
    "handle_escape": _escape,
    "handles": _show,
}

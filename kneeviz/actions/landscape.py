"""What a session does with the landscape. Runs on its worker."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from kneeviz.actions.view import leave_landscape, place_cameras, restore_cameras
from kneeviz.geometry.surfaces import Picture, picture
from kneeviz.state.landscape import free_names
from kneeviz.views import theme
from kneeviz.views.html import pieces as markup
from kneeviz.views.html import study as study_markup
from kneeviz.views.scene.landscape import LandscapeScene

if TYPE_CHECKING:
    from kneeviz.server.session import Session


def _toggle(session: "Session", value: Any) -> None:
    client_id = None if value is None else value.client_id
    set_landscape(session, not session.landscape.shown, client_id)


def set_landscape(session: "Session", shown: bool, client_id: int | None = None) -> None:
    """Put the landscape in the knee's place, or the knee back; or tell the client why not."""
    if shown == session.landscape.shown:
        return
    if not shown:
        leave_landscape(session)
        restore_cameras(session)
        return
    refused = None
    if session.state.current is None or not session.surrogate_ready:
        refused = "The model is still being prepared; try again in a moment."
    elif not session.landscape.fit_names(session.state.space):
        refused = "A landscape needs two parameters that the bounds let vary."
    if refused is None:
        _enter(session)
    elif client_id is not None:
        session.notices.tell(client_id, "Not now", refused)


def _enter(session: "Session") -> None:
    show, view = session.landscape, session.view
    if view.landscape is None:
        view.landscape = LandscapeScene(session.target.scene)
        view.landscape.paint(theme.palette(view.dark))
    show.cameras = {
        number: (client.camera.position, client.camera.look_at)
        for number, client in session.clients().items()
    }
    show.shown = True
    view.scene.set_hidden(True)
    view.landscape.set_visible(True)
    view.study.show_landscape(True)
    place_cameras(session)
    refresh(session)


def refresh(session: "Session") -> None:
    """Bring the landscape up to date, if it is shown."""
    show = session.landscape
    if not show.shown:
        return
    show.ask(session.state)
    _mirror_axes(session)
    _draw(session)


def _mirror_axes(session: "Session") -> None:
    options = tuple(study_markup.with_unit(name) for name in free_names(session.state.space))
    for handle, name in zip(session.view.study.axes, session.landscape.names, strict=True):
        label = study_markup.with_unit(name)
        if tuple(handle.options) != options:
            handle.options = options
        if label in options and handle.value != label:
            handle.value = label


def _draw(session: "Session") -> None:
    show, view = session.landscape, session.view
    if show.found is None or view.landscape is None:
        return
    state = session.state
    made_of = (
        show.found,
        show.height,
        show.zoom,
        view.dark,
        state.result,
        session.is_stale(),
    )
    if made_of == show.drawn:
        return
    show.drawn = made_of
    shown = _picture(session)
    colours = theme.palette(view.dark)
    view.landscape.paint(colours)
    title = study_markup.height_title(show.height)
    with session.target.atomic():
        view.landscape.draw(shown, title=title, zoom=show.zoom)
    view.study.key.content = study_markup.landscape_key(
        show.found[1], shown, show.height, colours, zoom=show.zoom
    )


def _picture(session: "Session") -> Picture:
    assert session.landscape.found is not None
    asked, found = session.landscape.found
    state, worst = session.state, []
    # Older bounds are another box: their worst cases have no place in this one.
    if state.result is not None and not session.is_stale():
        pair = (k for k in state.worst if k is not None)
        worst = [(k.x, np.degrees(k.response.flexion)) for k in pair]
    return picture(
        found,
        session.landscape.height,
        own_deg=asked.own_deg,
        predicted_deg=asked.predicted_deg,
        surrogate=asked.surrogate,
        worst=worst,
    )


def _found(session: "Session", value: Any) -> None:
    asked, found, why = value
    if found is None:
        session.say(f"There is no landscape: {markup.escape(why)}", "bad")
        return
    session.landscape.found = (asked, found)
    if session.landscape.shown:
        _draw(session)


def _axis(session: "Session", value: Any, axis: int) -> None:
    by_label = {study_markup.with_unit(name): name for name in free_names(session.state.space)}
    if value.value in by_label:
        session.landscape.choose(axis, by_label[value.value])
    refresh(session)


def _look(session: "Session", value: Any, what: str) -> None:
    if what == "height":
        session.landscape.height = study_markup.HEIGHTS[value.value]
    else:
        session.landscape.zoom = bool(value.value)
    refresh(session)


DEEDS: dict[str, Callable[..., None]] = {
    "landscape": _toggle,
    "landscape_axis": _axis,
    "landscape_look": _look,
    "landscape_found": _found,
}

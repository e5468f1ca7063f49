"""The landscape in the knee's place. Runs on the session's worker."""

import time
from collections.abc import Callable

import numpy as np

from kneeviz.actions.view import leave_landscape
from kneeviz.geometry.picture import Picture, picture
from kneeviz.jobs.messages import Asked
from kneeviz.page import belonging
from kneeviz.page.page import Page
from kneeviz.state.landscape import LandscapeFound, free_names
from kneeviz.state.origin import of_found
from kneeviz.views import theme
from kneeviz.views.html.labels import HEIGHTS, height_title, with_unit
from kneeviz.views.html.landscape import landscape_key
from kneeviz.views.html.pieces import escape
from kneeviz.views.scene.landscape import LandscapeScene


def _toggle(page: Page, value: Asked | None) -> None:
    client_id = None if value is None else value.client_id
    set_landscape(page, not page.landscape.shown, client_id)


def set_landscape(page: Page, shown: bool, client_id: int | None = None) -> None:
    """Put the landscape in the knee's place, or the knee back; or tell the client why not."""
    if shown == page.landscape.shown:
        return
    if not shown:
        leave_landscape(page)
        page.framing.put_back(page.landscape.cameras, page.subject, time.monotonic())
        return
    refused = None
    if page.state.current is None or not page.surrogate_ready:
        refused = "The model is still being prepared; try again in a moment."
    elif not page.landscape.fit_names(page.state.space):
        refused = "A landscape needs two parameters that the bounds let vary."
    if refused is None:
        _enter(page)
    elif client_id is not None:
        page.notices.tell(client_id, "Not now", refused)


def _enter(page: Page) -> None:
    show, view = page.landscape, page.view
    if view.landscape is None:
        view.landscape = LandscapeScene(page.target.scene)
        view.landscape.paint(view.colours)
    now = time.monotonic()
    show.cameras = page.framing.moved_by_visitors(now)
    show.shown = True
    view.scene.set_hidden(True)
    view.landscape.set_visible(True)
    view.study.show_landscape(True)
    page.framing.reset(page.subject, now)
    refresh(page)


def refresh(page: Page) -> None:
    """Bring the landscape up to date, if it is shown."""
    show = page.landscape
    if not show.shown:
        return
    show.ask(page.state)
    _mirror_axes(page)
    _draw(page)


def _mirror_axes(page: Page) -> None:
    options = tuple(with_unit(name) for name in free_names(page.state.space))
    for handle, name in zip(page.view.study.axes, page.landscape.names, strict=True):
        label = with_unit(name)
        if tuple(handle.options) != options:
            handle.options = options
        if label in options and handle.value != label:
            handle.value = label


def _draw(page: Page) -> None:
    show, view = page.landscape, page.view
    if show.found is None or view.landscape is None:
        return
    made_of = (
        show.found,
        show.height,
        show.zoom,
        view.dark,
        page.state.result,
        belonging.changed(page, belonging.LANDSCAPE),
    )
    if made_of == show.drawn:
        return
    show.drawn = made_of
    shown = picture_of(page)
    title = height_title(show.height)
    with page.target.atomic():
        labels = (with_unit(shown.names[0]), with_unit(shown.names[1]))
        view.landscape.draw(shown, title=title, labels=labels, zoom=show.zoom)
    colours = theme.palette(view.dark)
    key = landscape_key(show.found[1], shown, show.height, colours, zoom=show.zoom)
    belonging.write(page, "study.key", key)


def picture_of(page: Page) -> Picture:
    """Return what the landscape shows: the grid, the visitor's knee and the worst cases."""
    assert page.landscape.found is not None
    asked, found = page.landscape.found
    state, worst = page.state, []
    # Worst cases of other bounds have no place in this box.
    if state.result is not None and of_found(state.result).same_box(asked.origin):
        pair = (k for k in state.worst if k is not None)
        worst = [(k.x, np.degrees(k.response.flexion)) for k in pair]
    return picture(
        found,
        page.landscape.height,
        own_deg=asked.own_deg,
        predicted_deg=asked.predicted_deg,
        surrogate=asked.surrogate,
        worst=worst,
    )


def _found(page: Page, value: LandscapeFound) -> None:
    asked, found, why = value
    if asked is None or found is None:
        page.say(f"There is no landscape: {escape(str(why))}", "bad")
        return
    page.landscape.found = (asked, found)
    if page.landscape.shown:
        _draw(page)


def _axis(page: Page, value: Asked, axis: int) -> None:
    by_label = {with_unit(name): name for name in free_names(page.state.space)}
    if value.value in by_label:
        page.landscape.choose(axis, by_label[value.value])
    refresh(page)


def _look(page: Page, value: Asked, what: str) -> None:
    if what == "height":
        page.landscape.height = HEIGHTS[value.value]
    else:
        page.landscape.zoom = bool(value.value)
    refresh(page)


ACTIONS: dict[str, Callable[..., None]] = {
    "landscape": _toggle,
    "landscape_axis": _axis,
    "landscape_look": _look,
    "landscape_found": _found,
}

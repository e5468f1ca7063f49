"""The knee: sliders, presets, bounds, a new baseline. Runs on the session's worker."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from kneecore import KneecoreError, KneeFile, parameter_table
from kneecore.knee.parameters import widened
from kneeviz import viser_internals
from kneeviz.jobs.messages import Asked
from kneeviz.page.page import Page
from kneeviz.state import results
from kneeviz.state.bounds import WIDTH, shown_bounds, with_bound
from kneeviz.state.presets import (
    BASELINE,
    OWN_KNEE,
    PRESETS,
    RANDOM,
    WORST,
    preset_knee,
    random_knee,
)
from kneeviz.views.html.pieces import escape
from kneeviz.views.tabs.knee import group_of

_WIDTHS = ("geometry_mm", "slope_deg", "material_percent")
"""Bounds that only make the box wider or narrower."""
_REST_SECONDS = 0.25


def _ready(page: Page, _value: Any, what: str) -> None:
    state = page.state
    if what == "model":
        page.model_ready = True
        state.solve_baseline()
        page.show_knee(state.x, final=True)
        page.say("Preparing the surrogate …", "busy")
        return
    if what == "exact":
        page.exact_ready = True
        return
    page.surrogate_ready = True
    page.refit()
    page.say("Ready.")


def _not_ready(page: Page, value: Any, _rest: Any = None) -> None:
    page.say(f"The model cannot be prepared: {escape(str(value))}", "bad")


def _param(page: Page, value: Asked, index: int) -> None:
    page.set_parameter(index, float(value.value))
    name_knee(page, OWN_KNEE)


def name_knee(page: Page, name: str) -> None:
    """Let the list of knees say whose the visitor's is, if it has that name."""
    handle = page.view.knee.preset
    if name in handle.options and handle.value != name:
        handle.value = name


def _preset(page: Page, value: Asked) -> None:
    choose_preset(page, value.value)


def choose_preset(page: Page, name: str) -> None:
    """Make one of the list's knees the visitor's."""
    state = page.state
    if name == OWN_KNEE:
        return
    if name == BASELINE:
        x = np.array(state.space.baseline)
    elif name == RANDOM:
        x = random_knee(state.space, page.rng)
    elif name in WORST and state.result is not None:
        x = results.knees(state.result)[WORST.index(name)][0]
    elif name in PRESETS:
        x = preset_knee(name, state.space)
    else:
        return
    page.move_to(x)
    name_knee(page, name)


def _reset_all(page: Page, _value: Any) -> None:
    choose_preset(page, BASELINE)


def _reset_group(page: Page, _value: Any, group: str) -> None:
    x, baseline = np.array(page.state.x), widened(page.state.space.baseline, WIDTH)
    for i, row in enumerate(parameter_table(rest_lengths=True)):
        if group == group_of(row):
            x[i] = baseline[i]
    page.move_to(x)
    name_knee(page, OWN_KNEE)


def _bound(page: Page, value: Asked, name: str) -> None:
    client_id, state = value.client_id, page.state
    live, x = page.live.on and name in _WIDTHS, state.x
    try:
        state.set_bounds(with_bound(state.bounds, name, value.value), keep_surrogate=live)
    except KneecoreError as error:
        page.notices.tell(client_id, "Bounds not changed", str(error))
        mirror_bounds(page)
        return
    if live:  # the worst case goes first; the rest waits for the hand to rest
        page.settle_at = time.monotonic() + _REST_SECONDS
        page.held = True
        if not np.array_equal(state.x, x):
            page.show_knee(state.x, final=True)
        return
    if page.model_ready:
        state.solve_baseline()
        page.show_knee(state.x, final=True)
    _settle(page, value)


def _settle(page: Page, value: Asked | None) -> None:
    """Bring sliders and surrogate to bounds that were changed."""
    page.settle_at = None
    page.mirror_sliders()
    refit(page, None if value is None else value.client_id)


def refit(page: Page, client_id: int | None) -> None:
    """Fit the surrogate to the present bounds; if there is none, say so."""
    try:
        page.refit()
    except KneecoreError as error:
        page.say("There is no surrogate for these bounds.", "bad")
        if client_id is not None:
            page.notices.tell(client_id, "No surrogate", str(error))


def mirror_bounds(page: Page) -> None:
    """Let the bounds' widgets show the present ones, also in a browser that missed something."""
    state, tab = page.state, page.view.knee
    now = state.bounds
    given = (now.geometry_mm, now.slope_deg, now.material_percent, now.rest_length_mm)
    for handle, value, own in zip(
        tab.bounds.values(), given, shown_bounds(state.knee), strict=True
    ):
        wanted = round(own if value is None else value, 4)
        if handle.value != wanted:
            handle.value = wanted
        else:
            viser_internals.force_value(page.target.gui, handle)
    tab.case.value, tab.rest_length.value = state.bounds.case, state.bounds.rest_length


def load_knee(page: Page, knee: KneeFile) -> None:
    """Take a knee file: baseline, half-ranges and, if it has them, current values."""
    state = page.state
    state.set_knee(knee)
    mirror_bounds(page)
    page.mirror_sliders()
    if page.model_ready:
        state.solve_baseline()
        page.show_knee(state.x, final=True)
    refit(page, None)
    name_knee(page, OWN_KNEE)


ACTIONS: dict[str, Callable[..., None]] = {
    "ready": _ready,
    "not_ready": _not_ready,
    "param": _param,
    "preset": _preset,
    "reset_all": _reset_all,
    "reset_group": _reset_group,
    "bound": _bound,
    "settle": _settle,
}

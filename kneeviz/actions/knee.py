"""What a session does with its knee: sliders, presets, bounds, a new baseline. On its worker."""

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from kneecore import Knee, KneecoreError, parameter_table
from kneecore.knee.parameters import widened
from kneeviz import viser_internals as wire
from kneeviz.actions.result import show_result
from kneeviz.state.knee import PRESETS, WIDTH, preset_knee, random_knee, shown_bounds, with_bound
from kneeviz.views.html import pieces as markup
from kneeviz.views.tabs import controls

if TYPE_CHECKING:
    from kneeviz.server.session import Session


_WIDTHS = ("geometry_mm", "slope_deg", "material_percent")
"""Bounds that only make the box wider or narrower."""
_REST_SECONDS = 0.25


def _ready(session: "Session", _value: Any, what: str) -> None:
    state = session.state
    if what == "model":
        session.model_ready = True
        state.solve_baseline()
        session.show_knee(state.x, final=True)
        session.say("Preparing the surrogate …", "busy")
        return
    if what == "exact":
        session.exact_ready = True
        return
    session.surrogate_ready = True
    session.refit()
    session.say("Ready.")


def _not_ready(session: "Session", value: Any, _rest: Any = None) -> None:
    session.say(f"The model cannot be prepared: {markup.escape(str(value))}", "bad")


def _param(session: "Session", value: Any, index: int) -> None:
    session.set_parameter(index, float(value.value))
    _name_knee(session, controls.OWN_KNEE)


def _name_knee(session: "Session", name: str) -> None:
    handle = session.view.knee.preset
    if name in handle.options and handle.value != name:
        handle.value = name


def _preset(session: "Session", value: Any) -> None:
    choose_preset(session, value.value)


def choose_preset(session: "Session", name: str) -> None:
    """Make one of the list's knees the visitor's."""
    state = session.state
    if name == controls.OWN_KNEE:
        return
    if name == controls.BASELINE:
        x = np.array(state.space.baseline)
    elif name == controls.RANDOM:
        x = random_knee(state.space, session.rng)
    elif name in controls.WORST and state.result is not None:
        x = np.array(state.result.x[controls.WORST.index(name)])
    elif name in PRESETS:
        x = preset_knee(name, state.space)
    else:
        return
    session.move_to(x)
    _name_knee(session, name)


def _reset_all(session: "Session", _value: Any) -> None:
    choose_preset(session, controls.BASELINE)


def _reset_group(session: "Session", _value: Any, group: str) -> None:
    x, baseline = np.array(session.state.x), widened(session.state.space.baseline, WIDTH)
    for i, row in enumerate(parameter_table(rest_lengths=True)):
        if group == (controls.REST if row.kind == "rest length" else row.group):
            x[i] = baseline[i]
    session.move_to(x)
    _name_knee(session, controls.OWN_KNEE)


def _bound(session: "Session", value: Any, name: str) -> None:
    client_id, state = value.client_id, session.state
    live, x = session.live.on and name in _WIDTHS, state.x
    try:
        state.set_bounds(with_bound(state.bounds, name, value.value), keep_surrogate=live)
    except KneecoreError as error:
        session.notices.tell(client_id, "Bounds not changed", str(error))
        _mirror_bounds(session)
        return
    if live:  # the worst case goes first; the rest waits for the hand to rest
        session.settle_at = time.monotonic() + _REST_SECONDS
        session.hold()
        if not np.array_equal(state.x, x):
            session.show_knee(state.x, final=True)
        return
    session.show_band(None)  # it was that of the old bounds
    if session.model_ready:
        state.solve_baseline()
        session.show_knee(state.x, final=True)
    _settle(session, value)


def _settle(session: "Session", value: Any) -> None:
    """Bring sliders and surrogate to bounds that were changed."""
    session.settle_at = None
    session.mirror_sliders()
    _refit(session, None if value is None else value.client_id)
    show_result(session)


def _refit(session: "Session", client_id: int | None) -> None:
    try:
        session.refit()
    except KneecoreError as error:
        session.say("There is no surrogate for these bounds.", "bad")
        if client_id is not None:
            session.notices.tell(client_id, "No surrogate", str(error))


def _mirror_bounds(session: "Session") -> None:
    state, tab = session.state, session.view.knee
    now = state.bounds
    given = (now.geometry_mm, now.slope_deg, now.material_percent, now.rest_length_mm)
    for handle, value, own in zip(
        tab.bounds.values(), given, shown_bounds(state.knee), strict=True
    ):
        wanted = round(own if value is None else value, 4)
        if handle.value != wanted:
            handle.value = wanted
        else:
            wire.force_value(session.target.gui, handle)
    tab.case.value, tab.rest_length.value = state.bounds.case, state.bounds.rest_length


def load_knee(session: "Session", knee: Knee) -> None:
    """Take a knee file: baseline, half-ranges and, if it has them, current values."""
    state = session.state
    result, worst = state.result, state.worst
    state.set_knee(knee)
    state.result, state.worst = result, worst
    session.show_band(None)
    _mirror_bounds(session)
    session.mirror_sliders()
    if session.model_ready:
        state.solve_baseline()
        session.show_knee(state.x, final=True)
    _refit(session, None)
    _name_knee(session, controls.OWN_KNEE)
    show_result(session)


DEEDS: dict[str, Callable[..., None]] = {
    "ready": _ready,
    "not_ready": _not_ready,
    "param": _param,
    "preset": _preset,
    "reset_all": _reset_all,
    "reset_group": _reset_group,
    "bound": _bound,
    "settle": _settle,
}

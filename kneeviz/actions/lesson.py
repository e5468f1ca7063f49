"""What a session does in the lesson. Runs on its worker."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from kneeviz.actions.knee import choose_preset
from kneeviz.actions.landscape import set_landscape
from kneeviz.actions.search import start_search
from kneeviz.actions.view import set_forces, set_mode, set_overlay, set_playing
from kneeviz.views.tabs import controls
from kneeviz.views.tabs.learn import STEPS

if TYPE_CHECKING:
    from kneeviz.server.session import Session


def _lesson_press(session: "Session", value: Any) -> None:
    if session.lesson is None:
        open_step(session, 0)
        return
    for deed in STEPS[session.lesson].press:
        stage(session, deed, None if value is None else value.client_id)


def _lesson_turn(session: "Session", value: Any) -> None:
    at = -1 if session.lesson is None else session.lesson
    to = at + (1 if value.value == "Next" else -1)
    if 0 <= to < len(STEPS):
        open_step(session, to)
    else:
        session.lesson = None
        session.view.learn.show(None)


def open_step(session: "Session", number: int) -> None:
    """Open a step of the lesson and set its stage."""
    session.lesson = number
    session.view.learn.show(number)
    for deed in STEPS[number].stage:
        stage(session, deed, None)


def stage(session: "Session", deed: tuple[Any, ...], client_id: int | None) -> None:
    """Do one thing on the lesson's stage."""
    name, *rest = deed
    simple: dict[str, Callable[..., None]] = {
        "overlay": set_overlay,
        "mode": set_mode,
        "forces": set_forces,
        "play": set_playing,
        "preset": choose_preset,
    }
    if name in simple:
        simple[name](session, *rest)
    elif name == "baseline":
        choose_preset(session, controls.BASELINE)
    elif name in ("moment", "glide"):
        session.glide_to(*rest)
    elif name == "search":
        start_search(session, "surrogate", client_id)
    elif name == "landscape":
        set_landscape(session, bool(rest[0]), client_id)


DEEDS: dict[str, Callable[..., None]] = {
    "lesson_press": _lesson_press,
    "lesson_turn": _lesson_turn,
}

"""How a session follows its bounds and sliders with the worst case. Runs on its worker."""

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from kneecore import KneecoreError
from kneeviz.actions.result import show_result, take_result
from kneeviz.jobs.live_worst_case import LiveAnswer, LiveSettings
from kneeviz.views.html import pieces as markup

if TYPE_CHECKING:
    from kneeviz.server.session import Session

SLOW_SECONDS = 0.3
"""After this long without an answer the page says that it is still looking."""


class Live:
    """Whether a session follows, and what it has asked for last."""

    def __init__(self) -> None:
        self.on = False
        self.slow = False
        """Whether the page says that the answer takes long."""
        self.shown = False
        """Whether an answer is on the page."""
        self.slow_at: float | None = None
        """When to say that the answer takes long, s of `time.monotonic`; None if it is there."""
        self._asked: tuple[Any, ...] | None = None

    @property
    def keeps_up(self) -> bool:
        """Whether what the page shows is, but for a moment, that of the present bounds."""
        return self.on and self.shown and not self.slow

    def is_new(self, wanted: tuple[Any, ...]) -> bool:
        """Tell whether `wanted` has not been asked for yet, and remember it."""
        if wanted == self._asked:
            return False
        self._asked = wanted
        return True

    def wait(self) -> None:
        """Note that an answer is on its way."""
        if self.slow_at is None and not self.slow:
            self.slow_at = time.monotonic() + SLOW_SECONDS

    def arrived(self) -> None:
        """Note that it is there."""
        self.slow, self.slow_at = False, None


def follow(session: "Session") -> float | None:
    """Ask for the worst case of what is set now, unless that was asked already.

    Returns when to be called again to say that the answer takes long, s of `time.monotonic`.
    """
    live, state = session.live, session.state
    if not live.on or not session.exact_ready:
        return None
    tab = session.view.search
    objective, seed = tab.objective.value, round(tab.seed.value)
    bounds = (state.space, state.bounds.rest_length)  # a space is equal to itself alone
    if live.is_new((*bounds, state.x.tobytes(), objective, seed)):
        _ask(session, objective, seed)
    if live.slow_at is not None and time.monotonic() >= live.slow_at:
        live.slow, live.slow_at = True, None
        session.show_band(None)
        show_result(session)
        _tell(session, "Bounds this wide take longer. Looking for their worst case …")
    return live.slow_at


def _ask(session: "Session", objective: Any, seed: int) -> None:
    state = session.state
    try:
        space = state.space_around_knee()
    except KneecoreError as error:
        session.live_search.forget()
        _give_up(session, str(error))
        return
    session.live.wait()
    session.live_search.ask(
        LiveSettings(
            space=space, rest_length=state.bounds.rest_length, objective=objective, seed=seed
        )
    )


def _tell(session: "Session", text: str) -> None:
    session.view.search.live_note.content = markup.box(markup.faint(text))


def _give_up(session: "Session", why: str) -> None:
    """Say that there is no worst case here; what belongs to other bounds is not left standing."""
    session.live.arrived()
    session.live.shown = False
    session.show_band(None)
    session.show_overlay(False)
    show_result(session)
    _tell(session, f"No worst case to show: {markup.escape(why[:200])}")


def _live(session: "Session", value: Any) -> None:
    set_live(session, bool(value.value))


def set_live(session: "Session", on: bool) -> None:
    """Follow from now on, or no more: then the last two knees stay as a search's result."""
    tab = session.view.search
    if tab.live.value != on:
        tab.live.value = on
    if on == session.live.on:
        return
    session.live = Live()
    session.live.on = on
    if on:
        ready = session.exact_ready
        _tell(session, "Looking for the worst case …" if ready else "Being prepared …")
        session.say("Live: model 1 is blue, model 2 orange.")
        return
    session.live_search.forget()
    session.show_band(None)
    show_result(session)
    tab.live_note.content = ""


def _live_found(session: "Session", value: tuple[LiveSettings, LiveAnswer | None, Any]) -> None:
    settings, answer, why = value
    live = session.live
    if not live.on:
        return
    if session.live_search.is_latest(settings):
        live.arrived()
        if answer is None:
            _give_up(session, why)
    if answer is None:
        return
    session.show_band(answer.band)
    first, live.shown = not live.shown, True
    take_result(session, answer.result, reveal=first)
    _tell(session, markup.live_note(answer.band.text))


def _live_settings(_session: "Session", _value: Any) -> None:
    """Wake the worker, which then follows."""


DEEDS: dict[str, Callable[..., None]] = {
    "live": _live,
    "live_settings": _live_settings,
    "live_found": _live_found,
}

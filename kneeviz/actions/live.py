"""The worst case that follows bounds and sliders. Runs on the session's worker."""

import time
from collections.abc import Callable

from kneecore import Knee, KneecoreError, SearchSettings
from kneeviz.actions.result import take_result
from kneeviz.jobs.live_search import LiveFound
from kneeviz.jobs.live_worst_case import LiveRequest
from kneeviz.jobs.messages import Asked
from kneeviz.page.page import Page
from kneeviz.state.live import LiveState, live_band
from kneeviz.views.html.pieces import box, escape, faint
from kneeviz.views.html.result import IMPROVING_NOTE, live_note


def follow(page: Page) -> float | None:
    """Ask for the worst case of what is set now, unless that was asked already.

    Returns when to be called again to say that the answer takes long, s of `time.monotonic`.
    """
    live, state = page.live, page.state
    if not live.on or not page.exact_ready:
        return None
    tab = page.view.search
    objective, seed = tab.options.value("objective"), tab.options.value("seed")
    bounds = (state.space, state.bounds.rest_length)  # a space is equal to itself alone
    if live.is_new((*bounds, state.x.tobytes(), objective, seed)):
        _ask(page, objective, seed)
    if live.slow_at is not None and time.monotonic() >= live.slow_at:
        live.slow, live.slow_at = True, None
        page.show_band(None)
        _tell(page, "Bounds this wide take longer. Looking for their worst case …")
    return live.slow_at


def _ask(page: Page, objective: str, seed: int) -> None:
    state = page.state
    try:
        space = state.space_around_knee()
    except KneecoreError as error:
        page.live_search.forget()
        _give_up(page, str(error))
        return
    page.live.wait()
    # One thread: its batches are too small for two, and the other core draws.
    knee = Knee(space, solver="equilibrium", rest_length=state.bounds.rest_length, threads=1)
    search = SearchSettings(method="exact", objective=objective, seed=seed)
    page.live_search.ask(LiveRequest(knee=knee, search=search))


def _tell(page: Page, text: str) -> None:
    page.view.search.live_note.content = box(faint(text))


def _give_up(page: Page, why: str) -> None:
    """Say that there is no worst case here; what belongs to other bounds is not left standing."""
    page.live.arrived()
    page.live.shown = False
    page.show_band(None)
    page.show_overlay(False)
    _tell(page, f"No worst case to show: {escape(why[:200])}")


def _live(page: Page, value: Asked) -> None:
    set_live(page, bool(value.value))


def set_live(page: Page, on: bool) -> None:
    """Follow from now on, or no more: then the last two knees stay as a search's result."""
    tab = page.view.search
    if tab.live.value != on:
        tab.live.value = on
    if on == page.live.on:
        return
    page.live = LiveState()
    page.live.on = on
    if on:
        gave_way = page.state.result is not None
        ready = page.exact_ready
        _tell(page, "Looking for the worst case …" if ready else "Being prepared …")
        replaced = " The last search's pair made way; Undo brings it back." if gave_way else ""
        page.say(f"Live: model 1 is blue, model 2 orange.{replaced}")
        return
    page.live_search.forget()
    page.show_band(None)
    tab.live_note.content = ""
    page.say("Live is off: its last pair stands.")


def _live_found(page: Page, value: LiveFound) -> None:
    request, answer, why = value
    live = page.live
    if not live.on:
        return
    if page.live_search.is_latest(request):
        live.arrived()
        if answer is None:
            _give_up(page, str(why))
    if answer is None:
        return
    live.improving = answer.improving
    band = None if answer.sampled is None else live_band(answer.sampled)
    page.show_band(band)
    first, live.shown = not live.shown, True
    take_result(page, answer.result, reveal=first)
    _tell(page, IMPROVING_NOTE if band is None else live_note(band.text))


ACTIONS: dict[str, Callable[..., None]] = {
    "live": _live,
    "live_found": _live_found,
}

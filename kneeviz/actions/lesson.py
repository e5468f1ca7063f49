"""The lesson. Runs on the session's worker."""

from collections.abc import Callable
from typing import Any

from kneecore import packaged_knee
from kneecore.knee.parameters import widened
from kneeviz.actions import undo
from kneeviz.actions.knee import choose_preset
from kneeviz.actions.landscape import set_landscape
from kneeviz.actions.search import start_search, stop_search
from kneeviz.actions.view import set_forces, set_mode, set_overlay, set_playing
from kneeviz.jobs.messages import Asked
from kneeviz.page.page import Page
from kneeviz.state.bounds import WIDTH, Bounds
from kneeviz.state.lesson import Answers, SetAside
from kneeviz.state.lesson_facts import FACTS
from kneeviz.state.lesson_steps import BEGUN, NOTHING, OVER, STEPS
from kneeviz.state.snapshot import Snapshot


def _lesson_press(page: Page, value: Asked | None) -> None:
    if page.lesson is None:
        _begin(page)
    else:
        _reveal(page, None if value is None else value.client_id)


def _reveal(page: Page, client_id: int | None) -> None:
    """Do what the open step shows, and tell what was seen as soon as it is known."""
    assert page.lesson is not None
    if not page.surrogate_ready:
        if client_id is not None:
            text = "The model is still being prepared; try again in a moment."
            page.notices.tell(client_id, "Not now", text)
        return
    for instruction in STEPS[page.lesson].on_press:
        follow(page, instruction, client_id)
    page.answers.waiting = True
    tell(page)


def tell(page: Page) -> None:
    """Tell what a revealed step has shown, if that is still to be told and known by now."""
    if page.lesson is None or not page.answers.waiting:
        return
    fact = FACTS[STEPS[page.lesson].name](page.state)
    if fact is not None:
        page.answers.reveal(page.lesson, fact)
    elif page.search.job is None:
        page.answers.waiting = False
        page.say(NOTHING, "bad")
    page.view.learn.show(page.lesson, page.answers)
    page.touched = True


def _lesson_choice(page: Page, _value: Asked, place: int) -> None:
    if page.lesson is not None and place < len(STEPS[page.lesson].choices):
        page.answers.give(page.lesson, place)
        page.view.learn.show(page.lesson, page.answers)


def _lesson_number(page: Page, value: Asked) -> None:
    # Its widget shows it already: to write there would put back what is typed on meanwhile.
    if page.lesson is not None and not STEPS[page.lesson].choices:
        page.answers.give(page.lesson, float(value.value))


def _lesson_turn(page: Page, value: Asked) -> None:
    by = 1 if value.value == "Next" else -1
    if page.lesson is None:
        if by > 0:
            _begin(page)
    elif 0 <= page.lesson + by < len(STEPS):
        open_step(page, page.lesson + by)
    else:
        _end(page)


def _begin(page: Page) -> None:
    """Open the first step, the visitor's state put aside: the lesson has one of its own."""
    page.set_aside = SetAside(
        state=page.snapshot(),
        history=page.history,
        mode=page.playback.mode,
        forces=page.view.scene.forces,
        playing=page.playback.playing,
        share=page.playback.share,
        landscape=page.landscape.shown,
        band=page.study.with_band,
    )
    page.study.with_band = False
    page.answers = Answers()
    _clean(page)
    page.begin()
    open_step(page, 0)
    page.say(BEGUN)


def _end(page: Page) -> None:
    """Give the visitor back what he had."""
    page.lesson = None
    page.view.learn.show(None, page.answers)
    aside, page.set_aside = page.set_aside, None
    if aside is None:
        return
    stop_search(page)
    undo.restore(page, aside.state)
    page.history, page.study.with_band = aside.history, aside.band
    set_landscape(page, aside.landscape)
    set_mode(page, aside.mode)
    set_forces(page, aside.forces)
    set_playing(page, aside.playing)
    page.playback.set_share(aside.share)
    page.say(OVER)


def _clean(page: Page) -> None:
    """Show the packaged knee within its own bounds, and no result: nothing is told too early."""
    stop_search(page)
    knee = packaged_knee()
    clean = Snapshot(
        knee=knee,
        bounds=Bounds(),
        x=widened(knee.baseline, WIDTH),
        settings=page.view.first_settings,
    )
    undo.restore(page, clean)


def _show_pair(page: Page, client_id: int | None) -> None:
    """Show both worst cases; search for them if that was skipped."""
    if page.state.result is None:
        start_search(page, "surrogate", client_id)
    else:
        set_overlay(page, True)


def open_step(page: Page, number: int) -> None:
    """Open a step of the lesson and do what it opens with."""
    page.lesson = number
    page.answers.open()
    page.view.learn.show(number, page.answers)
    page.touched = True
    for instruction in STEPS[number].on_open:
        follow(page, instruction, None)


def follow(page: Page, instruction: tuple[Any, ...], client_id: int | None) -> None:
    """Do one thing that a step asks for."""
    name, *rest = instruction
    simple: dict[str, Callable[..., None]] = {
        "mode": set_mode,
        "forces": set_forces,
        "play": set_playing,
        "preset": choose_preset,
    }
    if name in simple:
        simple[name](page, *rest)
    elif name == "clean":
        _clean(page)
    elif name == "pair":
        _show_pair(page, client_id)
    elif name in ("moment", "glide"):
        page.glide_to(*rest)
    elif name == "search":
        start_search(page, "surrogate", client_id)
    elif name == "landscape":
        set_landscape(page, bool(rest[0]), client_id)


ACTIONS: dict[str, Callable[..., None]] = {
    "lesson_press": _lesson_press,
    "lesson_turn": _lesson_turn,
    "lesson_choice": _lesson_choice,
    "lesson_number": _lesson_number,
}

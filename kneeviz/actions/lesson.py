"""The lesson. Runs on the session's worker."""

from collections.abc import Callable
from typing import Any

from kneeviz.actions.knee import choose_preset
from kneeviz.actions.landscape import set_landscape
from kneeviz.actions.search import start_search
from kneeviz.actions.view import set_forces, set_mode, set_overlay, set_playing
from kneeviz.jobs.messages import Asked
from kneeviz.page.page import Page
from kneeviz.state.presets import BASELINE
from kneeviz.views.tabs.learn import STEPS


def _lesson_press(page: Page, value: Asked | None) -> None:
    if page.lesson is None:
        open_step(page, 0)
        return
    for instruction in STEPS[page.lesson].on_press:
        follow(page, instruction, None if value is None else value.client_id)


def _lesson_turn(page: Page, value: Asked) -> None:
    at = -1 if page.lesson is None else page.lesson
    to = at + (1 if value.value == "Next" else -1)
    if 0 <= to < len(STEPS):
        open_step(page, to)
    else:
        page.lesson = None
        page.view.learn.show(None)


def open_step(page: Page, number: int) -> None:
    """Open a step of the lesson and do what it opens with."""
    page.lesson = number
    page.view.learn.show(number)
    for instruction in STEPS[number].on_open:
        follow(page, instruction, None)


def follow(page: Page, instruction: tuple[Any, ...], client_id: int | None) -> None:
    """Do one thing that a step asks for."""
    name, *rest = instruction
    simple: dict[str, Callable[..., None]] = {
        "overlay": set_overlay,
        "mode": set_mode,
        "forces": set_forces,
        "play": set_playing,
        "preset": choose_preset,
    }
    if name in simple:
        simple[name](page, *rest)
    elif name == "baseline":
        choose_preset(page, BASELINE)
    elif name in ("moment", "glide"):
        page.glide_to(*rest)
    elif name == "search":
        start_search(page, "surrogate", client_id)
    elif name == "landscape":
        set_landscape(page, bool(rest[0]), client_id)


ACTIONS: dict[str, Callable[..., None]] = {
    "lesson_press": _lesson_press,
    "lesson_turn": _lesson_turn,
}

"""The sliders of a model, and what became of a run or a picture. Runs on the session's worker."""

from collections.abc import Callable
from typing import Any

from kneeviz.anymodel import work
from kneeviz.anymodel.page import ModelPage
from kneeviz.anymodel.pictures import OWN, Drawn
from kneeviz.anymodel.runs import Ran
from kneeviz.anymodel.views import words
from kneeviz.anymodel.views.words import duration
from kneeviz.jobs.job import Job, JobDone, JobProgress
from kneeviz.jobs.messages import Asked

READY_SLOW = "Ready. The model is slow: press to run it."
LEARNS_BY_ITSELF_SECONDS = 30.0
"""A surrogate whose runs take less is made without being asked for."""


def _input(page: ModelPage, value: Asked, index: int) -> None:
    page.set_input(index, float(value.value))


def _home(page: ModelPage, _value: Any) -> None:
    page.move_to(page.state.model.nominal)


def _run_here(page: ModelPage, _value: Any) -> None:
    _tell_running(page, "Running the model …")
    page.runs.ask(page.state.x)


def _running(page: ModelPage, seconds: float) -> None:
    _tell_running(page, f"Running the model … {seconds:.0f} s")


def _tell_running(page: ModelPage, text: str) -> None:
    page.told_running = True
    page.view.running.cancel.visible = True
    page.say(text, "busy")


def _run_cancel(page: ModelPage, _value: Any) -> None:
    page.runs.cancel()
    if page.state.job is not None and page.state.job.kind == "learn":
        page.state.job.cancel()


def _ran(page: ModelPage, ran: Ran) -> None:
    state, first = page.state, page.state.seconds is None
    state.take(ran)
    was_told, page.told_running, page.starting = page.told_running, False, False
    page.view.running.cancel.visible = state.job is not None and state.job.kind == "learn"
    page.show_pace()
    if ran.cancelled:
        page.say("The run was cancelled; the last one stands.")
        return
    page.tell_trouble("The model", ran.why)
    if not page.troubles and (first or was_told):
        page.say(READY_SLOW if state.slow else "Ready.")
    if first:
        _begin(page)
        if not (state.at_home or state.slow):  # moved meanwhile, or opened as it had been left
            page.follow()


def _begin(page: ModelPage) -> None:
    """Now that it is known what a run takes: have a surrogate made, or offer it."""
    state = page.state
    if state.slow:
        page.view.study.suit_slow()
        page.keep_runs()
    assert state.seconds is not None
    n = work.n_learning(state.model)
    if n * state.seconds <= LEARNS_BY_ITSELF_SECONDS:
        learn(page)
        return
    learn_button = page.view.running.learn
    learn_button.label = f"Learn a surrogate ({n} runs, {duration(n * state.seconds)})"
    learn_button.visible = True


def learn(page: ModelPage) -> None:
    """Have a surrogate made, unless something else goes on."""
    state, running = page.state, page.view.running
    if state.job is not None:
        return
    state.job = Job("learn", work.learning(state.model), page.post, kind="learn")
    running.learn.disabled = True
    running.progress.value, running.progress.visible = 0.0, True
    running.cancel.visible = True
    if not page.troubles:
        page.say("Learning a surrogate …", "busy")
    state.job.start()


def _learn(page: ModelPage, value: Asked) -> None:
    if page.state.job is not None:
        page.notices.tell(value.client_id, "Not now", "Something else is running; cancel it first.")
        return
    learn(page)


def _learn_progress(page: ModelPage, news: JobProgress) -> None:
    if news.job is page.state.job:
        page.view.running.progress.value = news.percent
        left = words.time_left(news.seconds_left)
        if left and not page.troubles:
            page.say(f"Learning a surrogate … {left}", "busy")


def _learn_done(page: ModelPage, news: JobDone) -> None:
    state, running = page.state, page.view.running
    if news.job is not state.job:
        return
    state.job = None
    running.learn.disabled = running.progress.visible = running.cancel.visible = False
    running.learn.visible = news.result is None
    if news.result is not None:
        state.surrogate = news.result
        page.tell_trouble("No surrogate", None)
    if page.after_learning:
        page.after_learning = False
        page.post("search", None)
    elif news.why is not None:
        page.tell_trouble("No surrogate", news.why)
    elif not page.troubles:
        page.say("Ready." if news.result is not None else "The learning was cancelled.")
    page.touched = True


def _drawn(page: ModelPage, drawn: Drawn, whose: int) -> None:
    if drawn.shapes is not None:
        page.state.shapes[whose] = drawn.shapes
        if whose == OWN:
            page.tell_trouble("The picture", None)
    elif whose == OWN:
        page.tell_trouble("The picture", f"`draw` {drawn.why}")
    page.touched = True


ACTIONS: dict[str, Callable[..., None]] = {
    "input": _input,
    "home": _home,
    "run_here": _run_here,
    "run_cancel": _run_cancel,
    "running": _running,
    "ran": _ran,
    "learn": _learn,
    "learn_progress": _learn_progress,
    "learn_done": _learn_done,
    "drawn": _drawn,
}

"""The worst-case search of a model. Runs on the session's worker."""

from collections.abc import Callable
from typing import Any

import numpy as np

from kneecore import KneecoreError, SearchResult
from kneecore.report.model_command import model_command
from kneecore.search.training import surrogate_through
from kneeviz.anymodel import work
from kneeviz.anymodel.page import ModelPage
from kneeviz.anymodel.views import words
from kneeviz.jobs.job import Job, JobDone, JobProgress
from kneeviz.jobs.messages import Asked
from kneeviz.views.html.pieces import box, escape, sentence, sparkline


def _search(page: ModelPage, value: Asked | None) -> None:
    state, tab = page.state, page.view.search
    if state.job is not None:
        if state.job.kind == "learn":  # what it would learn, the search learns too
            page.after_learning = True
            state.job.cancel()
        elif value is not None:
            told = "Something else is running; cancel it first."
            page.notices.tell(value.client_id, "Not now", told)
        return
    try:
        job = Job(
            "search", work.search(state.model, tab.settings), page.post, kind="search", keeps=True
        )
    except KneecoreError as error:
        page.say(f"Not searched: {escape(str(error))}", "bad")
        return
    state.job, state.rising = job, []
    tab.set_running(True)
    page.say("Searching …", "busy")
    job.start()


def _progress(page: ModelPage, news: JobProgress) -> None:
    state, tab = page.state, page.view.search
    if news.job is not state.job:
        return
    first = tab.n_first / tab.n_runs
    if news.stage == "sampling":
        tab.progress.value = first * news.percent
    elif news.stage == "repair":
        tab.progress.value = 100.0 * first + (1.0 - first) * news.percent
    tab.left.content = words.time_left(news.seconds_left)
    if news.best is not None:
        state.rising.append(news.best)
        best = f"Best f so far: <b>{words.told(news.best, state.model.objective_unit)}</b>"
        tab.rising.content = box(best + sparkline(state.rising, page.view.colours.current))


def _done(page: ModelPage, news: JobDone) -> None:
    if news.job is not page.state.job:
        return
    page.state.job = None
    page.view.search.set_running(False)
    if news.result is not None:
        take_result(page, news.result)
        stopped = news.result.stop_reason == "cancelled"
        what = "Stopped; the best pair until then" if stopped else "Done"
        page.say(f"{what}: model 1 is blue, model 2 orange.")
    elif news.why is not None:
        page.say(f"The search failed: {escape(sentence(news.why))} What you had stands.", "bad")
    else:
        page.say("The search was cancelled; what you had stands.")


def take_result(page: ModelPage, result: SearchResult) -> None:
    """Show a result's two models and offer its files."""
    state, view = page.state, page.view
    state.result = result
    same = state.same_bounds(result)
    if same and result.training_x is not None and result.training_y is not None:
        try:
            state.surrogate = surrogate_through(state.model, result.training_x, result.training_y)
            view.running.learn.visible = False
            page.tell_trouble("No surrogate", None)
        except KneecoreError:  # too few runs of it are usable
            pass
    view.search.overlay.visible = view.search.adopt.visible = True
    for handle in view.files.result.values():
        handle.disabled = False
    set_overlay(page, True)
    write_result(page)


def forget_result(page: ModelPage) -> None:
    """Show no result any more, and offer nothing of it; what was learned from its runs stays."""
    tab = page.view.search
    page.state.result = None
    set_overlay(page, False)
    tab.overlay.visible = tab.adopt.visible = False
    for handle in page.view.files.result.values():
        handle.disabled = True
    tab.found.content = tab.table.content = ""


def set_overlay(page: ModelPage, shown: bool) -> None:
    """Show or hide both worst models, and let the box agree."""
    if page.view.search.overlay.value != shown:
        page.view.search.overlay.value = shown
    page.show_overlay(shown)


def stop_search(page: ModelPage) -> None:
    """Cancel a search that runs; what it has found until now is not wanted."""
    job = page.state.job
    if job is not None and job.kind == "search":
        job.cancel()
        page.state.job = None
        page.view.search.set_running(False)


def write_result(page: ModelPage) -> None:
    """Write what the last search found, in the theme's colours."""
    state, view = page.state, page.view
    if state.result is None:
        return
    view.search.found.content = words.found(
        state.result, same_bounds=state.same_bounds(state.result)
    )
    command = model_command(state.model, state.result.settings)
    again = "" if command is None or state.result.stop_reason == "cancelled" else command
    view.search.table.content = words.differences(state.result, view.colours, again)


def _cancel(page: ModelPage, value: Asked | None) -> None:
    job = page.state.job
    if job is not None and job.kind == "search":
        job.cancel()
    elif value is not None:
        page.notices.tell(value.client_id, "Nothing to cancel", "No search is running.")


def _adopt(page: ModelPage, value: Asked) -> None:
    state = page.state
    if state.result is not None:
        x = state.result.x[0 if value.value == "Model 1" else 1]
        page.move_to(np.clip(x, state.model.lower, state.model.upper))


def _overlay(page: ModelPage, value: Asked) -> None:
    page.show_overlay(bool(value.value))


def _setting(page: ModelPage, _value: Any, _name: str) -> None:
    page.show_pace()


ACTIONS: dict[str, Callable[..., None]] = {
    "search": _search,
    "search_progress": _progress,
    "search_done": _done,
    "search_cancel": _cancel,
    "adopt": _adopt,
    "overlay": _overlay,
    "setting": _setting,
}

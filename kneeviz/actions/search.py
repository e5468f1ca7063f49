"""The worst-case search. Runs on the session's worker."""

from collections.abc import Callable

from kneecore.search.settings import SearchSpace
from kneeviz.actions.knee import choose_preset
from kneeviz.actions.live import set_live
from kneeviz.actions.result import take_result
from kneeviz.jobs import computations
from kneeviz.jobs.job import Job, JobDone, JobProgress
from kneeviz.jobs.messages import Asked
from kneeviz.page.page import Page
from kneeviz.state.presets import WORST
from kneeviz.state.search import SearchState
from kneeviz.views import theme
from kneeviz.views.html.pieces import box, escape, number, sparkline


def _search(page: Page, value: Asked | None, search_space: SearchSpace) -> None:
    start_search(page, search_space, None if value is None else value.client_id)


def start_search(page: Page, search_space: SearchSpace, client_id: int | None) -> None:
    """Start a search, unless one is running."""
    refused = None
    if page.search.job is not None:
        refused = "A search is running already; cancel it first."
    elif not page.surrogate_ready:
        refused = "The model is still being prepared; try again in a moment."
    if refused is not None:
        if client_id is not None:
            page.notices.tell(client_id, "Not now", refused)
        return
    tab = page.view.search
    knee = page.state.knees(tab.chosen_solver)
    work = computations.search(knee, tab.settings(knee, search_space))
    set_live(page, False)
    job = Job("search", work, page.post)
    page.search = SearchState(job=job)
    tab.set_running(True)
    where = "stand-in" if search_space == "surrogate" else "true model"
    page.say(f"Searching in the {where} …", "busy")
    job.start()


def stop_search(page: Page) -> None:
    """End a search that runs, and want nothing of it."""
    if page.search.job is not None:
        page.search.job.cancel()
        page.search = SearchState()
        page.view.search.set_running(False)


def _progress(page: Page, news: JobProgress) -> None:
    if news.job is not page.search.job:
        return
    tab, rising = page.view.search, page.search.rising
    tab.progress.value = news.percent if news.stage in ("search", "bound") else 0.0
    if news.best is not None:
        rising.append(news.best)
        colour = theme.palette(page.view.dark).current
        best = f"Best f so far: <b>{number(news.best, 0, '°')}</b>"
        tab.rising.content = box(best + sparkline(rising, colour))


def _done(page: Page, news: JobDone) -> None:
    if news.job is not page.search.job:
        return
    page.search.job = None
    page.view.search.set_running(False)
    if news.result is not None:
        set_live(page, False)
        take_result(page, news.result)
        page.say("Done: model 1 is blue, model 2 orange.")
    elif news.why is not None:
        page.say(f"The search failed: {escape(news.why)} What you had stands.", "bad")
    else:
        page.say("The search was cancelled; what you had stands.")


def _cancel(page: Page, value: Asked | None) -> None:
    if page.search.job is not None:
        page.search.job.cancel()
    elif value is not None:
        page.notices.tell(value.client_id, "Nothing to cancel", "No search is running.")


def _setting(page: Page, _value: Asked | None, _name: str) -> None:
    """Shut what the method has none of; whoever follows the settings looks at them by himself."""
    page.view.search.show_method()


def _adopt(page: Page, value: Asked) -> None:
    choose_preset(page, WORST[0 if value.value == "Model 1" else 1])


ACTIONS: dict[str, Callable[..., None]] = {
    "search": _search,
    "search_progress": _progress,
    "search_done": _done,
    "cancel": _cancel,
    "adopt": _adopt,
    "setting": _setting,
}

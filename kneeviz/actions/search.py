"""What a session does to search. Runs on its worker."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

from kneecore.knee.response import Solver
from kneecore.search.settings import Method, SearchSpace
from kneeviz.actions.knee import choose_preset
from kneeviz.actions.live import set_live
from kneeviz.actions.result import take_result
from kneeviz.jobs.search_job import SearchJob, SearchReport, SearchSettings
from kneeviz.views import theme
from kneeviz.views.html import pieces as markup
from kneeviz.views.tabs import controls

if TYPE_CHECKING:
    from kneeviz.server.session import Session


def _search(session: "Session", value: Any, search_space: SearchSpace) -> None:
    start_search(session, search_space, None if value is None else value.client_id)


def start_search(session: "Session", search_space: SearchSpace, client_id: int | None) -> None:
    """Start a search, unless one is running."""
    tab, state = session.view.search, session.state
    refused = None
    if session.job is not None:
        refused = "A search is running already; cancel it first."
    elif not session.surrogate_ready:
        refused = "The model is still being prepared; try again in a moment."
    if refused is not None:
        if client_id is not None:
            session.notices.tell(client_id, "Not now", refused)
        return
    settings = SearchSettings(
        space=state.space,
        rest_length=state.bounds.rest_length,
        search_space=search_space,
        method=cast(Method, controls.METHODS[tab.method.value]),
        repair=bool(tab.repair.value),
        solver=cast(Solver, controls.SOLVERS[tab.solver.value]),
        objective=tab.objective.value,
        pop_size=round(tab.pop_size.value),
        n_generations=round(tab.n_generations.value),
        seed=round(tab.seed.value),
    )
    set_live(session, False)
    session.job, session.rising = SearchJob(settings, session.post), []
    tab.set_running(True)
    where = "stand-in" if search_space == "surrogate" else "true model"
    session.say(f"Searching in the {where} …", "busy")
    session.job.start()


def _progress(session: "Session", value: tuple[SearchJob, SearchReport]) -> None:
    job, report = value
    if job is not session.job:
        return
    tab = session.view.search
    tab.progress.value = report.percent
    if report.best_deg is not None:
        session.rising.append(report.best_deg)
        colour = theme.palette(session.view.dark).current
        tab.rising.content = markup.box(
            f"Best f so far: <b>{markup.number(report.best_deg, 0, '°')}</b>"
            + markup.sparkline(session.rising, colour)
        )


def _search_done(session: "Session", value: tuple[SearchJob, Any, str | None]) -> None:
    job, result, why = value
    if job is not session.job:
        return
    session.job = None
    session.view.search.set_running(False)
    if result is not None:
        set_live(session, False)
        take_result(session, result)
        session.say("Done: model 1 is blue, model 2 orange.")
    elif why is not None:
        session.say(f"The search failed: {markup.escape(why)} What you had stands.", "bad")
    else:
        session.say("The search was cancelled; what you had stands.")


def _cancel(session: "Session", value: Any) -> None:
    if session.job is not None:
        session.job.cancel()
    elif value is not None:
        session.notices.tell(value.client_id, "Nothing to cancel", "No search is running.")


def _method(session: "Session", value: Any) -> None:
    tab = session.view.search
    genetic = controls.METHODS[value.value] == "ga"
    tab.pop_size.disabled = tab.n_generations.disabled = not genetic


def _adopt(session: "Session", value: Any) -> None:
    choose_preset(session, controls.WORST[0 if value.value == "Model 1" else 1])


DEEDS: dict[str, Callable[..., None]] = {
    "search": _search,
    "progress": _progress,
    "search_done": _search_done,
    "cancel": _cancel,
    "adopt": _adopt,
    "method": _method,
}

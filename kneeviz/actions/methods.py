"""What a session does to compare the search's methods. Runs on its worker."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

from kneecore._threads import available_cores
from kneecore.knee.response import Solver
from kneecore.search.compare import MethodTrace, compare_methods
from kneeviz.jobs.job import StudyJob, Watch
from kneeviz.views import theme
from kneeviz.views.html import methods as methods_chart
from kneeviz.views.html import pieces as markup
from kneeviz.views.tabs import controls

if TYPE_CHECKING:
    from kneeviz.server.session import Session


@dataclass
class MethodsDesk:
    """The comparison that runs, and the last one found."""

    job: StudyJob | None = None
    found: Mapping[str, MethodTrace] | None = None
    written: tuple[Any, ...] = ()
    """What the text on screen was made of."""


def _compare(session: "Session", value: Any) -> None:
    desk, refused = session.methods, None
    if desk.job is not None:
        refused = "The methods are being compared already; cancel that first."
    elif not session.exact_ready:
        refused = "The model is still being prepared; try again in a moment."
    if refused is not None:
        session.notices.tell(value.client_id, "Not now", refused)
        return
    desk.job = StudyJob("methods", _work(session), session.post, key="methods")
    session.view.methods.set_running(True)
    session.say("Comparing the methods …", "busy")
    desk.job.start()


def _work(session: "Session") -> Callable[[Watch], Mapping[str, MethodTrace]]:
    state, tab = session.state, session.view.search
    space, rest_length = state.space, state.bounds.rest_length
    objective, seed = tab.objective.value, round(tab.seed.value)
    solver = cast(Solver, controls.SOLVERS[tab.solver.value])
    return lambda watch: compare_methods(
        space,
        objective=objective,
        solver=solver,
        rest_length=rest_length,
        seed=seed,
        threads=max(1, available_cores() - 1),  # one core stays free for the view
        callback=watch,
    )


def _progress(session: "Session", value: tuple[StudyJob, float, str]) -> None:
    job, percent, _ = value
    if job is session.methods.job:
        session.view.methods.progress.value = percent


def _done(session: "Session", value: tuple[StudyJob, Any, str | None]) -> None:
    job, found, why = value
    if job is not session.methods.job:
        return
    session.methods.job = None
    session.view.methods.set_running(False)
    if found is not None:
        session.methods.found = found
        refresh(session)
        session.say("Compared: see “Compare” on the left.")
    elif why is not None:
        session.say(f"The comparison failed: {markup.escape(why)}", "bad")
    else:
        session.say("The comparison was cancelled; what you had stands.")


def _cancel(session: "Session", value: Any) -> None:
    if session.methods.job is not None:
        session.methods.job.cancel()
    else:
        session.notices.tell(value.client_id, "Nothing to cancel", "No comparison is running.")


def refresh(session: "Session") -> None:
    """Draw the last comparison, greyed if it belongs to other bounds; cheap if that is done."""
    desk = session.methods
    found = desk.found
    if found is None:
        return
    colours = theme.palette(session.view.dark)
    result = next(iter(found.values())).result
    stale = session.state.is_stale(result)
    made_of = (found, stale, session.view.dark)
    if made_of == desk.written:
        return
    desk.written = made_of
    note = "<b>Bounds changed since this comparison.</b><br>" if stale else ""
    response = "at rest" if result.solver == "equilibrium" else "in motion"
    about = (
        f"Every f is the true model's ({response}, seed {result.seed}). Genetic: 100 x 100 in the "
        f"true model; 200 x 800 in the surrogate. {methods_chart.promises(found)}"
    )
    session.view.methods.content.content = markup.box(
        note
        + methods_chart.plot(found, colours)
        + methods_chart.table(found, colours)
        + f'<div style="margin-top:4px">{markup.faint(about)}</div>',
        style="opacity:.45" if stale else "",
    )


DEEDS: dict[str, Callable[..., None]] = {
    "methods": _compare,
    "methods_progress": _progress,
    "methods_done": _done,
    "methods_cancel": _cancel,
}

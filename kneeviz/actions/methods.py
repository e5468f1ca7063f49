"""The comparison of the search's methods. Runs on the session's worker."""

from collections.abc import Callable

from kneecore import SearchSettings
from kneeviz.jobs import computations
from kneeviz.jobs.job import Job, JobDone, JobProgress
from kneeviz.jobs.messages import Asked
from kneeviz.page import belonging
from kneeviz.page.page import Page
from kneeviz.state import results
from kneeviz.views import theme
from kneeviz.views.html import methods
from kneeviz.views.html.pieces import box, escape, faint


def _compare(page: Page, value: Asked) -> None:
    compared, refused = page.methods, None
    if compared.job is not None:
        refused = "The methods are being compared already; cancel that first."
    elif not page.exact_ready:
        refused = "The model is still being prepared; try again in a moment."
    if refused is not None:
        page.notices.tell(value.client_id, "Not now", refused)
        return
    tab = page.view.search
    settings = SearchSettings(
        objective=tab.options.value("objective"), seed=tab.options.value("seed")
    )
    work = computations.comparison(page.state.knees(tab.chosen_solver), settings)
    compared.job = Job("comparison", work, page.post)
    page.view.methods.set_running(True)
    page.say("Comparing the methods …", "busy")
    compared.job.start()


def _progress(page: Page, news: JobProgress) -> None:
    if news.job is page.methods.job:
        page.view.methods.progress.value = news.percent


def _done(page: Page, news: JobDone) -> None:
    if news.job is not page.methods.job:
        return
    page.methods.job = None
    page.view.methods.set_running(False)
    if news.result is not None:
        page.methods.found = news.result
        refresh(page)
        page.say("Compared: see “Compare” on the left.")
    elif news.why is not None:
        page.say(f"The comparison failed: {escape(news.why)}", "bad")
    else:
        page.say("The comparison was cancelled; what you had stands.")


def _cancel(page: Page, value: Asked) -> None:
    if page.methods.job is not None:
        page.methods.job.cancel()
    else:
        page.notices.tell(value.client_id, "Nothing to cancel", "No comparison is running.")


def refresh(page: Page) -> None:
    """Draw the last comparison; cheap if that is done."""
    compared = page.methods
    found = compared.found
    if found is None:
        return
    colours = theme.palette(page.view.dark)
    made_of = (found, belonging.changed(page, belonging.METHODS), page.view.dark)
    if made_of == compared.written:
        return
    compared.written = made_of
    response = "at rest" if results.solver(found) == "equilibrium" else "in motion"
    about = (
        f"Every f is the true model's ({response}, seed {results.seed(found)}). Genetic: "
        f"100 x 100 in the true model; 200 x 800 in the surrogate. "
        f"{methods.promises(found.methods)}"
    )
    content = box(
        methods.plot(found.methods, colours)
        + methods.table(found.methods, colours)
        + f'<div style="margin-top:4px">{faint(about)}</div>'
    )
    belonging.write(page, "methods.content", content, since="this comparison")


ACTIONS: dict[str, Callable[..., None]] = {
    "compare": _compare,
    "comparison_progress": _progress,
    "comparison_done": _done,
    "comparison_cancel": _cancel,
}

"""The study: sampling, influence, accuracy, the paper, files. Runs on the session's worker."""

from collections.abc import Callable
from typing import Any

import numpy as np

import kneecore
from kneecore import (
    MOMENT,
    AccuracyAllocation,
    AccuracyAllocationSettings,
    InfluenceResult,
    InfluenceSettings,
    Knee,
    KneecoreError,
    MonteCarloResult,
    SamplingSettings,
    SearchResult,
)
from kneeviz.actions.downloads import study_file
from kneeviz.jobs import computations, paper_files
from kneeviz.jobs.computations import Work
from kneeviz.jobs.cores import spare_cores
from kneeviz.jobs.job import Job, JobDone, JobProgress, Watch
from kneeviz.jobs.messages import Asked
from kneeviz.jobs.paper_files import PaperFiles
from kneeviz.page import belonging
from kneeviz.page.page import Page
from kneeviz.state import results
from kneeviz.state.shown import Band, band_of
from kneeviz.state.study import SLOPES
from kneeviz.views import theme
from kneeviz.views.html import accuracy, influence_tab
from kneeviz.views.html.labels import LOADS
from kneeviz.views.html.pieces import box, escape
from kneeviz.views.html.study import judged, sampling

_BUSY = {
    "sampling": "Sampling the true model …",
    "influence": "Finding what decides …",
    "accuracy": "Finding how good each measurement must be …",
    "report": "Redoing the paper …",
}
_CALM = {
    "sampling": "Sampled: the band holds 99.7 % of the knees.",
    "influence": "Done: see the tab “Influence” on the left.",
    "accuracy": "Done: the tolerances are in the tab “Study”.",
    "report": "The report is ready: see “Study files”.",
}


_SUBJECTS = (belonging.SAMPLING, belonging.INFLUENCE, belonging.PAPER, belonging.ACCURACY)


def _run(page: Page, value: Asked | None, kind: str) -> None:
    study, refused = page.study, None
    if study.job is not None:
        refused = "A study is running already; cancel it first."
    elif not page.surrogate_ready:
        refused = "The model is still being prepared; try again in a moment."
    if refused is not None:
        if value is not None:
            page.notices.tell(value.client_id, "Not now", refused)
        return
    study.job = Job("study", _WORK[kind](page), page.post, kind=kind)
    page.view.study.set_running(True)
    page.say(_BUSY[kind], "busy")
    study.job.start()


def _sampling(page: Page) -> Work[tuple[MonteCarloResult, SearchResult | None]]:
    tab, worst = page.view.study, page.state.result
    if worst is not None and page.state.is_stale(worst):
        worst = None
    settings = SamplingSettings(
        n_samples=round(tab.n_samples.value),
        sampling=tab.sampling.value,
        seed=round(tab.seed.value),
    )
    marks = None if worst is None else results.angles_deg(worst)
    sample = computations.sampling(page.state.knees(), settings, marks)
    return lambda watch: (sample(watch), worst)


def _influence(page: Page) -> Work[InfluenceResult]:
    tab = page.view.study
    settings = InfluenceSettings(n_base=int(tab.n_base.value), seed=round(tab.seed.value))
    return computations.influence(page.state.knees(), settings)


def _accuracy(page: Page) -> Work[AccuracyAllocation]:
    tab = page.view.study
    settings = AccuracyAllocationSettings(
        within=float(tab.within.value), seed=round(tab.seed.value)
    )
    return computations.accuracy(page.state.knees(), settings)


def _report(page: Page) -> Work[PaperFiles]:
    knee = Knee(page.state.space, threads=spare_cores())  # the paper's rest lengths
    tab = page.view.study
    quick, seed = bool(tab.quick.value), round(tab.seed.value)
    return lambda watch: paper_files.redo(knee, quick=quick, seed=seed, watch=watch)


_WORK: dict[str, Callable[[Page], Callable[[Watch], Any]]] = {
    "sampling": _sampling,
    "influence": _influence,
    "accuracy": _accuracy,
    "report": _report,
}


def _progress(page: Page, news: JobProgress) -> None:
    if news.job is not page.study.job:
        return
    page.view.study.progress.value = news.percent
    if news.job.kind == "report":  # its stages take a while each
        page.say(f"The paper: {escape(news.stage)} …", "busy")


def _done(page: Page, news: JobDone) -> None:
    study = page.study
    if news.job is not study.job:
        return
    study.job = None
    page.view.study.set_running(False)
    if news.result is None:
        _say_why(page, news.why)
        return
    if news.job.kind == "sampling":
        study.sampled, study.held_against = news.result
        if page.band is study.band:
            page.show_band(None)
        study.band = _band_of(study.sampled)
    elif news.job.kind == "influence":
        study.influence = news.result
    elif news.job.kind == "accuracy":
        study.accuracy = news.result
    else:
        study.paper = news.result
    page.say(_CALM[news.job.kind])
    refresh(page)


def _say_why(page: Page, why: str | None) -> None:
    if why is None:
        page.say("The study was cancelled; what you had stands.")
    else:
        page.say(f"The study failed: {escape(why)} What you had stands.", "bad")


def _band_of(found: MonteCarloResult) -> Band:
    return band_of(found, f"{found.n_samples - found.n_failed:,} samples of the true model")


def _cancel(page: Page, value: Asked | None) -> None:
    if page.study.job is not None:
        page.study.job.cancel()
    elif value is not None:
        page.notices.tell(value.client_id, "Nothing to cancel", "No study is running.")


def _show_band(page: Page, value: Asked) -> None:
    page.study.with_band = bool(value.value)
    refresh(page)


def _load(page: Page, value: Asked) -> None:
    moment = LOADS[value.value]
    page.study.load = int(np.argmin(np.abs(MOMENT - moment)))
    refresh(page)


def _chart(page: Page, value: Asked) -> None:
    page.study.chart = value.value
    refresh(page)


def refresh(page: Page) -> None:
    """Bring texts, charts and band of the study up to date; cheap if nothing has changed."""
    study = page.study
    _draw_band(page)
    found = (study.sampled, study.influence, study.paper, study.accuracy)
    stale = tuple(belonging.changed(page, subject) for subject in _SUBJECTS)
    made_of: tuple[Any, ...] = (*found, study.load, study.chart, page.view.dark, *stale)
    if study.chart == SLOPES:
        made_of += (page.state.result, belonging.changed(page, belonging.WORST))
    if made_of == study.written:
        return
    study.written = made_of
    tab = page.view.study
    by_file = {
        "uncertainty": study.sampled,
        "influence": study.influence,
        "accuracy_allocation": study.accuracy,
        "paper": study.paper,
    }
    for name, handle in tab.files.items():
        handle.disabled = by_file[name.partition(".")[0]] is None
    if study.paper is not None:
        belonging.write(page, "study.judged", judged(study.paper.words, study.paper.claims))
    if study.accuracy is not None:
        colours = theme.palette(page.view.dark)
        belonging.write(page, "study.accuracy", accuracy.tolerances(study.accuracy, colours))
    tab.band.visible = study.sampled is not None
    if study.sampled is not None:
        belonging.write(page, "study.sampled", sampling(study.sampled))
    of = belonging.WORST if study.chart == SLOPES else belonging.INFLUENCE
    belonging.write(page, "influence.content", _charts(page), of=of)


def _draw_band(page: Page) -> None:
    """Draw the sampling's band where no other is that fits; take it away if it is not wanted."""
    study, drawn = page.study, belonging.band(page)
    fits = study.sampled is not None and belonging.fits(page, belonging.SAMPLING)
    wanted = fits and study.with_band
    if wanted and drawn is None:
        page.show_band(study.band)
    elif page.band is not None and page.band is study.band and not wanted:
        page.show_band(None)


def _charts(page: Page) -> str:
    study, colours = page.study, theme.palette(page.view.dark)
    if study.chart != SLOPES:
        return influence_tab.indices(study.influence, study.load, study.chart, colours)
    if page.state.result is None:
        return influence_tab.no_slopes()
    try:
        slopes = kneecore.worst_case_slopes(page.state.result)
    except KneecoreError as error:
        return box(escape(str(error)))
    return influence_tab.slopes(slopes, study.load, colours)


def _file(page: Page, value: Asked, name: str) -> None:
    client = page.clients().get(value.client_id)
    if client is None:
        return
    content = study_file(page.study, page.state.result, name)
    if content is None:
        page.notices.tell(value.client_id, "Nothing to download", "That has not been computed.")
        return
    client.send_file_download(name, content, save_immediately=True)


ACTIONS: dict[str, Callable[..., None]] = {
    "study": _run,
    "study_progress": _progress,
    "study_done": _done,
    "study_cancel": _cancel,
    "study_band": _show_band,
    "study_file": _file,
    "influence_load": _load,
    "influence_chart": _chart,
}

"""Band, influence and landscape of a model. Runs on the session's worker."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from kneecore import InfluenceSettings, KneecoreError, Model, SamplingSettings
from kneeviz.anymodel import work
from kneeviz.anymodel.page import ModelPage
from kneeviz.anymodel.slices import picture_of
from kneeviz.anymodel.views import words
from kneeviz.anymodel.views.study import column_labels
from kneeviz.jobs.computations import Work
from kneeviz.jobs.job import Job, JobDone, JobProgress
from kneeviz.jobs.messages import Asked
from kneeviz.views.html.pieces import escape, sentence
from kneeviz.views.scene.landscape import LandscapeScene

_BUSY = {
    "sampling": "Sampling …",
    "influence": "Finding what decides …",
    "landscape": "Running the landscape …",
}
_CALM = {
    "sampling": "Sampled: the band holds 99.7 % of the models.",
    "influence": "Done: see the tab \u201cInfluence\u201d on the left.",
    "landscape": "Ready.",
}
CHEAP_SECONDS = 2.0
"""A landscape that took less follows the sliders."""
REST_SECONDS = 0.3


def _run(page: ModelPage, value: Asked | None, kind: str) -> None:
    if kind == "landscape" and page.state.landscape_shown:
        show_landscape(page, False)
        return
    refused = _refused(page)
    if refused is not None:
        if value is not None:
            page.notices.tell(value.client_id, "Not now", refused)
        return
    start(page, kind)


def _refused(page: ModelPage) -> str | None:
    if page.state.job is not None:
        return "Something else is running; cancel it first."
    if page.view.study.in_surrogate and page.state.surrogate is None:
        return "There is no surrogate yet: learn one, or search."
    return None


def start(page: ModelPage, kind: str) -> None:
    """Start a study of the model, or of its surrogate."""
    state, tab = page.state, page.view.study
    model = state.model
    if tab.in_surrogate:
        assert state.surrogate is not None
        model = work.stand_in(state.surrogate)
    try:
        if kind != "landscape":
            model = model.with_distributions(tab.drawn.chosen)
        job = Job("study", _WORK[kind](page, model), page.post, kind=kind, keeps=kind == "sampling")
    except KneecoreError as error:
        page.say(f"Not done: {escape(str(error))}", "bad")
        return
    state.job, state.job_began = job, time.monotonic()
    if kind == "landscape":
        state.in_surrogate = tab.in_surrogate
    tab.set_running(True)
    page.say(_BUSY[kind], "busy")
    job.start()


def _sampling(page: ModelPage, model: Model) -> Work[Any]:
    tab = page.view.study
    settings = SamplingSettings(
        n_samples=round(tab.n_samples.value),
        sampling=tab.sampling.value,
        seed=round(tab.seed.value),
    )
    return work.sampling(model, settings)


def _influence(page: ModelPage, model: Model) -> Work[Any]:
    tab = page.view.study
    settings = InfluenceSettings(n_base=int(tab.n_base.value), seed=round(tab.seed.value))
    return work.influence(model, settings)


def _landscape(page: ModelPage, model: Model) -> Work[Any]:
    state, tab = page.state, page.view.study
    first, second = (handle.value for handle in tab.axes)
    beside = None if tab.in_surrogate else state.surrogate
    return work.landscape(model, (first, second), state.x.copy(), beside, round(tab.grid.value))


_WORK: dict[str, Callable[[ModelPage, Model], Work[Any]]] = {
    "sampling": _sampling,
    "influence": _influence,
    "landscape": _landscape,
}


def _progress(page: ModelPage, news: JobProgress) -> None:
    if news.job is page.state.job:
        page.view.study.progress.value = news.percent
        page.view.study.left.content = words.time_left(news.seconds_left)


def _done(page: ModelPage, news: JobDone) -> None:
    state, view = page.state, page.view
    if news.job is not state.job:
        return
    state.job = None
    view.study.set_running(False)
    if news.result is None:
        told = "The study was cancelled; what you had stands."
        if news.why is not None:
            told = f"The study failed: {escape(sentence(news.why))} What you had stands."
        page.say(told, "calm" if news.why is None else "bad")
        return
    if news.job.kind == "sampling":
        state.sampled = news.result
        view.study.band.visible = True
        view.study.sampled.content = words.sampled(news.result)
        view.files.studies["sampled"].disabled = False
    elif news.job.kind == "influence":
        state.influence = news.result
        view.files.studies["influence"].disabled = False
    else:
        state.landscape = news.result
        state.landscape_seconds = time.monotonic() - state.job_began
        view.files.studies["landscape"].disabled = False
        show_landscape(page, True)
    page.say(_CALM[news.job.kind])
    write_influence(page)
    page.touched = True


def _cancel(page: ModelPage, value: Asked | None) -> None:
    job = page.state.job
    if job is not None and job.kind in _WORK:
        job.cancel()
    elif value is not None:
        page.notices.tell(value.client_id, "Nothing to cancel", "No study is running.")


def _band(page: ModelPage, value: Asked) -> None:
    set_band(page, bool(value.value))


def set_band(page: ModelPage, shown: bool) -> None:
    """Draw what was sampled behind the curves, or not, and let the box agree."""
    if page.view.study.band.value != shown:
        page.view.study.band.value = shown
    page.state.band = shown
    page.touched = True


def _column(page: ModelPage, value: Asked) -> None:
    choose_column(page, column_labels(page.state).index(value.value))


def choose_column(page: ModelPage, column: int) -> None:
    """Show an output where one is shown at a time."""
    page.state.column = column
    label = column_labels(page.state)[column]
    view = page.view
    profile = [] if view.profile is None else [view.profile.column]
    for handle in (view.study.height, view.influence.column, *profile):
        if handle.value != label:
            handle.value = label
    write_influence(page)
    draw_landscape(page)
    page.touched = True


def write_influence(page: ModelPage) -> None:
    """Write which inputs decide the output that was chosen."""
    page.view.influence.content.content = words.influence(page.state, page.view.colours)


# The landscape.


def _axis(page: ModelPage, value: Asked, k: int) -> None:
    axes = page.view.study.axes
    if axes[0].value == axes[1].value:  # the other takes its place
        shown = page.state.landscape
        names = axes[0].options
        other = shown.names[k] if shown is not None else next(n for n in names if n != value.value)
        axes[1 - k].value = (
            other if other != value.value else next(n for n in names if n != value.value)
        )
    if page.state.landscape_shown and _refused(page) is None:
        start(page, "landscape")


def show_landscape(page: ModelPage, shown: bool) -> None:
    """Put the landscape in the picture's place, or the picture back."""
    state, view = page.state, page.view
    if view.landscape is None:
        view.landscape = LandscapeScene(page.target.scene)
        view.landscape.paint(view.colours)
    changed, state.landscape_shown = shown != state.landscape_shown, shown
    view.scene.set_hidden(shown)
    view.landscape.set_visible(shown)
    view.study.show_landscape(shown)
    if changed:
        view.set_wide(not (shown or view.has_picture))
        page.framing.reset(page.subject, time.monotonic())
    draw_landscape(page)
    page.touched = True


def draw_landscape(page: ModelPage) -> None:
    """Draw the landscape, if it is shown."""
    state, view = page.state, page.view
    if not state.landscape_shown or state.landscape is None or view.landscape is None:
        return
    shown = picture_of(state, state.landscape)
    labels = tuple(next(d.label for d in state.dials if d.name == n) for n in shown.names)
    column = state.model.columns[state.column]
    title = words.plain_with_unit(column.title, column.output.unit)
    if np.isfinite(shown.model).any() or shown.surrogate is not None:
        with page.target.atomic():
            view.landscape.draw(shown, title=title, labels=(labels[0], labels[1]), zoom=False)
    view.study.key.content = words.landscape_key(state, shown, view.colours)


def follow(page: ModelPage, now: float) -> float | None:
    """Run a landscape again that has been left by the sliders; return when, if it is not yet."""
    state = page.state
    if not state.landscape_shown or state.landscape is None or state.job is not None:
        return None
    if np.array_equal(state.landscape.x, state.x) or _refused(page) is not None:
        return None
    if state.landscape_seconds > CHEAP_SECONDS:
        return None
    due = page.moved_at + REST_SECONDS
    if now < due:
        return due
    start(page, "landscape")
    return None


ACTIONS: dict[str, Callable[..., None]] = {
    "study": _run,
    "study_progress": _progress,
    "study_done": _done,
    "study_cancel": _cancel,
    "band": _band,
    "column": _column,
    "axis": _axis,
}

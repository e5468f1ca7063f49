"""What a session does to study the uncertainty: sampling, influence, files. Runs on its worker."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

import kneecore
from kneecore import MOMENT, InfluenceResult, KneecoreError, MonteCarloResult, SearchResult
from kneecore._threads import available_cores
from kneeviz.jobs import paper_files
from kneeviz.jobs.job import StudyJob, Watch
from kneeviz.jobs.paper_files import PaperFiles
from kneeviz.state.study import study_file
from kneeviz.views import theme
from kneeviz.views.charts.curves import Band
from kneeviz.views.html import influence as influence_chart
from kneeviz.views.html import pieces as markup
from kneeviz.views.html import study as study_markup
from kneeviz.views.tabs import study as study_tab

if TYPE_CHECKING:
    from kneeviz.server.session import Session

_BUSY = {
    "sampling": "Sampling the true model …",
    "influence": "Finding what decides …",
    "report": "Redoing the paper …",
}
_CALM = {
    "sampling": "Sampled: the band holds 99.7 % of the knees.",
    "influence": "Done: see the tab “Influence” on the left.",
    "report": "The report is ready: see “Study files”.",
}


def _run(session: "Session", value: Any, kind: str) -> None:
    desk, refused = session.study, None
    if desk.job is not None:
        refused = "A study is running already; cancel it first."
    elif not session.surrogate_ready:
        refused = "The model is still being prepared; try again in a moment."
    if refused is not None:
        if value is not None:
            session.notices.tell(value.client_id, "Not now", refused)
        return
    desk.job = StudyJob(kind, _WORK[kind](session), session.post)
    session.view.study.set_running(True)
    session.say(_BUSY[kind], "busy")
    desk.job.start()


def _threads() -> int:
    return max(1, available_cores() - 1)  # one core stays free for the view


def _sampling(
    session: "Session",
) -> Callable[[Watch], tuple[MonteCarloResult, SearchResult | None]]:
    tab, state = session.view.study, session.state
    space, rest_length = state.space, state.bounds.rest_length
    n_samples, sampling = round(tab.n_samples.value), tab.sampling.value
    seed, worst = round(tab.seed.value), state.result
    if worst is not None and state.is_stale(worst):
        worst = None

    def work(watch: Watch) -> tuple[MonteCarloResult, SearchResult | None]:
        angles = None
        if worst is not None:
            angles = np.degrees([worst.model_1.flexion, worst.model_2.flexion])
        found = kneecore.monte_carlo(
            space,
            n_samples=n_samples,
            sampling=sampling,
            seed=seed,
            rest_length=rest_length,
            threads=_threads(),
            angles_deg=angles,
            callback=watch,
        )
        return found, worst

    return work


def _influence(session: "Session") -> Callable[[Watch], InfluenceResult]:
    tab, state = session.view.study, session.state
    space, rest_length = state.space, state.bounds.rest_length
    n_base, seed = int(tab.n_base.value), round(tab.seed.value)
    return lambda watch: kneecore.influence(
        space,
        n_base=n_base,
        seed=seed,
        rest_length=rest_length,
        threads=_threads(),
        callback=watch,
    )


def _report(session: "Session") -> Callable[[Watch], PaperFiles]:
    space, tab = session.state.space, session.view.study
    quick, seed = bool(tab.quick.value), round(tab.seed.value)
    return lambda watch: paper_files.redo(space, quick=quick, seed=seed, watch=watch)


_WORK: dict[str, Callable[["Session"], Callable[[Watch], Any]]] = {
    "sampling": _sampling,
    "influence": _influence,
    "report": _report,
}


def _progress(session: "Session", value: tuple[StudyJob, float, str]) -> None:
    job, percent, stage = value
    if job is not session.study.job:
        return
    session.view.study.progress.value = percent
    if job.kind == "report":  # its stages take a while each
        session.say(f"The paper: {markup.escape(stage)} …", "busy")


def _done(session: "Session", value: tuple[StudyJob, Any, str | None]) -> None:
    job, found, why = value
    desk = session.study
    if job is not desk.job:
        return
    desk.job = None
    session.view.study.set_running(False)
    if found is None:
        told = "The study was cancelled; what you had stands."
        if why is not None:
            told = f"The study failed: {markup.escape(why)} What you had stands."
        session.say(told, "calm" if why is None else "bad")
        return
    if job.kind == "sampling":
        desk.sampled, desk.held_against = found
        if session.band is desk.band:
            session.show_band(None)
        desk.band = _band_of(desk.sampled)
    elif job.kind == "influence":
        desk.influence = found
    else:
        desk.paper = found
    session.say(_CALM[job.kind])
    refresh(session)


def _band_of(found: MonteCarloResult) -> Band:
    return Band(
        lower_deg=found.flexion_deg.percentile_lower,
        upper_deg=found.flexion_deg.percentile_upper,
        text=f"{found.n_samples - found.n_failed:,} samples of the true model",
    )


def _cancel(session: "Session", value: Any) -> None:
    if session.study.job is not None:
        session.study.job.cancel()
    elif value is not None:
        session.notices.tell(value.client_id, "Nothing to cancel", "No study is running.")


def _show_band(session: "Session", value: Any) -> None:
    session.study.with_band = bool(value.value)
    refresh(session)


def _load(session: "Session", value: Any) -> None:
    moment = study_markup.LOADS[value.value]
    session.study.load = int(np.argmin(np.abs(MOMENT - moment)))
    refresh(session)


def _chart(session: "Session", value: Any) -> None:
    session.study.chart = value.value
    refresh(session)


def refresh(session: "Session") -> None:
    """Bring texts, charts and band of the study up to date; cheap if nothing has changed."""
    desk, state = session.study, session.state
    _draw_band(session)
    found = (desk.sampled, desk.influence, desk.paper)
    stale = [f is not None and state.is_stale(f) for f in found]
    made_of: tuple[Any, ...] = (
        *found,
        desk.load,
        desk.chart,
        session.view.dark,
        *stale,
    )
    if desk.chart == study_tab.SLOPES:
        made_of += (state.result, session.is_stale())
    if made_of == desk.written:
        return
    desk.written = made_of
    tab = session.view.study
    by_file = {"uncertainty": desk.sampled, "influence": desk.influence, "paper": desk.paper}
    for name, handle in tab.files.items():
        handle.disabled = by_file[name.partition(".")[0]] is None
    if desk.paper is not None:
        tab.judged.content = study_markup.judged(desk.paper.words, stale=stale[2])
    tab.band.visible = desk.sampled is not None
    if desk.sampled is not None:
        tab.sampled.content = study_markup.sampling(desk.sampled, stale=stale[0])
    session.view.influence.content.content = _charts(session, stale=stale[1])


def _draw_band(session: "Session") -> None:
    """Draw the sampling's band where no other is; take it away once it is of other bounds."""
    desk = session.study
    fits = desk.sampled is not None and not session.state.is_stale(desk.sampled)
    if fits and desk.with_band and session.band is None:
        session.show_band(desk.band)
    elif session.band is not None and session.band is desk.band and not (fits and desk.with_band):
        session.show_band(None)


def _charts(session: "Session", *, stale: bool) -> str:
    desk, colours = session.study, theme.palette(session.view.dark)
    if desk.chart == study_tab.SLOPES:
        return _slopes(session)
    found = desk.influence
    if found is None:
        return markup.box(
            "Which parameters decide each angle? Press <b>Influence</b> in the tab “Study” on the "
            "right: some seconds."
        )
    moment = float(MOMENT[desk.load])
    answer = found.answer(moment, label=markup.parameter_label).replace(" N m", " N·m:", 1)
    words = markup.escape(answer)
    head = markup.box(
        f"<b>{words}</b>" + influence_chart.groups(found, desk.load, colours),
        style="font-size:12px",
    )
    draw = influence_chart.bars if desk.chart == study_tab.BARS else influence_chart.heat_map
    foot = influence_chart.caption(found, bars=desk.chart == study_tab.BARS)
    body = markup.box(draw(found, desk.load, colours) + markup.faint(foot), style="padding-top:0")
    note = markup.box(study_markup.STALE) if stale else ""
    return f'<div style="{study_markup.STALE_STYLE if stale else ""}">{note}{head}{body}</div>'


def _slopes(session: "Session") -> str:
    result = session.state.result
    if result is None:
        return markup.box(
            "What separates the two worst cases? Search for them first (tab “Search”)."
        )
    try:
        slopes = kneecore.worst_case_slopes(result)
    except KneecoreError as error:
        return markup.box(markup.escape(str(error)))
    colours = theme.palette(session.view.dark)
    stale = session.is_stale()
    return markup.box(
        (study_markup.STALE if stale else "")
        + influence_chart.slopes(slopes, session.study.load, colours),
        style=study_markup.STALE_STYLE if stale else "",
    )


def _file(session: "Session", value: Any, name: str) -> None:
    client, desk = session.clients().get(value.client_id), session.study
    if client is None:
        return
    content = study_file(desk, session.state.result, name)
    if content is None:
        session.notices.tell(value.client_id, "Nothing to download", "That has not been computed.")
        return
    client.send_file_download(name, content, save_immediately=True)


DEEDS: dict[str, Callable[..., None]] = {
    "study": _run,
    "study_progress": _progress,
    "study_done": _done,
    "study_cancel": _cancel,
    "study_band": _show_band,
    "study_file": _file,
    "influence_load": _load,
    "influence_chart": _chart,
}

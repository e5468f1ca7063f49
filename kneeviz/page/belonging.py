"""Whether what is drawn belongs to what is set: the one place that knows, and that decides.

Each thing on the page that was computed carries its origin (`kneeviz.state.origin`). What it does
not share with the present state makes it stale: its text is greyed and says what has changed, its
lines and bones fade, or it is left out.
"""

from collections.abc import Callable
from dataclasses import replace
from operator import attrgetter

from kneeviz.jobs.paper_files import PaperFiles
from kneeviz.page.page import Page
from kneeviz.state.ghosts import Ghosts
from kneeviz.state.knee import Solved
from kneeviz.state.origin import Origin, of_found
from kneeviz.state.shown import Band
from kneeviz.views.html.pieces import box

WORST, BAND, KNEE, SURROGATE, LANDSCAPE = "worst", "band", "knee", "surrogate", "landscape"
BASELINE, METHODS, SAMPLING, INFLUENCE = "baseline", "methods", "sampling", "influence"
ACCURACY, PAPER, GHOSTS = "accuracy", "paper", "ghosts"

TEXTS: dict[str, tuple[str, ...]] = {
    "transport.readout": (KNEE,),
    "error": (KNEE, SURROGATE),
    "marks": (KNEE,),
    "found": (WORST,),
    "search.found": (WORST,),
    "search.table": (WORST,),
    "files.command": (WORST,),
    "methods.content": (METHODS,),
    "influence.content": (INFLUENCE,),
    "study.sampled": (SAMPLING,),
    "study.accuracy": (ACCURACY,),
    "study.judged": (PAPER,),
    "study.key": (LANDSCAPE,),
}
"""Every text of the view that tells of something computed, by its place, and of what."""
PICTURES: dict[str, tuple[str, ...]] = {
    "curve": (BASELINE, KNEE, SURROGATE, WORST, BAND, GHOSTS),
    "forces": (BASELINE, KNEE, WORST),
    "ap": (BASELINE, KNEE, WORST),
    "curve_legend": (KNEE, WORST, BAND, GHOSTS),
    "force_legend": (KNEE, WORST),
    "ap_legend": (KNEE, WORST),
    "comparison": (KNEE, WORST),
    "scene": (KNEE, WORST, GHOSTS),
    "landscape": (LANDSCAPE,),
    "handles": (KNEE,),
}
"""Every chart, picture and key, by its place, and what it draws: each in its own colours, which
fade, or not at all."""
OTHERS = {
    "transport.status": "what the app is doing now",
    "search.intro": "the same always",
    "search.rising": "how far the search is that runs",
    "search.live_note": "what live does now; empty without it",
    "study.intro": "the same always",
    "learn.page": "the lesson",
    "learn.verdict": "what was seen when a step was revealed, of the lesson's own knee and bounds",
    "look.note": "the same always",
    "files.link": "opens what is set now; gone as soon as that changes",
    "class_size": "a style, no text",
}
"""Every text of the view that tells of nothing computed, and why it may stand."""

_GREY = "opacity:.45"
_WORDS = {
    "baseline": "Baseline",
    "bounds": "Bounds",
    "rest_lengths": "Rest lengths",
    "knee": "Knee",
    "axes": "Axes",
}


def _of(found: object | None) -> Origin | None:
    return None if found is None else of_found(found)


def _carried(drawn: Solved | Band | None) -> Origin | None:
    return None if drawn is None else drawn.origin


def _of_paper(paper: PaperFiles | None) -> Origin | None:
    """Return the origin of the paper redone, which leaves rest lengths alone."""
    return None if paper is None else replace(of_found(paper), rest_lengths=None)


_ORIGINS: dict[str, Callable[[Page], Origin | None]] = {
    KNEE: lambda page: _carried(page.state.current),
    BASELINE: lambda page: _carried(page.state.baseline),
    SURROGATE: lambda page: _of(page.state.surrogate),
    WORST: lambda page: _of(page.state.result),
    BAND: lambda page: _carried(page.band),
    METHODS: lambda page: _of(page.methods.found),
    SAMPLING: lambda page: _of(page.study.sampled),
    INFLUENCE: lambda page: _of(page.study.influence),
    ACCURACY: lambda page: _of(page.study.accuracy),
    PAPER: lambda page: _of_paper(page.study.paper),
    LANDSCAPE: lambda page: page.landscape.origin,
    GHOSTS: lambda page: _carried(page.ghosts[0] if page.ghosts else None),
}


def changed(page: Page, subject: str) -> tuple[str, ...]:
    """Return which parts of the state have changed since a subject was computed."""
    if subject == KNEE and (page.unsolved or page.animation.morphing):
        return ()  # it is on its way
    if subject in (WORST, BAND) and page.live.keeps_up:
        return ()  # but for a moment, it is that of the present bounds
    origin = _ORIGINS[subject](page)
    if origin is None:
        return ()
    around_knee = origin.knee is not None and subject in (WORST, BAND)
    now = page.state.origin(around_knee=around_knee)
    if subject == LANDSCAPE:
        now = replace(now, axes=page.landscape.axes)
    return origin.changed(now)


def fits(page: Page, subject: str) -> bool:
    """Tell whether a subject belongs to the present state, or is not there."""
    return not changed(page, subject)


def band(page: Page) -> Band | None:
    """Return the sampling band to draw: one of other bounds is none."""
    return page.band if fits(page, BAND) else None


def ghosts(page: Page) -> Ghosts:
    """Return the earlier knees to draw: those of another baseline or rule are left out."""
    if not page.keeps_ghosts:
        return ()
    now = page.state.origin()
    return tuple(ghost for ghost in page.ghosts if not ghost.origin.changed(now))


Standing = dict[str, tuple[str, ...]]
"""What has changed since each subject was computed."""


def standing(page: Page) -> Standing:
    """Return what has changed since each subject was computed."""
    return {subject: changed(page, subject) for subject in _ORIGINS}


def faded(now: Standing) -> frozenset[str]:
    """Return the subjects whose lines, bones and sheets fade."""
    return frozenset(subject for subject in (KNEE, WORST, LANDSCAPE) if now[subject])


def write(page: Page, place: str, content: str, *, of: str | None = None, since: str = "") -> None:
    """Write a text of the view; what does not belong to the present state is greyed and says so.

    Parameters
    ----------
    page : Page
    place : str
        One of `TEXTS`.
    content : str
    of : str, optional
        The subject that it tells of, where that is not always the same.
    since : str
        What the subject is called: "this search".
    """
    subjects = TEXTS[place] if of is None else (of,)
    parts = [part for subject in subjects for part in changed(page, subject)]
    if parts and content:
        note = box(f"<b>{_told(subjects, parts)} {since}".rstrip() + ".</b>")
        content = f'<div style="{_GREY}">{note}{content}</div>'
    attrgetter(place)(page.view).content = content


def _told(subjects: tuple[str, ...], parts: list[str]) -> str:
    if subjects[0] == KNEE and "knee" in parts:
        return "The model fails for the present values; this is of the last good knee"
    if "knee" in parts and WORST in subjects:
        return "Knee or bounds changed since"
    words = " and ".join(_WORDS[part] for part in dict.fromkeys(parts))
    return f"{words.capitalize()} changed since"

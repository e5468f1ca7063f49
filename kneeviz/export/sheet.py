"""The lesson on paper: one HTML file with all questions, and the answers on a page of their own."""

from importlib import resources

import numpy as np

from kneecore import SearchSettings, packaged_knee, worst_case
from kneecore.knee.parameters import widened
from kneecore.progress import Callback
from kneecore.search.settings import enough_samples
from kneeviz.export.still import still
from kneeviz.state.bounds import WIDTH
from kneeviz.state.knee import KneeState
from kneeviz.state.lesson_facts import FACTS, Fact
from kneeviz.state.lesson_steps import STEPS, Step
from kneeviz.state.presets import random_knee
from kneeviz.views.html.lesson import answer_words, told

_SEED = 1
"""Of the random knee at which the sheet asks the surrogate."""
_SHOWN = 2.0
"""N m; under it the knee of the picture is nearly straight, and its ligaments stand apart."""
TITLE = "Why one millimetre matters: a lesson about the knee"
INTRO = (
    "A planar model of a human knee, seen from the side: thigh bone above, shin bone below, four "
    "ligaments (ACL, PCL, MCL, LCL), a round condyle on a straight plateau. Predict first, then "
    "look: the app shows each answer in the tab “Learn”."
)
NAME, DATE, WHY = "Name", "Date", "Why do you think so?"
PICTURE = "The knee, nearly straight, seen from the side, with its four ligaments"
ANSWERS = "Answers"
ANSWERS_INTRO = "Numbers of the packaged knee within its own bounds, computed when this was made."
LIMITS = (
    "The knee is a reconstruction and planar: no muscles, kneecap, gravity or friction. It is no "
    "medical device. After A. Ciszkiewicz and R. Dumas, Front. Mech. Eng. 10:1392616 (2024), "
    "doi 10.3389/fmech.2024.1392616."
)


def html_sheet(callback: Callback | None = None) -> str:
    """Return the lesson as a page to print on A4.

    Raises
    ------
    Cancelled
        If `callback`, which gets reports of the search that one answer needs, asked to stop.
    """
    state = _prepared(callback)
    questions = "".join(_question(at, step) for at, step in enumerate(STEPS))
    answers = "".join(_answer(at, step, FACTS[step.name](state)) for at, step in enumerate(STEPS))
    fields = f'<p class="field">{NAME}</p><p class="field">{DATE}</p>'
    style = resources.files("kneeviz.export").joinpath("sheet.css").read_text(encoding="utf-8")
    policy = "default-src 'none'; style-src 'unsafe-inline'"
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{TITLE}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n"
        f"<header><div><h1>{TITLE}</h1><p>{INTRO}</p>{fields}</div>{_picture(state)}</header>\n"
        f'{questions}<div class="answers"><h1>{ANSWERS}</h1><p>{ANSWERS_INTRO}</p>\n{answers}'
        f"</div>\n</main>\n<footer>{LIMITS}</footer>\n</body>\n</html>\n"
    )


def _prepared(callback: Callback | None) -> KneeState:
    """Return the packaged knee with all that the steps' facts are told of."""
    state = KneeState(packaged_knee())
    state.solve_baseline()
    state.fit()
    state.x = widened(random_knee(state.space, np.random.default_rng(_SEED)), WIDTH)
    knees = state.knees()
    settings = SearchSettings(
        search_space="surrogate", training_samples=enough_samples(knees.n_free)
    )
    state.take_result(worst_case(knees, settings, callback=callback))
    return state


def _picture(state: KneeState) -> str:
    sweep = None if state.baseline is None else state.baseline.sweep
    return "" if sweep is None else still(sweep.x, sweep.at_moment(_SHOWN), label=PICTURE)


def _heading(at: int, step: Step) -> str:
    return f"<h2>{at + 1}. {step.title}</h2>"


def _question(at: int, step: Step) -> str:
    """Return a step with room for its answer."""
    if step.choices:
        choices = "".join(f"<li>{choice}</li>" for choice in step.choices)
        room = f'<ul class="choices">{choices}</ul>'
    else:
        room = f'<p class="number"><span class="room"></span>{step.unit}</p>'
    return (
        f'<section class="step">{_heading(at, step)}<p>{step.text}</p>'
        f'<p class="question">{step.question}</p>{room}<p class="why">{WHY}</p></section>\n'
    )


def _answer(at: int, step: Step, fact: Fact | None) -> str:
    """Return a step's answer; nothing where the model failed."""
    if fact is None:
        return ""
    right = answer_words(step, fact.right)
    return f"<section>{_heading(at, step)}<p><b>{right}.</b> {told(step, fact)}</p></section>\n"

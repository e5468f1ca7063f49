"""What is held back during the lesson, so that a question is not answered too early."""

from dataclasses import replace

import numpy as np

from kneeviz.page.page import Page
from kneeviz.state.lesson_steps import CURVES, SAMPLES, STAND_IN, STEPS
from kneeviz.state.shown import Shown


def hides(page: Page, what: str) -> bool:
    """Tell whether the open step of the lesson holds something back."""
    if page.lesson is None:
        return False
    step = STEPS[page.lesson]
    return what in (step.still_hidden if page.answers.revealed else step.hidden)


def held_back(page: Page, shown: Shown) -> Shown:
    """Return what the charts show now, without what the lesson holds back."""
    if hides(page, CURVES):
        shown = replace(shown, sweeps=(None,) * len(shown.sweeps))
    if hides(page, CURVES) or hides(page, STAND_IN):
        shown = replace(shown, predicted=None)
    if hides(page, SAMPLES) and shown.training is not None:
        # Lines of nothing: fewer lines would make another chart.
        shown = replace(shown, training=np.full_like(shown.training, np.nan))
    return shown

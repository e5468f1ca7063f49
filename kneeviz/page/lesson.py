"""What the charts hold back during the lesson, so that a question is not answered too early."""

from dataclasses import replace

import numpy as np

from kneeviz.page.page import Page
from kneeviz.state.lesson_steps import CURVES, SAMPLES, STAND_IN, STEPS
from kneeviz.state.shown import Shown


def held_back(page: Page, shown: Shown) -> Shown:
    """Return what the charts show now, without what the open step of the lesson holds back."""
    if page.lesson is None:
        return shown
    step = STEPS[page.lesson]
    hidden = step.hidden if page.answers.fact is None else step.still_hidden
    if CURVES in hidden:
        shown = replace(shown, sweeps=(None,) * len(shown.sweeps))
    if STAND_IN in hidden:
        shown = replace(shown, predicted=None)
    if SAMPLES in hidden and shown.training is not None:
        # Lines of nothing: fewer lines would make another chart.
        shown = replace(shown, training=np.full_like(shown.training, np.nan))
    return shown

"""Ghosts: the visitor's last few knees, kept faint. Runs on the session's worker."""

from collections.abc import Callable

import numpy as np

from kneeviz.jobs.messages import Asked
from kneeviz.page.page import Page
from kneeviz.state.ghosts import with_ghost
from kneeviz.state.snapshot import Snapshot


def leave_behind(page: Page, last: Snapshot) -> bool:
    """Keep the knee of the step that is over as a ghost; return whether there is one to keep."""
    state, now = page.state, page.history.present
    same_rules = last.knee is now.knee and last.bounds.rest_length == now.bounds.rest_length
    if not (page.keeps_ghosts and page.model_ready and same_rules) or np.array_equal(last.x, now.x):
        return False
    shown = state.current
    there = shown is not None and np.array_equal(shown.x, last.x)
    knee = shown if shown is not None and there else state.solve(last.x)
    page.ghosts = with_ghost(page.ghosts, knee)
    page.touched = True
    return True


def _ghosts(page: Page, value: Asked) -> None:
    show_ghosts(page, bool(value.value))


def show_ghosts(page: Page, wanted: bool) -> None:
    """Keep and show the last few knees from now on, or show none."""
    page.keeps_ghosts = wanted
    page.touched = True
    if page.view.look.ghosts.value != wanted:
        page.view.look.ghosts.value = wanted


def _clear(page: Page, _value: Asked) -> None:
    page.ghosts = ()
    page.history.amend(page.snapshot())
    page.touched = True


ACTIONS: dict[str, Callable[..., None]] = {"ghosts": _ghosts, "clear_ghosts": _clear}

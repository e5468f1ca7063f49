"""Undo, redo and start over on a model's page. Runs on the session's worker."""

import time
from collections.abc import Hashable
from typing import Any

from kneecore import FileFormatError
from kneeviz.anymodel.actions.search import forget_result, set_overlay, stop_search, take_result
from kneeviz.anymodel.actions.study import choose_column, set_band
from kneeviz.anymodel.page import ModelPage
from kneeviz.anymodel.snapshot import ModelSnapshot
from kneeviz.page import steps

_FOLLOWS = frozenset({"ran"})
"""What brings the page up to date: a slow model's studies begin in its surrogate. No step."""


def note(page: ModelPage, key: Hashable, value: Any) -> None:
    """Keep the state of a page after something was done under `key`, if it has changed."""
    name = key[0] if isinstance(key, tuple) else key
    if name in _FOLLOWS:
        is_new = page.history.amend(page.snapshot())
    else:
        is_new = steps.noted(page, key, value)
    if is_new:
        _keep(page)


def _keep(page: ModelPage) -> None:
    if page.keep is not None:
        page.keep(page.history.present)


def restore(page: ModelPage, wanted: ModelSnapshot) -> None:
    """Bring a page into the state of a snapshot."""
    page.view.settings.put(wanted.settings)
    if wanted.result is None:
        forget_result(page)
    elif wanted.result is not page.state.result:
        take_result(page, wanted.result)
    set_overlay(page, wanted.overlay)
    set_band(page, wanted.band)
    choose_column(page, wanted.column)
    page.move_to(wanted.x)
    page.show_pace()


def open_as_left(page: ModelPage, left: ModelSnapshot) -> None:
    """Open a page in the state in which it was left; one step back is where it began.

    Raises
    ------
    FileFormatError
        If the page has no such settings.
    """
    fault = page.view.settings.fault(left.settings)
    if fault is not None:
        raise FileFormatError(f"the state's `settings`: {fault}")
    restore(page, left)
    page.history.record(page.snapshot(), who=None, what=None, now=time.monotonic())
    page.history.rest()


ACTIONS = steps.actions(
    restore,
    keep=_keep,
    stop_search=stop_search,
    started_over="Started over. Undo brings back what you had.",
)

"""Undo, redo and start over. Runs on the session's worker."""

import time
from collections.abc import Hashable
from dataclasses import replace
from typing import Any

import numpy as np

from kneecore import FileFormatError
from kneeviz.actions.ghosts import leave_behind
from kneeviz.actions.knee import mirror_bounds, name_knee, refit
from kneeviz.actions.live import set_live
from kneeviz.actions.result import forget_result, take_result
from kneeviz.actions.search import stop_search
from kneeviz.actions.view import set_overlay
from kneeviz.jobs.messages import asked_by
from kneeviz.page import steps
from kneeviz.page.page import Page
from kneeviz.state.presets import BASELINE, OWN_KNEE
from kneeviz.state.snapshot import Snapshot

_FOLLOWS = frozenset({"live_found", "settle", "ready"})
"""What brings the page up to date with a step that there is: no steps of their own."""

_AT_WILL = frozenset(
    {"undo", "redo", "start_over", "change", "lesson_press", "lesson_turn", "link", "open_link"}
)
"""What sets knee and bounds together, as was asked."""


def note(page: Page, key: Hashable, value: Any) -> None:
    """Keep the state of a page after something was done under `key`, if it has changed."""
    name = key[0] if isinstance(key, tuple) else key
    last, present = page.history.present, page.snapshot()
    if name in _FOLLOWS:
        is_new = page.history.amend(present)
    else:
        is_new = steps.noted(page, key, value, drag=_dragged(page, key, value))
        if name == "grab_end":
            page.history.rest()
    if is_new and name not in _AT_WILL:
        _tell_what_was_clipped(page, last, asked_by(value))
        if page.history.last is last and leave_behind(page, last):  # a step has begun
            page.history.amend(page.snapshot())
    if is_new:
        _keep(page)


def _keep(page: Page) -> None:
    if page.keep is not None and page.set_aside is None:  # a lesson is nothing to come back to
        page.keep(page.history.present)


def _tell_what_was_clipped(page: Page, last: Snapshot, client_id: int | None) -> None:
    """Tell, once the hand rests, that other bounds have moved the knee."""
    now = page.history.present
    if now.knee is not last.knee or now.bounds == last.bounds:
        return
    n = np.count_nonzero(now.x != last.x)
    if n > 0:
        values = "One value of the knee was" if n == 1 else f"{n} values of the knee were"
        text = f"{values} beyond the new bounds and set to them. Undo brings the knee back."
        page.notices.remark(client_id, "Limited", text)


def _dragged(page: Page, key: Hashable, value: Any) -> Hashable | None:
    """Return the drag of a handle that `key` belongs to, from its start to its end, or None."""
    if isinstance(key, tuple) and key[0] in ("grab_start", "grab_update", "grab_end"):
        return ("drag", *key[1:])
    if key == "handle_escape":
        held = (g for g in page.handles.grabs.values() if g.client_id == asked_by(value))
        return next((("drag", g.handle.name, g.edge, g.client_id) for g in held), None)
    return None


def restore(page: Page, wanted: Snapshot) -> None:
    """Bring a page into the state of a snapshot; its knee turns into that one."""
    page.settle_at, page.unsolved = None, False
    page.view.set_settings(wanted.settings)
    _restore_box(page, wanted)
    set_live(page, wanted.live)
    page.ghosts = wanted.ghosts
    _restore_result(page, wanted)
    page.move_to(wanted.x)
    name_knee(page, BASELINE if page.state.at_baseline else OWN_KNEE)


def _restore_box(page: Page, wanted: Snapshot) -> None:
    state = page.state
    if wanted.knee is state.knee and wanted.bounds == state.bounds:
        return
    state.take_box(wanted.knee, wanted.bounds)
    mirror_bounds(page)
    if page.model_ready:
        state.solve_baseline()
    refit(page, None)


def _restore_result(page: Page, wanted: Snapshot) -> None:
    if wanted.live:  # it finds its own
        return
    if wanted.result is None:
        forget_result(page)
        return
    take_result(page, wanted.result, reveal=False)
    set_overlay(page, wanted.overlay)


def complete(page: Page, told: Snapshot) -> Snapshot:
    """Return a state that was told, with all settings: what it does not name is as at first.

    Raises
    ------
    FileFormatError
        If the page has no such settings.
    """
    fault = page.view.settings.fault(told.settings)
    if fault is not None:
        raise FileFormatError(f"the state's `settings`: {fault}")
    all_settings = dict(page.view.first_settings) | dict(told.settings)
    return replace(told, settings=tuple(all_settings.items()))


def open_as_left(page: Page, left: Snapshot) -> None:
    """Open a page in the state in which it was left; one step back is where it began.

    Raises
    ------
    FileFormatError
        If the page has no such settings.
    """
    restore(page, complete(page, left))
    page.history.record(page.snapshot(), who=None, what=None, now=time.monotonic())
    page.history.rest()


ACTIONS = steps.actions(
    restore,
    keep=_keep,
    stop_search=stop_search,
    started_over="Started over: knee, bounds and settings as at first. Undo brings yours back.",
)

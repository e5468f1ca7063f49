"""Undo, redo and start over. Runs on the session's worker."""

import time
from collections.abc import Callable, Hashable
from typing import Any

from kneeviz.actions.knee import mirror_bounds, name_knee, refit
from kneeviz.actions.live import set_live
from kneeviz.actions.result import forget_result, take_result
from kneeviz.jobs.messages import Asked, asked_by
from kneeviz.page.page import Page
from kneeviz.state.presets import BASELINE, OWN_KNEE
from kneeviz.state.snapshot import Snapshot
from kneeviz.views.tabs.transport import REDO, START_OVER, UNDO

_FOLLOWS = frozenset({"live_found", "settle", "ready"})
"""What brings the page up to date with a step that there is: no steps of their own."""


def note(page: Page, key: Hashable, value: Any) -> None:
    """Keep the state of a page after something was done under `key`, if it has changed."""
    name = key[0] if isinstance(key, tuple) else key
    if name in _FOLLOWS:
        page.history.amend(page.snapshot())
        return
    page.history.record(page.snapshot(), who=asked_by(value), what=key, now=time.monotonic())


def restore(page: Page, wanted: Snapshot) -> None:
    """Bring a page into the state of a snapshot; its knee turns into that one."""
    page.settle_at, page.unsolved = None, False
    page.view.set_settings(wanted.settings)
    _restore_box(page, wanted)
    set_live(page, wanted.live)
    _restore_result(page, wanted)
    page.move_to(wanted.x)
    name_knee(page, BASELINE if page.state.at_baseline else OWN_KNEE)


def _restore_box(page: Page, wanted: Snapshot) -> None:
    state = page.state
    if wanted.knee is state.knee and wanted.bounds == state.bounds:
        return
    state.take_box(wanted.knee, wanted.bounds)
    page.show_band(None)
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
    page.show_overlay(wanted.overlay)


def _step(page: Page, value: Asked | None, wanted: Snapshot | None, name: str) -> None:
    if wanted is None:
        if value is not None:
            page.notices.tell(value.client_id, f"Nothing to {name}", "No change is left there.")
        return
    changes = wanted.changes_from(page.snapshot())
    restore(page, wanted)
    page.history.amend(page.snapshot())
    page.say(f"{name.capitalize()}: {', '.join(changes)}.")


def _undo(page: Page, value: Asked | None) -> None:
    _step(page, value, page.history.undo(), "undo")


def _redo(page: Page, value: Asked | None) -> None:
    _step(page, value, page.history.redo(), "redo")


def _start_over(page: Page, _value: Asked | None) -> None:
    """Go back to where the page began; a step like others, so that it can be undone."""
    page.history.rest()
    if page.search.job is not None:
        page.search.job.cancel()
    restore(page, page.history.start)
    page.say("Started over: knee, bounds and settings as at first. Undo brings yours back.")


def _change(page: Page, value: Asked) -> None:
    {UNDO: _undo, REDO: _redo, START_OVER: _start_over}[value.value](page, value)


ACTIONS: dict[str, Callable[..., None]] = {
    "undo": _undo,
    "redo": _redo,
    "start_over": _start_over,
    "change": _change,
}

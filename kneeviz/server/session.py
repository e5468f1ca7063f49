"""The loop of one page: takes what was asked, has it done, lets things move, has it drawn.

A session belongs to the server (everybody sees the same knee) or to a single client. Callbacks post
to the session's mailbox; its worker thread alone touches the page and its handles.
"""

import logging
import time
from collections.abc import Hashable
from typing import Any

from kneecore import KneeFile
from kneeviz import viser_internals
from kneeviz.actions import landscape, lesson, links, live, methods, standing, study, table, undo
from kneeviz.jobs.worker import Actions
from kneeviz.page.drawing import Drawing
from kneeviz.page.loop import Loop
from kneeviz.page.page import Clients, Page, Target
from kneeviz.state import saved
from kneeviz.state.playback import FRAME_SECONDS
from kneeviz.state.snapshot import Snapshot

_LOG = logging.getLogger(__name__)
_DRAG_SECONDS, _DRAG_FRAME = 0.4, 0.1  # s: how long a slider counts as moving, and a frame then
_UNSEEN_FRAME = 0.5  # s: when nobody looks


class Session(Loop[Page]):
    """A page and the worker that keeps it going.

    Parameters
    ----------
    target : ViserServer or ClientHandle
        Where the page is built.
    knee : KneeFile
        The baseline.
    clients : callable
        Returns the clients that look at this page, by their number.
    """

    def __init__(self, target: Target, knee: KneeFile, clients: Clients) -> None:
        super().__init__()
        self.page = Page(target, knee, clients, self.post)
        self.drawing = Drawing(self.page)
        viser_internals.guard(target.gui, self.reject)

    def start(self) -> None:
        """Draw the knee and start the worker."""
        self.drawing.draw_load_free()
        self._worker.start()

    def open_as_left(self, left: Snapshot) -> None:
        """Open the page in a state in which it was left, before `start`."""
        undo.open_as_left(self.page, left)

    def told(self, state: Snapshot) -> str:
        """Return a state of the page as the text of a file."""
        return saved.to_text(state)

    # The worker's thread from here on.

    def _step(self, actions: Actions) -> float | None:
        page, now = self.page, time.monotonic()
        was_moving = page.moving
        for key, value in actions:
            if not table.moves_a_slider(key):  # those that have moved together are one knee
                self._catch_up()
            self._perform(key, value)
        self._catch_up()
        if page.settle_at is not None and now >= page.settle_at:
            self._perform("settle", None)
        slow_at = live.follow(page)
        page.advance(now)
        if actions:
            lesson.tell(page)
        if actions or page.touched:
            standing.follow(page)
            links.follow(page)
        held, page.held = page.held, False
        news = page.touched or was_moving or page.moving or (bool(actions) and not held)
        if page.model_ready and news:
            self.drawing.draw()
        else:
            page.target.flush()
        if self.drawing.rest_at is not None and now >= self.drawing.rest_at:
            self._draw_rest()
        return self._due(now, slow_at)

    def _draw_rest(self) -> None:
        if not self.drawing.draw_rest():
            return
        for subject in (study, methods, landscape):
            subject.refresh(self.page)
        self.page.target.flush()

    def _due(self, now: float, slow_at: float | None) -> float | None:
        """Return when to step again though nothing is asked, s of `time.monotonic`."""
        page = self.page
        times = (page.notices.deliver(now), slow_at, page.settle_at, self.drawing.rest_at)
        due = min((t for t in times if t is not None), default=None)
        if not page.moving:
            return due
        if not page.clients():
            return now + _UNSEEN_FRAME
        # Under a moving slider its answers are the frames: more would only keep them waiting.
        frame = _DRAG_FRAME if now - page.edited_at < _DRAG_SECONDS else FRAME_SECONDS
        return now + frame if due is None else min(due, now + frame)

    def _catch_up(self) -> None:
        try:
            self.page.catch_up()
        except Exception as error:
            _LOG.exception("the knee cannot be solved")
            self._say_failed(error)

    def _act(self, key: Hashable, value: Any) -> None:
        table.perform(self.page, key, value)

    def _perform(self, key: Hashable, value: Any) -> None:
        super()._perform(key, value)
        undo.note(self.page, key, value)

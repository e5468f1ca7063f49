"""The loop of a model's page: takes what was asked, has it done, has it drawn."""

import time
from collections.abc import Hashable
from typing import Any

from kneecore import Model
from kneeviz import viser_internals
from kneeviz.anymodel import saved
from kneeviz.anymodel.actions import study, table, undo
from kneeviz.anymodel.page import ModelPage
from kneeviz.anymodel.snapshot import ModelSnapshot
from kneeviz.jobs.worker import Actions
from kneeviz.page.loop import Loop
from kneeviz.page.page import Clients, Target
from kneeviz.state.playback import FRAME_SECONDS


class ModelSession(Loop[ModelPage]):
    """A model's page and the worker that keeps it going.

    Parameters
    ----------
    target : ViserServer or ClientHandle
        Where the page is built.
    model : Model
    clients : callable
        Returns the clients that look at this page, by their number.
    """

    def __init__(self, target: Target, model: Model, clients: Clients) -> None:
        super().__init__()
        self.page = ModelPage(target, model, clients, self.post)
        viser_internals.guard(target.gui, self.reject)

    def start(self) -> None:
        """Start the worker, and the model's first run."""
        self.page.start()
        self._worker.start()

    def open_as_left(self, left: ModelSnapshot) -> None:
        """Open the page in a state in which it was left, before `start`."""
        undo.open_as_left(self.page, left)

    def told(self, state: ModelSnapshot) -> str:
        """Return a state of the page as the text of a file."""
        return saved.to_text(state, self.page.state.model)

    # The worker's thread from here on.

    def _step(self, actions: Actions) -> float | None:
        page, now = self.page, time.monotonic()
        for key, value in actions:
            self._perform(key, value)
        if page.touched:
            page.draw()
        page.framing.follow(page.subject, now)
        page.framing.advance(now)
        frame = now + FRAME_SECONDS if page.framing.running else None
        times = (study.follow(page, now), page.notices.deliver(now), frame)
        page.target.flush()
        return min((t for t in times if t is not None), default=None)

    def _act(self, key: Hashable, value: Any) -> None:
        table.perform(self.page, key, value)

    def _perform(self, key: Hashable, value: Any) -> None:
        super()._perform(key, value)
        undo.note(self.page, key, value)

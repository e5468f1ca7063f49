"""The loop of a model's page: takes what was asked, has it done, has it drawn."""

import logging
import time
from collections.abc import Hashable
from typing import Any

from kneecore import Model
from kneeviz import viser_internals
from kneeviz.anymodel.actions import study, table
from kneeviz.anymodel.page import ModelPage
from kneeviz.jobs.messages import asked_by
from kneeviz.jobs.worker import Actions, Worker
from kneeviz.page.page import Clients, Target
from kneeviz.state.playback import FRAME_SECONDS
from kneeviz.views.html.pieces import escape

_LOG = logging.getLogger(__name__)


class ModelSession:
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
        self._worker = Worker(self._step, self._failed)
        self.page = ModelPage(target, model, clients, self.post)
        viser_internals.guard(target.gui, self.reject)

    def start(self) -> None:
        """Start the worker, and the model's first run."""
        self.page.start()
        self._worker.start()

    def stop(self) -> None:
        """End the worker and whatever runs for the page."""
        self.page.stop()
        self._worker.stop()

    def post(self, key: Hashable, value: Any = None) -> None:
        """Ask the worker for something; returns at once."""
        self._worker.mailbox.post(key, value)

    def reject(self, client_id: int, handle: Any, fault: str, sent: Any) -> None:
        """Note that a client's message was turned away; it is told once it stops."""
        self.post(("reject", client_id), (client_id, handle, fault, sent))

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

    def _perform(self, key: Hashable, value: Any) -> None:
        """Do one thing; if it fails, the rest goes on and whoever asked is told."""
        try:
            table.perform(self.page, key, value)
        except Exception as error:
            _LOG.exception("%s failed", key)
            self._say_failed(error)
            client_id = asked_by(value)
            if client_id is not None:
                self.page.notices.tell(client_id, "That did not work", str(error)[:300])

    def _failed(self, error: Exception) -> None:
        self._say_failed(error)
        self.page.target.flush()

    def _say_failed(self, error: Exception) -> None:
        self.page.say(f"That did not work: {escape(str(error))}", "bad")

"""The user's `draw`, called on a thread of its own: it may be slow, fail, or not return."""

import threading
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kneecore import Model, Shape
from kneeviz.jobs.messages import Post
from kneeviz.jobs.worker import Actions, Worker

FloatArray = NDArray[np.float64]

OWN, ONE, TWO = range(3)
"""Whose picture: that of the sliders, of worst model 1 and of 2."""
PATIENCE = 5.0
"""s after which the page says that a picture does not come; a thread cannot be ended."""


class Drawn(NamedTuple):
    """What became of one picture."""

    whose: int
    x: FloatArray
    shapes: Sequence[Shape] | None
    why: str | None
    """What `draw` did in the place of a picture."""


class Pictures:
    """Posts ("drawn", whose) with a `Drawn` for the latest point of each.

    Parameters
    ----------
    model : Model
    post : callable
    """

    def __init__(self, model: Model, post: Post) -> None:
        self._model, self._post = model, post
        self._worker = Worker(self._step, lambda _: None, name="pictures")
        self._started = False
        self._own: FloatArray | None = None

    def ask(self, whose: int, x: FloatArray) -> None:
        """Ask for a picture; one of the same that still waits is replaced."""
        if not self._started:
            self._started = True
            self._worker.start()
        if whose == OWN:
            self._own = x.copy()
        self._worker.mailbox.post(whose, x.copy())

    def stop(self) -> None:
        """End the thread, if the user's function lets it end."""
        self._worker.stop(timeout=0.2)

    def _step(self, actions: Actions) -> None:
        for whose, x in actions:
            assert isinstance(whose, int)
            late = threading.Event()
            timer = threading.Timer(PATIENCE, self._tell_late, (late,))
            timer.daemon = True
            timer.start()
            drawn = self._drawn(whose, x)
            timer.cancel()
            self._post(("drawn", whose), drawn)
            if late.is_set() and self._own is not None:  # what was said is no longer true
                self._worker.mailbox.post(OWN, self._own)

    def _drawn(self, whose: int, x: FloatArray) -> Drawn:
        try:
            return Drawn(whose, x, self._model.draw(x), None)
        except (Exception, SystemExit) as error:  # whatever a user's function raises
            told = " ".join(f"{type(error).__name__}: {error}".split())[:300]
            return Drawn(whose, x, None, f"raised {told}")

    def _tell_late(self, late: threading.Event) -> None:
        """Say that `draw` does not return; nothing is asked of it until it has."""
        late.set()
        why = f"has not returned for {PATIENCE:g} s; it is not called again until it has"
        self._post(("drawn", OWN), Drawn(OWN, np.zeros(0), None, why))

"""The user's `draw`, called on a thread of its own: it may be slow, or fail."""

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


class Drawn(NamedTuple):
    """What became of one picture."""

    whose: int
    x: FloatArray
    shapes: Sequence[Shape] | None
    why: str | None


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

    def ask(self, whose: int, x: FloatArray) -> None:
        """Ask for a picture; one of the same that still waits is replaced."""
        if not self._started:
            self._started = True
            self._worker.start()
        self._worker.mailbox.post(whose, x.copy())

    def stop(self) -> None:
        """End the thread, if the user's function lets it end."""
        self._worker.stop(timeout=0.2)

    def _step(self, actions: Actions) -> None:
        for whose, x in actions:
            assert isinstance(whose, int)
            shapes, why = None, None
            try:
                shapes = self._model.draw(x)
            except (Exception, SystemExit) as error:  # whatever a user's function raises
                why = " ".join(f"{type(error).__name__}: {error}".split())[:300]
            self._post(("drawn", whose), Drawn(whose, x, shapes, why))

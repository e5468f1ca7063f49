"""The model's own runs for the page: always the latest point that is asked for, never in the way.

They go on in a process apart, so that one that hangs or crashes takes nothing of the page away.
"""

import threading
import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kneecore import Cancelled, KneecoreError, Model
from kneeviz.jobs.messages import Post
from kneeviz.jobs.worker import Actions, Worker

FloatArray = NDArray[np.float64]

PATIENCE = 1.0
"""s that a run may go on after another point was asked for."""
_TELL_SECONDS = 1.0
_START_SECONDS = 20.0
"""A first run that takes less is done twice: the first time, a process starts and loads what the
model needs."""


def apart(model: Model) -> Model:
    """Return the model with its runs outside of this process, where they can be ended."""
    return model if model.run_options.workers is not None else model.with_runs(workers=1)


class Ran(NamedTuple):
    """What became of a run."""

    x: FloatArray
    y: FloatArray | None
    """The outputs, shape (m,), some of them perhaps NaN; None if there are none."""
    seconds: float
    why: str | None
    """What went wrong, in one line, if anything did."""

    @property
    def cancelled(self) -> bool:
        """Whether it was ended before it was done."""
        return self.y is None and self.why is None


class ModelRuns:
    """Posts "ran" with a `Ran` for the latest point, and "running" with its seconds meanwhile.

    Parameters
    ----------
    model : Model
    post : callable
        Gets the messages.
    """

    def __init__(self, model: Model, post: Post) -> None:
        # A file of runs is for those of searches: a slider leaves too many behind.
        self._model = apart(model).with_runs(keep=None)
        self._post = post
        self._worker = Worker(self._step, self._failed, name="runs")
        self._wanted: FloatArray | None = None
        self._cancelled = threading.Event()
        self._started = self._warm = False

    def ask(self, x: FloatArray) -> None:
        """Ask for a run; one that still waits is replaced."""
        self._wanted = x.copy()
        self._cancelled.clear()
        if not self._started:
            self._started = True
            self._worker.start()
        self._worker.mailbox.post("run", self._wanted)

    def cancel(self) -> None:
        """End the run that is under way."""
        self._cancelled.set()

    def stop(self) -> None:
        """End the thread and the process."""
        self._cancelled.set()
        self._worker.stop()
        self._model.close()

    def _step(self, actions: Actions) -> None:
        x: FloatArray = actions[-1][1]
        ran = self._run(x)
        if not self._warm and not ran.cancelled and ran.seconds < _START_SECONDS:
            self._warm = True
            ran = self._quicker(self._run(x))
        if not (ran.cancelled and self._wanted is not x):
            self._post("ran", ran)

    def _quicker(self, ran: Ran) -> Ran:
        """Return a run, or the same once more if that was quicker: other work may disturb one."""
        if ran.y is None or ran.seconds > _TELL_SECONDS:
            return ran
        return min(ran, self._run(ran.x), key=lambda one: one.seconds)

    def _run(self, x: FloatArray) -> Ran:
        begun = told = time.monotonic()

        def watch(_done: int) -> bool:
            nonlocal told
            now = time.monotonic()
            if now - told > _TELL_SECONDS:
                told = now
                self._post("running", now - begun)
            return self._is_over(x, now - begun)

        n_failed, y, why = len(self._model.failures), None, None
        try:
            y = self._model.examine(x[None], watch=watch).y[0]
        except Cancelled:
            pass
        except KneecoreError as error:
            why = str(error)
        if y is not None and not np.isfinite(y).all():
            failures = self._model.failures
            why = str(failures[-1]) if len(failures) > n_failed else "the model failed"
            y = y if np.isfinite(y).any() else None
        return Ran(x, y, time.monotonic() - begun, why)

    def _is_over(self, x: FloatArray, seconds: float) -> bool:
        """Tell whether a run for `x` that has gone on for so long is to be ended."""
        superseded = self._wanted is not x and seconds > PATIENCE
        return self._worker.mailbox.closed or self._cancelled.is_set() or superseded

    def _failed(self, error: Exception) -> None:
        if self._wanted is not None:
            self._post("ran", Ran(self._wanted, None, 0.0, f"{type(error).__name__}: {error}"))

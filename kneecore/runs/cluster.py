"""Workers beyond one machine: those of a dask.distributed scheduler."""

import socket
import time
from concurrent.futures import Future
from importlib.util import find_spec
from typing import Any

import lazy_loader
import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ModelError, ParameterError
from kneecore.runs.borrowed import run_sent
from kneecore.runs.jobs import Job, sent
from kneecore.runs.part import Part

__all__ = ["Cluster"]

FloatArray = NDArray[np.float64]
CONNECT_S = 10.0
"""How long a scheduler is waited for, and its first worker."""
ALONE_S = 60.0
"""How long a scheduler may be without workers: they may be being replaced."""
_ASK_S = 2.0

distributed: Any = lazy_loader.load("distributed")


class Cluster:
    """The workers of a scheduler; those that come later work along, those that go are replaced.

    Parameters
    ----------
    address : str
        Such as ``tcp://host:8786``.

    Raises
    ------
    ParameterError
        If dask.distributed is not installed.
    ModelError
        If no scheduler answers there, or it has no workers.
    """

    target_s = 2.0
    """A worker takes some milliseconds from one chunk to the next, most of them Dask's."""

    def __init__(self, address: str, timeout_s: float | None, retries: int) -> None:
        if find_spec("distributed") is None:
            raise ParameterError(
                f"`workers` is {address!r}; a scheduler needs dask.distributed: "
                "python -m pip install 'kneecore[cluster]'"
            )
        self.address, self._options = address, (timeout_s, retries)
        self._client = self._connected()
        self._executor = self._client.get_executor(pure=False)
        self.n_workers = 1
        self._asked = self._last_worker = 0.0
        self.check()

    def _connected(self) -> Any:
        try:
            # Somebody must listen there: distributed would try for long, and leave a client behind.
            host, _, port = self.address.partition("://")[2].rpartition(":")
            socket.create_connection((host.strip("[]"), int(port)), CONNECT_S).close()
            client = distributed.Client(self.address, timeout=CONNECT_S, set_as_default=False)
        except Exception as error:  # of several libraries, depending on the protocol
            said = getattr(error, "strerror", None) or f"{type(error).__name__}: {error}"
            said = " ".join(str(said).split())[:200]
            raise ModelError(f"no scheduler answers at {self.address} ({said})") from None
        try:
            client.wait_for_workers(1, timeout=CONNECT_S)
        except Exception:
            client.close()
            raise ModelError(
                f"the scheduler at {self.address} has no workers; start some with "
                f"`dask worker {self.address} --nthreads 1`"
            ) from None
        return client

    def submit(self, job: Job, x: FloatArray, observe: bool) -> "Future[Part]":
        """Give points to the scheduler."""
        future: Future[Part] = self._executor.submit(
            run_sent, sent(job), x, observe, *self._options, job.work.keeps
        )
        return future

    def check(self) -> None:
        """Look at how many workers there are; raise a `ModelError` if nothing more will come."""
        if self._client.status != "running":
            raise self.gone()
        now = time.monotonic()
        if now - self._asked < _ASK_S:
            return
        self._asked = now
        try:
            n_workers = len(self._client.nthreads())
        except Exception:  # of several libraries, when it leaves while it is asked
            raise self.gone() from None
        if n_workers:
            self.n_workers, self._last_worker = n_workers, now
        elif now - self._last_worker > ALONE_S:
            raise ModelError(
                f"the scheduler at {self.address} has been without workers for {ALONE_S:.0f} s"
            )

    def gone(self) -> ModelError:
        """Return the error of a scheduler that has left."""
        return ModelError(f"the scheduler at {self.address} has gone")

    def abandon(self) -> None:
        """Forget what was asked for; what has begun on a worker is not waited for."""

    def close(self) -> None:
        """Leave the scheduler."""
        self._executor.shutdown(wait=False)
        self._client.close(timeout=2)

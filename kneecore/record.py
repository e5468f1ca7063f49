"""What a long computation keeps of itself, so that it can go on after it was stopped.

A computation here is determined by its options: asked again, it asks its model for the same points
in the same order. So going on is doing it again, with the runs that are kept instead of the model
(`run`). Where the runs would be too many, a step's state is kept instead (`load`, `save`).

Who runs a computation sets the record that it shall use; without one nothing is kept.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from hashlib import blake2b
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["Arrays", "KeptStep", "Record", "current_record", "kept_step", "recording"]

Arrays = Mapping[str, NDArray[np.generic]]


class Record(Protocol):
    """Where a computation keeps what it has done."""

    def run(
        self, what: str, identity: bytes, given: Arrays, compute: Callable[[], Arrays]
    ) -> Arrays:
        """Return what `compute` returned earlier for the same model and arrays, or returns now."""
        ...

    def load(self, step: str) -> Arrays | None:
        """Return the state in which a step was left, if it was begun."""
        ...

    def save(self, step: str, state: Callable[[], Arrays], *, now: bool = False) -> None:
        """Keep a step's state, from time to time only unless it must be now."""
        ...


_record: ContextVar[Record | None] = ContextVar("record", default=None)


def current_record() -> Record | None:
    """Return the record that this computation shall use, or None."""
    return _record.get()


@contextmanager
def recording(record: Record | None) -> Iterator[None]:
    """Let what is computed within, on this thread, keep what it does in `record`."""
    token = _record.set(record)
    try:
        yield
    finally:
        _record.reset(token)


@dataclass(frozen=True)
class KeptStep:
    """A longer step of a computation, whose state is kept instead of its single runs."""

    record: Record
    name: str

    def load(self) -> Arrays | None:
        """Return the state in which it was left, if it was begun."""
        return self.record.load(self.name)

    def save(self, state: Callable[[], Arrays], *, now: bool = False) -> None:
        """Keep its state, from time to time only unless it must be now."""
        self.record.save(self.name, state, now=now)


def kept_step(kind: str, identity: bytes, *settings: object) -> KeptStep | None:
    """Return the step of that kind, model and settings in the current record; None without one."""
    record = _record.get()
    if record is None:
        return None
    digest = blake2b(identity + repr(settings).encode(), digest_size=8)
    return KeptStep(record, f"{kind} {digest.hexdigest()}")

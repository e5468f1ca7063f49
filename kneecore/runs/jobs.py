"""A work on its way to another process."""

import os
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256

from kneecore.runs.work import Work, dumped

__all__ = ["Job", "Sent", "sent"]


class Job:
    """A work that is to be sent to others."""

    def __init__(self, work: Work) -> None:
        self.work = work

    @cached_property
    def blob(self) -> bytes:
        """The work as bytes; raises a `ParameterError` if it cannot be sent."""
        return dumped(self.work)

    @cached_property
    def digest(self) -> str:
        """What the bytes are called."""
        return sha256(self.blob).hexdigest()


@dataclass(frozen=True)
class Sent:
    """A work as it came from elsewhere: bytes, and what is to be known of them."""

    blob: bytes
    digest: str
    n_outputs: int
    by_row: bool
    origin: int
    """The process that it comes from."""


def sent(job: Job) -> Sent:
    """Return a job in a form that goes to another process quickly."""
    return Sent(job.blob, job.digest, job.work.n_outputs, job.work.by_row, os.getpid())

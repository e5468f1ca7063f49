"""What is posted to a page's mailbox, where one thread takes it."""

from collections.abc import Callable, Hashable
from typing import Any, NamedTuple

Post = Callable[[Hashable, Any], None]
"""Asks for something by its key; returns at once. See `kneeviz.actions.table` for the keys."""


class Asked(NamedTuple):
    """What a browser asked for."""

    handle: Any
    """The widget."""
    client_id: int
    value: Any
    """What the widget was set to: by now it may have been set to something else."""


def asked_by(value: Any) -> int | None:
    """Return the number of the client whose widget asked, or None."""
    return value.client_id if isinstance(value, Asked) else None

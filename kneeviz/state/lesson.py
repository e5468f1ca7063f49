"""What a visitor had before the lesson, which has a state of its own."""

from dataclasses import dataclass

from kneeviz.state.history import History
from kneeviz.state.snapshot import Snapshot


@dataclass(frozen=True, kw_only=True)
class SetAside:
    """A page as the lesson found it, and gives it back."""

    state: Snapshot
    history: History[Snapshot]
    mode: str
    forces: bool
    playing: bool
    share: float
    """Where the motion was, 0 to 1."""
    landscape: bool
    band: bool
    """Whether the study's band was wanted."""

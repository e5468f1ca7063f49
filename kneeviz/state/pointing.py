"""A pointer over a chart that poses the knee, and where the knee was before."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Pointing:
    """Who points, and between which places of the motion; phases of a `Playback`."""

    client_id: int
    before: float
    """Where the motion goes back to once the pointer has left."""
    shown: float
    """Where the pointer has put it: if it is elsewhere by now, somebody has moved it on."""

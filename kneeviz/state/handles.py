"""What a page knows of its handles: whether they show, which is chosen, who holds which."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore.knee.parameters import widened
from kneeviz.geometry.handles import SLOPE, Box, Handle, Loupe
from kneeviz.state.bounds import SCALE, WIDTH, Bounds, shown_bounds
from kneeviz.state.knee import KneeState

FloatArray = NDArray[np.float64]
Edge = tuple[int, int]
"""Which of a handle's parameters, 0 or 1, and which side of its bound, -1 or 1."""


@dataclass(kw_only=True, eq=False)
class Grab:
    """A drag of a handle, or of an edge of its box."""

    client_id: int
    handle: Handle
    edge: Edge | None
    loupe: Loupe
    """How the hand's place is read: as it was when the drag began, whatever the knee does."""
    taken_at: FloatArray
    """Where the hand took it, shape (2,), m."""
    values: FloatArray
    """Of the handle's parameters when the drag began, SI."""
    knee: FloatArray
    bounds: Bounds
    """All of the knee and the bounds when the drag began."""
    was_playing: bool
    over: bool = False
    """Whether it moves nothing any more, though the hand has not let go."""


class HandlesState:
    """Which handles there are to see and to hold."""

    def __init__(self) -> None:
        self.wanted = True
        """Whether handles show while the motion is paused."""
        self.chosen: Handle | None = None
        """The handle that stands in its loupe."""
        self.opened_at: FloatArray | None = None
        """The chosen handle's values around which the loupe opened, SI."""
        self.grabs: dict[str, Grab] = {}
        """By the handle's name."""

    def choose(self, handle: Handle, values: FloatArray) -> None:
        """Open the loupe of a handle, unless it is open already."""
        if handle is not self.chosen:
            self.chosen, self.opened_at = handle, np.array(values)

    def leave(self) -> None:
        """Close the loupe."""
        self.chosen = self.opened_at = None

    def held_by(self, handle: Handle, client_id: int) -> Grab | None:
        """Return a visitor's drag of a handle, or None if he holds it not."""
        grab = self.grabs.get(handle.name)
        return grab if grab is not None and grab.client_id == client_id else None


def values_of(state: KneeState, handle: Handle) -> FloatArray:
    """Return a handle's parameters of the visitor's knee, SI."""
    values: FloatArray = state.x[handle.indices]
    return values


def box_of(state: KneeState, handle: Handle) -> Box:
    """Return what the bounds allow of a handle's parameters."""
    low, high, home = (
        widened(edge, WIDTH)[handle.indices]
        for edge in (state.space.lower, state.space.upper, state.space.baseline)
    )
    return Box(low=low, high=high, home=home)


def bound_name(handle: Handle) -> str:
    """Return the bound that a handle's box belongs to."""
    return "slope_deg" if handle.name == SLOPE else "geometry_mm"


def bound_now(state: KneeState, name: str) -> float:
    """Return a bound as the page shows it, in its unit."""
    own = getattr(state.bounds, name)
    in_file = dict(zip(("geometry_mm", "slope_deg"), shown_bounds(state.knee), strict=False))
    return float(in_file[name] if own is None else own)


def why_fixed(state: KneeState, handle: Handle) -> str:
    """Return why a handle cannot be moved, in words."""
    if state.bounds.case == "material":
        return "the bounds let only material vary"
    if bound_now(state, bound_name(handle)) == 0.0:
        return "its bound is 0"
    return "the knee file gives it no uncertainty"


def scales(handle: Handle) -> FloatArray:
    """Return the SI values of its parameters' units."""
    found: FloatArray = SCALE[handle.indices]
    return found

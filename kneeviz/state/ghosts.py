"""The visitor's last few knees, kept faint behind his present one. The newest comes first."""

from dataclasses import replace

import numpy as np

from kneeviz.state.knee import Solved

MOST = 3
"""Ghosts at once."""
Ghosts = tuple[Solved, ...]


def with_ghost(ghosts: Ghosts, knee: Solved) -> Ghosts:
    """Return the ghosts with one more in front; the same knee is there once, the oldest goes."""
    others = [ghost for ghost in ghosts if not np.array_equal(ghost.x, knee.x)]
    return (as_ghost(knee), *others)[:MOST]


def as_ghost(knee: Solved) -> Solved:
    """Return a knee that belongs to its baseline and rest lengths, whatever the present knee is."""
    return replace(knee, origin=replace(knee.origin, knee=None))

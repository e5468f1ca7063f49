"""Hoeken's linkage: a four-bar whose coupler point runs along a straight line for half a turn."""

import numpy as np

from kneecore import Shape

CRANK = np.radians(np.arange(100.0, 261.0, 10.0))
"""Turns of the crank at which the point is on the straight part of its path."""


def pins(x, turn):
    """Return crank pin, coupler pin and coupler point, each (n, 2), mm, at n turns of the crank."""
    crank, coupler, rocker, ground, along, across = x
    a = crank * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    to_ground = np.array([ground, 0.0]) - a
    distance = np.hypot(*to_ground.T)
    with np.errstate(invalid="ignore"):  # NaN: the linkage cannot be put together
        inner = np.arccos((coupler**2 + distance**2 - rocker**2) / (2.0 * coupler * distance))
    angle = np.arctan2(to_ground[:, 1], to_ground[:, 0]) + inner
    forward = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    left = np.stack([-forward[:, 1], forward[:, 0]], axis=1)
    return a, a + coupler * forward, a + along * forward + across * left


def height(x):
    """Return the coupler point's height over the ground pivots, mm, on the straight part."""
    return pins(x, CRANK)[2][:, 1]


def draw(x):
    """Return the linkage at half a turn, and the coupler point's whole path."""
    path = pins(x, np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False))[2]
    a, b, point = (p[0] for p in pins(x, np.array([np.pi])))
    pivot = np.array([x[3], 0.0])
    return [
        Shape(name="coupler", points=np.array([point, a, b]), kind="closed", label="coupler point"),
        Shape(name="crank", points=np.array([a, [0.0, 0.0]]), label="crank"),
        Shape(name="rocker", points=np.array([pivot, b]), label="rocker"),
        Shape(name="ground", points=np.array([[0.0, 0.0], pivot]), kind="link"),
        Shape(name="path", points=path, kind="closed"),
    ]

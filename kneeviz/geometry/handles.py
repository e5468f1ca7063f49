"""Handles: which parameters a hand can take, where they stand, and what a hand's place means.

A bound of one millimetre is two pixels wide on a screen. So a handle that has been chosen stands in
a *loupe*: a box that shows the parameter's bound magnified, in which the hand moves `gain` times as
far as the knee does. The loupe opens around the place at which the handle stood.

Places are in the femur frame (x anterior, y up), m; values are SI.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore import LIGAMENTS, NAMES
from kneeviz.geometry.mechanism import Pose, condyle, plateau_frame, rotation, to_femur

FloatArray = NDArray[np.float64]
Three = tuple[float, float, float]

RADIUS, SLOPE = "condyle_radius", "plateau_slope"
_RIM_ANGLE = np.deg2rad(118.0)
"""Where on the circle its radius is taken: above, away from attachments and contact."""
_SLOPE_ARM = 0.036
"""m from the plateau's point to where its slope is taken."""
REACH = 0.020
"""m: at most so far from its middle a loupe's edge stands, unless its bound is larger itself."""
_GAINS = (500, 200, 100, 50, 20, 10, 5, 2, 1)
_STRIP, _THIN_STRIP = 5.0e-3, 0.8e-3
"""m: half the breadth of the box of a single parameter, magnified and not."""
_DETENT = 0.06
"""Share of the half-range within which a handle is drawn home."""
_ALMOST = 1e-9
_FAR = 1e3  # m
DIGITS = 2
"""Of the sliders of what has a handle, in the parameter's unit."""


@dataclass(frozen=True, kw_only=True)
class Handle:
    """One or two parameters that are moved together."""

    name: str
    label: str
    """For people: "ACL femur"."""
    parameters: tuple[str, ...]

    @property
    def indices(self) -> list[int]:
        """Where its parameters are in a knee."""
        return [NAMES.index(name) for name in self.parameters]


def _attachments() -> list[Handle]:
    return [
        Handle(
            name=f"{ligament}_{bone}",
            label=f"{ligament.upper()} {bone}",
            parameters=(f"{ligament}_{bone}_x", f"{ligament}_{bone}_y"),
        )
        for ligament in LIGAMENTS
        for bone in ("femur", "tibia")
    ]


HANDLES = (
    *_attachments(),
    Handle(name="condyle", label="Condyle centre", parameters=("condyle_x", "condyle_y")),
    Handle(name=RADIUS, label="Condyle radius", parameters=(RADIUS,)),
    Handle(name="plateau", label="Plateau point", parameters=("plateau_x", "plateau_y")),
    Handle(name=SLOPE, label="Plateau slope", parameters=(SLOPE,)),
)
BY_NAME = {handle.name: handle for handle in HANDLES}


@dataclass(frozen=True, kw_only=True, eq=False)
class Place:
    """Where a handle's present value is on screen, and where it goes when the value changes."""

    point: FloatArray
    """Shape (2,), m."""
    directions: FloatArray
    """Shape (2, k): how far and where to the point goes for each unit of its k parameters."""


def place(handle: Handle, x: FloatArray, pose: Pose) -> Place:
    """Return where a handle is on the knee `x` in `pose`."""
    turn, plain = rotation(pose.flexion), np.eye(2)
    if handle.name == RADIUS:
        centre, radius = condyle(x)
        outwards = np.array([np.cos(_RIM_ANGLE), np.sin(_RIM_ANGLE)])
        return Place(point=centre + radius * outwards, directions=outwards[:, None])
    if handle.name == SLOPE:
        point, along, normal = plateau_frame(x)
        end = (point + _SLOPE_ARM * along)[None]
        at = to_femur(end, pose.flexion, pose.tibia_position)[0]
        return Place(point=at, directions=(_SLOPE_ARM * turn @ normal)[:, None])
    own = np.asarray(x)[handle.indices]
    if handle.name == "plateau" or handle.name.endswith("_tibia"):
        at = to_femur(own[None], pose.flexion, pose.tibia_position)[0]
        return Place(point=at, directions=turn)
    return Place(point=np.array(own), directions=plain)


@dataclass(frozen=True, kw_only=True, eq=False)
class Box:
    """What the bounds allow of a handle's parameters, SI, shape (k,) each."""

    low: FloatArray
    high: FloatArray
    home: FloatArray
    """The baseline's values."""

    @property
    def is_fixed(self) -> bool:
        """Whether none of them may vary."""
        return not (self.high > self.low).any()


@dataclass(frozen=True, kw_only=True, eq=False)
class Loupe:
    """A magnified view of a handle's values, around one of them."""

    anchor: FloatArray
    """Where `value` stands, shape (2,), m."""
    value: FloatArray
    """Shape (k,), SI."""
    directions: FloatArray
    """As a `Place`'s, without the magnification."""
    gain: float

    def at(self, value: FloatArray) -> FloatArray:
        """Return where a value stands, shape (2,), m."""
        shown: FloatArray = self.anchor + self.gain * self.directions @ (value - self.value)
        return shown

    def value_at(self, point: FloatArray) -> FloatArray:
        """Return the value that stands at a point: `at` turned round."""
        length = (self.directions**2).sum(axis=0)
        moved = self.directions.T @ (point - self.anchor) / (self.gain * length)
        value: FloatArray = self.value + moved
        return value


def gain_for(box: Box, directions: FloatArray) -> float:
    """Return the magnification, of a round series, that makes a box easy to hit."""
    half = 0.5 * (box.high - box.low) * np.sqrt((directions**2).sum(axis=0))
    largest = float(half.max())
    fitting = (gain for gain in _GAINS if gain * largest <= REACH * (1.0 + _ALMOST))
    return 1.0 if largest <= 0.0 else float(next(fitting, 1))


def loupe_around(place_now: Place, value_now: FloatArray, value: FloatArray, gain: float) -> Loupe:
    """Return the loupe that opens around `value` on a knee whose handle now has `value_now`."""
    anchor = place_now.point + place_now.directions @ (value - value_now)
    return Loupe(anchor=anchor, value=value, directions=place_now.directions, gain=gain)


def corners(loupe: Loupe, box: Box) -> FloatArray:
    """Return a box's four corners in a loupe, in turn, shape (4, 2), m.

    A single parameter's box is a strip across the way that it goes.
    """
    if len(box.low) == 2:
        ends = (box.low, box.high)
        pairs = ((0, 0), (1, 0), (1, 1), (0, 1))
        return np.array([loupe.at(np.array([ends[i][0], ends[j][1]])) for i, j in pairs])
    along = loupe.directions[:, 0] / np.linalg.norm(loupe.directions[:, 0])
    half = _THIN_STRIP if loupe.gain == 1.0 else _STRIP
    aside = half * np.array([-along[1], along[0]])
    low, high = loupe.at(box.low), loupe.at(box.high)
    return np.array([low - aside, high - aside, high + aside, low + aside])


@dataclass(frozen=True, kw_only=True, eq=False)
class Settled:
    """A value that the bounds allow, and what drew it there; shape (k,) each."""

    value: FloatArray
    at_home: NDArray[np.bool_]
    at_edge: NDArray[np.bool_]


def settle(value: FloatArray, box: Box, scale: FloatArray) -> Settled:
    """Return the value that a hand at `value` means: softly home, firmly within the box.

    Each parameter by itself: near home it rests there, from there it is caught up with smoothly, at
    the box's edge it stays. In between it has the digits that a slider has, in units of `scale`.
    """
    away = value - box.home
    detent = _DETENT * 0.5 * (box.high - box.low)
    beyond = np.abs(away) - detent
    eased = np.sign(away) * np.minimum(np.abs(away), 2.0 * np.maximum(beyond, 0.0))
    rounded = np.round((box.home + eased) / scale, DIGITS) * scale
    kept = np.clip(rounded, box.low, box.high)
    at_home = (beyond <= 0.0) & (box.low <= box.home) & (box.home <= box.high)
    kept = np.where(at_home, box.home, kept)
    at_edge = ~at_home & ((kept <= box.low) | (kept >= box.high))
    return Settled(value=kept, at_home=at_home, at_edge=at_edge)


def half_range_at(point: FloatArray, loupe: Loupe, box: Box, edge: tuple[int, int]) -> float:
    """Return the half-range, SI, whose edge stands at a point.

    `edge` is the parameter's number, 0 or 1, and the side, -1 or 1.
    """
    axis, side = edge
    return float(side * (loupe.value_at(point)[axis] - box.home[axis]))


def on_plane(eye: Three, point: Three, depth: float) -> FloatArray | None:
    """Return where the line from `eye` through `point` meets the plane z = `depth`, shape (2,), m.

    None if it does not meet it in front of the eye, or a number is not finite or absurd.
    """
    start, through = np.array(eye), np.array(point)
    with np.errstate(all="ignore"):
        way = through - start
        share = (depth - start[2]) / way[2]
        met: FloatArray = (start + share * way)[:2]
    if not (np.abs(met).max() < _FAR and share > 0.0):
        return None
    return met

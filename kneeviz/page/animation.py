"""What changes over a moment instead of at once. Pure timing: no widget, no model.

Times are s of `time.monotonic`; shares go from 0 to 1.
"""

from dataclasses import dataclass

from numpy import float64
from numpy.typing import NDArray

FloatArray = NDArray[float64]

_MORPH_SECONDS = 0.35
_FADE_SECONDS = 0.6
_GLIDE_SECONDS = 1.2


def smooth(part: float) -> float:
    """Return how far something is that starts and ends gently, after a share of its time."""
    return part * part * (3.0 - 2.0 * part)


@dataclass(frozen=True)
class _Morph:
    start: FloatArray
    began: float


@dataclass(frozen=True)
class _Glide:
    start: float
    end: float
    began: float


class Animation:
    """A knee that turns into another, worst cases that fade in, a motion that glides to a place."""

    def __init__(self) -> None:
        self._morph: _Morph | None = None
        self._fade_began: float | None = None
        self._glide: _Glide | None = None

    @property
    def running(self) -> bool:
        """Whether anything is on its way."""
        return self.morphing or self.fading or self.gliding

    @property
    def morphing(self) -> bool:
        """Whether the knee on screen turns into another."""
        return self._morph is not None

    @property
    def fading(self) -> bool:
        """Whether the worst cases fade in."""
        return self._fade_began is not None

    @property
    def gliding(self) -> bool:
        """Whether the motion glides to a place."""
        return self._glide is not None

    def start_morph(self, shown: FloatArray, now: float) -> None:
        """Let the knee go from `shown` to what it shall be."""
        self._morph = _Morph(shown, now)

    def stop_morph(self) -> None:
        """Let the knee be what it shall be at once."""
        self._morph = None

    def morph(self, target: FloatArray, now: float) -> tuple[FloatArray, bool] | None:
        """Return the knee on its way to `target` and whether it is there; None if at rest."""
        if self._morph is None:
            return None
        start, part = self._morph.start, min((now - self._morph.began) / _MORPH_SECONDS, 1.0)
        if part >= 1.0:
            self._morph = None
        return start + smooth(part) * (target - start), part >= 1.0

    def start_fade(self, now: float) -> None:
        """Let the worst cases fade in."""
        self._fade_began = now

    def fade(self, now: float) -> float | None:
        """Return how far the worst cases have faded in, or None if nothing fades."""
        if self._fade_began is None:
            return None
        part = min((now - self._fade_began) / _FADE_SECONDS, 1.0)
        if part >= 1.0:
            self._fade_began = None
        return part

    def start_glide(self, start: float, end: float, now: float) -> None:
        """Let the motion go from one share of its way to another."""
        self._glide = _Glide(start, end, now)

    def stop_glide(self) -> None:
        """Leave the motion where it is."""
        self._glide = None

    def glide(self, now: float) -> float | None:
        """Return the share of the way that the motion has glided to, or None if it does not."""
        if self._glide is None:
            return None
        way, part = self._glide, min((now - self._glide.began) / _GLIDE_SECONDS, 1.0)
        if part >= 1.0:
            self._glide = None
        return way.start + (way.end - way.start) * smooth(part)

"""Whether the page follows its bounds and sliders with the worst case, and what it asked last."""

import time
from typing import Any

from kneecore import MonteCarloResult
from kneeviz.state.shown import Band, band_of

SLOW_SECONDS = 0.3
"""After this long without an answer the page says that it is still looking."""


class LiveState:
    """Whether a page follows, and what it has asked for last."""

    def __init__(self) -> None:
        self.on = False
        self.slow = False
        """Whether the page says that the answer takes long."""
        self.improving = False
        """Whether the answer on the page is the best until now of a search that goes on."""
        self.shown = False
        """Whether an answer is on the page."""
        self.slow_at: float | None = None
        """When to say that the answer takes long, s of `time.monotonic`; None if it is there."""
        self._asked: tuple[Any, ...] | None = None

    @property
    def keeps_up(self) -> bool:
        """Whether what the page shows is, but for a moment, that of the present bounds."""
        return self.on and self.shown and not self.slow

    def is_new(self, wanted: tuple[Any, ...]) -> bool:
        """Tell whether `wanted` has not been asked for yet, and remember it."""
        if wanted == self._asked:
            return False
        self._asked = wanted
        return True

    def wait(self) -> None:
        """Note that an answer is on its way."""
        if self.slow_at is None and not self.slow:
            self.slow_at = time.monotonic() + SLOW_SECONDS

    def arrived(self) -> None:
        """Note that it is there."""
        self.slow, self.slow_at = False, None
        self.improving = False


def live_band(sampled: MonteCarloResult) -> Band:
    """Return the band of the knees at rest that were sampled around the visitor's."""
    left_out = f", {sampled.n_failed} without an equilibrium left out" if sampled.n_failed else ""
    return band_of(sampled, f"{sampled.n_samples:,} knees at rest around yours{left_out}")

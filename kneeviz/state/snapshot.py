"""Everything that a visitor may change and want back: one moment of a page, never altered."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore import KneeFile, SearchResult
from kneeviz.state.bounds import Bounds
from kneeviz.state.ghosts import Ghosts

FloatArray = NDArray[np.float64]

Settings = tuple[tuple[str, Any], ...]
"""The values of a page's settings by name, in the order of its widgets."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Snapshot:
    """Knee, bounds, settings and result of a page at one moment."""

    knee: KneeFile
    """The baseline."""
    bounds: Bounds
    x: FloatArray
    """The visitor's knee, SI, shape (32,); nobody can write to it."""
    result: SearchResult | None = None
    """The last search's result; None while the page follows live, which finds its own."""
    overlay: bool = False
    """Whether both worst cases are shown."""
    live: bool = False
    """Whether the page follows its bounds and sliders with the worst case."""
    settings: Settings = ()
    ghosts: Ghosts = ()
    """The earlier knees that were kept then. They follow from the steps and are none themselves;
    a file of the state has none."""

    def __post_init__(self) -> None:
        kept = np.array(self.x, dtype=np.float64)
        kept.setflags(write=False)
        object.__setattr__(self, "x", kept)

    def same_as(self, other: "Snapshot") -> bool:
        """Tell whether both are the same, to the bit."""
        return (
            self.knee is other.knee
            and self.bounds == other.bounds
            and self.x.tobytes() == other.x.tobytes()
            and self.result is other.result
            and (self.overlay, self.live) == (other.overlay, other.live)
            and self.settings == other.settings
        )

    def changes_from(self, other: "Snapshot") -> tuple[str, ...]:
        """Return what differs from `other`, in words."""
        differs = {
            "baseline": self.knee is not other.knee,
            "bounds": self.bounds != other.bounds,
            "knee": self.x.tobytes() != other.x.tobytes(),
            "settings": self.settings != other.settings,
            "live": self.live != other.live,
            "result": self.result is not other.result,
            "both knees shown": self.overlay != other.overlay and self.result is other.result,
        }
        return tuple(words for words, yes in differs.items() if yes)

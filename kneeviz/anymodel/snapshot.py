"""Everything that a visitor of a model's page may change and want back: one moment of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore import SearchResult
from kneeviz.state.snapshot import Settings

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelSnapshot:
    """Inputs, settings, result and what is shown of them, at one moment; never altered."""

    x: FloatArray
    """The sliders' point, shape (d,); nobody can write to it."""
    result: SearchResult | None = None
    overlay: bool = False
    """Whether both worst models are shown."""
    band: bool = True
    """Whether what was sampled is drawn behind the curves."""
    column: int = 0
    """The output that influence and landscape show."""
    settings: Settings = ()

    def __post_init__(self) -> None:
        kept = np.array(self.x, dtype=np.float64)
        kept.setflags(write=False)
        object.__setattr__(self, "x", kept)

    def same_as(self, other: "ModelSnapshot") -> bool:
        """Tell whether both are the same, to the bit."""
        return not self.changes_from(other)

    def changes_from(self, other: "ModelSnapshot") -> tuple[str, ...]:
        """Return what differs from `other`, in words."""
        differs = {
            "inputs": self.x.tobytes() != other.x.tobytes(),
            "settings": self.settings != other.settings,
            "result": self.result is not other.result,
            "both models shown": self.overlay != other.overlay and self.result is other.result,
            "band shown": self.band != other.band,
            "output": self.column != other.column,
        }
        return tuple(words for words, yes in differs.items() if yes)

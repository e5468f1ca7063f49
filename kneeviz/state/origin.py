"""What something on the page was computed for, as digests that can be compared."""

import hashlib
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any

import numpy as np

from kneecore import ParameterSpace
from kneecore.knee.parameters import widened
from kneeviz.state import results
from kneeviz.state.bounds import WIDTH

_BYTES = 12


@dataclass(frozen=True, kw_only=True)
class Origin:
    """A digest of each part of the state that mattered; None for a part that did not."""

    baseline: str | None = None
    bounds: str | None = None
    rest_lengths: str | None = None
    """What knees do with their rest lengths."""
    knee: str | None = None
    """The visitor's values."""
    axes: str | None = None
    """The two parameters of a landscape."""

    def changed(self, now: "Origin") -> tuple[str, ...]:
        """Return the parts that mattered and are others now."""
        names = (field.name for field in fields(self))
        return tuple(
            name
            for name in names
            if getattr(self, name) is not None and getattr(self, name) != getattr(now, name)
        )

    def same_box(self, other: "Origin") -> bool:
        """Tell whether both are of knees within the same bounds."""
        mine, others = ((one.baseline, one.bounds, one.rest_lengths) for one in (self, other))
        return mine == others


def digest(*parts: Any) -> str:
    """Return the digest of arrays, to the bit, and of texts."""
    kept = hashlib.blake2b(digest_size=_BYTES)
    for part in parts:
        content = part.encode() if isinstance(part, str) else np.ascontiguousarray(part).tobytes()
        kept.update(len(content).to_bytes(8, "little"))
        kept.update(content)
    return kept.hexdigest()


@lru_cache(maxsize=64)
def of_space(space: ParameterSpace, rest_length: str) -> Origin:
    """Return the origin of what was computed for all knees within bounds.

    Bounds around another knee than the baseline are that knee's, too.
    """
    around = space.is_around_baseline
    return Origin(
        baseline=digest(space.baseline),
        bounds=digest(space.lower, space.upper),
        rest_lengths=rest_length,
        knee=None if around else digest(widened(space.centre, WIDTH)),
    )


def of_found(found: Any) -> Origin:
    """Return the origin of one of kneecore's results."""
    return of_space(results.space(found), results.rest_length(found))

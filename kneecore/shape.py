"""What a model's picture is made of."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from kneecore._arguments import choice, text
from kneecore._arrays import numbers
from kneecore.errors import ParameterError

__all__ = ["Kind", "Shape"]

Kind = Literal["line", "closed", "link"]
_LONGEST = 200


@dataclass(frozen=True, kw_only=True, eq=False)
class Shape:
    """One part of a model's picture.

    Raises
    ------
    ParameterError
        If the points are not n places in a plane, or another value is not allowed.
    """

    name: str
    points: NDArray[np.float64]
    """Shape (n, 2), in `Model.picture_unit`."""
    kind: Kind = "line"
    """`line`, `closed` (the last point is joined to the first) or `link` (dashed, ends shown)."""
    label: str = ""

    def __post_init__(self) -> None:
        text("name", self.name, _LONGEST)
        text("label", self.label, _LONGEST)
        choice("kind", self.kind, get_args(Kind))
        points = numbers("points", self.points)
        if points.ndim != 2 or points.shape[1] != 2 or len(points) == 0:
            raise ParameterError(f"`points` has shape {points.shape}; (n, 2) is allowed")
        object.__setattr__(self, "points", points)

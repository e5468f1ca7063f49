"""What must agree in what a file tells of a knee: its status, and all that its poses imply.

The angles themselves only a simulation could tell again, which a reader does not run: nothing is
compiled and nothing searched to open a file. But the forces belong to the poses, and the poses'
rest lengths to the knee, so that no single number can be changed.
"""

import math

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import FileFormatError
from kneecore.files.consistent import check_equal, check_holds
from kneecore.knee.model import Knee
from kneecore.knee.physics.marks import LEAST_FLEXION, MOST_FLEXION, MOST_INDENTATION
from kneecore.knee.response import Response
from kneecore.knee.statics import load_free, observed
from kneecore.numbers import DIGITS
from kneecore.search.result import SearchResult

__all__ = ["check_responses", "check_status"]

FloatArray = NDArray[np.float64]

_FIELDS = ("flexion", "tension", "contact_force", "indentation", "ap_position", "tibia_position")
_MILLIMETRE = 1e-3
_RADIUS = 18
_IMPLIED = 1e-6
"""Share by which a force may differ from what the pose's rounded numbers give."""
_NEAR = 1e-9
"""rad: an angle so near to a limit may be on its other side by rounding."""


def check_status(response: Response, name: str = "") -> None:
    """Raise a `FileFormatError` if a knee's numbers do not fit its status."""
    place = f".{name}" if name else ""
    known = response.refinements >= 0
    for field in _FIELDS:
        values = np.isfinite(getattr(response, field))
        if known and math.isnan(response.lost_at) and not values.all():
            raise FileFormatError(
                f"`{field}{place}` lacks numbers, and `status{place}` is {response.status!r}"
            )
        if not known and values.any():
            raise FileFormatError(f"`{field}{place}` has numbers, and `status{place}` is 'failed'")


def check_responses(result: SearchResult) -> None:
    """Raise a `FileFormatError` if a response of a search is not one of its knee."""
    knee = result.model
    if not isinstance(knee, Knee):
        return
    for (name, response), x in zip(
        result.responses.items(), (knee.nominal, *result.x), strict=True
    ):
        check_status(response, name)
        _check_load_free(knee, response, x, name)
        _check_poses(response, x, name)


def _check_load_free(knee: Knee, response: Response, x: FloatArray, name: str) -> None:
    free = load_free(x, knee.space.baseline, fixed=knee.rest_length == "fixed")
    for key, said, follows in (
        ("ligament_rest_length_mm", response.rest_length, free.rest_length),
        ("load_free_position_mm", response.load_free_position, free.position),
    ):
        check_equal(f"{key}.{name}", said / _MILLIMETRE, follows / _MILLIMETRE, digits=DIGITS)


def _check_poses(response: Response, x: FloatArray, name: str) -> None:
    known = np.isfinite(response.flexion)
    if not known.any():
        return
    flexion = response.flexion[known]
    seen = observed(x, response.rest_length, flexion, response.tibia_position[known])
    for key, field, factor in (
        ("tension_n", "tension", 1.0),
        ("contact_force_n", "contact_force", 1.0),
        ("indentation_mm", "indentation", _MILLIMETRE),
        ("ap_position_mm", "ap_position", _MILLIMETRE),
    ):
        check_equal(
            f"{key}.{name}",
            getattr(response, field)[known] / factor,
            getattr(seen, field) / factor,
            size=1.0,
            rounding=_IMPLIED,
        )
    if response.implausible is not None:
        depth = seen.indentation - MOST_INDENTATION * x[_RADIUS]
        beyond = np.maximum(np.maximum(LEAST_FLEXION - flexion, flexion - MOST_FLEXION), depth)
        clear = np.abs(beyond) > _NEAR
        fits = (response.implausible[known] == (beyond > 0.0)) | ~clear
        check_holds(f"implausible.{name}", fits, "it follows from the angles and indentations")

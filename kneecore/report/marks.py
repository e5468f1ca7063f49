"""The marks behind an angle, what they mean, and how runs are counted by them."""

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from kneecore.knee.response import Response

__all__ = ["MEANINGS", "counted", "counted_by_row", "legend", "mark"]

MEANINGS = {
    "*": "not settled: it turned by 0.2 deg or more in the load's last 0.5 s",
    "~": "not at rest: not within 0.1 deg of the same knee's equilibrium",
    "!": "implausible: beyond -60 to 170 deg, or indented by over half the radius",
}
_COUNTED = {
    "refined": "refined",
    "unsettled": "with an unsettled load",
    "not_at_rest": "not within 0.1 deg of their equilibrium",
    "implausible": "implausible",
    "partial": "with some of their outputs only",
    "retried": "tried again",
    "reused": "reused from the runs that were kept",
}


def mark(response: Response, k: int) -> str:
    """Return the signs behind a knee's angle at load `k`; none behind a failed model's."""
    if not np.isfinite(response.flexion[k]):
        return ""
    settled, rests, odd = response.settled, response.at_rest, response.implausible
    signs = "" if settled[k] else "*"
    signs += "" if rests is None or rests[k] else "~"
    return signs + ("!" if odd is not None and odd[k] else "")


def legend(responses: Iterable[Response]) -> list[str]:
    """Return a line for each sign that stands behind an angle of these knees."""
    used = {sign for r in responses for k in range(len(r.flexion)) for sign in mark(r, k)}
    return [f"{sign} {meaning}" for sign, meaning in MEANINGS.items() if sign in used]


def counted(counts: Mapping[str, int], prefix: str = "") -> list[str]:
    """Return how many models were of each kind, for those kinds that were counted."""
    return [
        f"{counts[prefix + kind]} {words}"
        for kind, words in _COUNTED.items()
        if prefix + kind in counts
    ]


def counted_by_row(marks: Mapping[str, NDArray[np.int64]], what: str) -> str:
    """Return how many of `what` bear each mark in each of a table's rows; nothing without marks."""
    told = [
        f"{', '.join(map(str, counts))} {_COUNTED[kind]}"
        for kind, counts in marks.items()
        if kind in _COUNTED
    ]
    return f"Of {what}, row by row: {'; '.join(told)}. " if told else ""

"""One knee's response as JSON and back; the schema is ``assets/response.schema.json``."""

import math
from collections.abc import Iterator
from typing import Any

from kneecore.errors import FileFormatError
from kneecore.files.model import array, number_or_none
from kneecore.knee.response import MOMENT, Response, status_text
from kneecore.numbers import plain
from kneecore.presented import Format

__all__ = ["FORMAT", "MARKS", "read_response", "response_table", "to_dict"]

SCHEMA = "kneecore.response/1"
_N_LOADS = len(MOMENT)
_DEGREES = 180.0 / math.pi

# Fields of a response in display units: (key, field, factor from SI, shape).
_FIELDS = (
    ("flexion_deg", "flexion", _DEGREES, (_N_LOADS,)),
    ("tension_n", "tension", 1.0, (_N_LOADS, 4)),
    ("contact_force_n", "contact_force", 1.0, (_N_LOADS,)),
    ("indentation_mm", "indentation", 1e3, (_N_LOADS,)),
    ("ap_position_mm", "ap_position", 1e3, (_N_LOADS,)),
    ("tibia_position_mm", "tibia_position", 1e3, (_N_LOADS, 2)),
    ("ligament_rest_length_mm", "rest_length", 1e3, (4,)),
    ("load_free_position_mm", "load_free_position", 1e3, (2,)),
)
_AUDIT = "half_step_change_deg"
MARKS = ("at_rest", "implausible")


def _told(response: Response, mark: str) -> bool:
    return getattr(response, mark) is not None


def response_table(response: Response) -> dict[str, Any]:
    """Return a response as JSON-ready values, without a schema."""
    table: dict[str, Any] = {
        "settled": response.settled.tolist(),
        **{key: getattr(response, key).tolist() for key in MARKS if _told(response, key)},
        "status": response.status,
        "refinements": response.refinements,
        "lost_at_nm": plain(response.lost_at),
    }
    if response.half_step_change is not None:
        table[_AUDIT] = plain(response.half_step_change, _DEGREES)
    for key, field, factor, _ in _FIELDS:
        table[key] = plain(getattr(response, field), factor)
    return table


def read_response(table: dict[str, Any]) -> Response:
    """Return the response that `response_table` has told."""
    refinements = int(table["refinements"])
    if table["status"] != status_text(refinements):
        raise FileFormatError("`status` does not fit `refinements`")
    # Results that were written before there were equilibria have none.
    lost_at = number_or_none(table, "lost_at_nm") if "lost_at_nm" in table else None
    # Results that were written before there were these marks have none.
    marks = {k: array(table[k], (_N_LOADS,), k).astype(bool) for k in MARKS if k in table}
    return Response(
        moment=MOMENT,
        settled=array(table["settled"], (_N_LOADS,), "settled").astype(bool),
        at_rest=marks.get("at_rest"),
        implausible=marks.get("implausible"),
        half_step_change=array(table[_AUDIT], (_N_LOADS,), _AUDIT) / _DEGREES
        if _AUDIT in table
        else None,
        refinements=refinements,
        lost_at=math.nan if lost_at is None else lost_at,
        **{field: array(table[key], shape, key) / factor for key, field, factor, shape in _FIELDS},
    )


def to_dict(
    response: Response, at_rest: Response | None = None, title: str | None = None
) -> dict[str, Any]:
    """Return a response as a document, with the angles `at_rest` if they are given."""
    return {
        "schema": SCHEMA,
        "title": title,
        "moment_nm": response.moment.tolist(),
        **response_table(response),
        "flexion_at_rest_deg": at_rest and plain(at_rest.flexion, _DEGREES),
    }


def _others(_response: Response, _figures: bool) -> Iterator[tuple[str, bytes]]:
    return iter(())


FORMAT = Format(
    schema=SCHEMA,
    file="response.json",
    to_dict=to_dict,
    from_dict=read_response,
    others=_others,
)

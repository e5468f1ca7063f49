"""A page's state as a file, from which a server that starts again goes on."""

from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, get_args

from kneecore import (
    FileFormatError,
    KneeFile,
    dump_knee,
    packaged_knee,
    parse_knee,
)
from kneecore.files.folder import to_json
from kneecore.files.model import array
from kneecore.knee.parameters import check_physical
from kneecore.knee.response import RestLength
from kneeviz.state import results
from kneeviz.state.bounds import WIDTH, Bounds
from kneeviz.state.document import (
    check_keys,
    flag,
    read_result,
    read_settings,
    read_state,
    told,
)
from kneeviz.state.snapshot import FloatArray, Snapshot

SCHEMA = "kneeviz.state/1"
_REST_LENGTHS = get_args(RestLength)
_KEYS = {"schema", "baseline", "bounds", "knee", "settings", "overlay", "live", "result"}


def to_document(state: Snapshot) -> dict[str, Any]:
    """Return a state as JSON-ready values."""
    return {
        "schema": SCHEMA,
        "baseline": _knee_text(state.knee),
        "bounds": asdict(state.bounds),
        "knee": state.x.tolist(),
        "settings": dict(state.settings),
        "overlay": state.overlay,
        "live": state.live,
        "result": None if state.result is None else told(state.result),
    }


def to_text(state: Snapshot) -> str:
    """Return a state as JSON: the same state, the same text."""
    return to_json(to_document(state))


def _knee_text(knee: KneeFile) -> str:
    return dump_knee(
        baseline=knee.baseline,
        half_ranges=knee.half_ranges,
        sources=knee.sources,
        current=knee.current,
        title=knee.title,
        note=knee.note,
    )


def read(path: str | Path) -> Snapshot:
    """Return the state in the file at `path`.

    Raises
    ------
    FileFormatError
        If it cannot be read, is of another version or disagrees with itself; the message names
        the file.
    """
    return read_state(path, from_document)


def from_document(document: dict[str, Any]) -> Snapshot:
    """Return the state that `to_document` has told.

    Raises
    ------
    KneecoreError
        If it is of another version or disagrees with itself.
    """
    check_keys(document, SCHEMA, _KEYS)
    knee = knee_of(document["baseline"])
    bounds = _bounds(document["bounds"])
    bounds.space(knee)  # raises where no knee fits them
    return Snapshot(
        knee=knee,
        bounds=bounds,
        x=_values(document["knee"]),
        result=read_result(document["result"], results.of_knees),
        overlay=flag(document, "overlay"),
        live=flag(document, "live"),
        settings=read_settings(document["settings"]),
    )


def knee_of(text: Any) -> KneeFile:
    """Return the baseline of a state from the text that tells it."""
    packaged = packaged_knee()  # known by being itself
    if text == _knee_text(packaged):
        return packaged
    if not isinstance(text, str):
        raise FileFormatError("`baseline` is no text; a knee file's text is allowed")
    return parse_knee(text)


def _bounds(table: Any) -> Bounds:
    names = [field.name for field in fields(Bounds)]
    if not isinstance(table, dict) or set(table) != set(names):
        raise FileFormatError(f"`bounds` must name {', '.join(names)}")
    if table["rest_length"] not in _REST_LENGTHS:
        raise FileFormatError(
            f"`bounds.rest_length` is {str(table['rest_length'])[:40]!r}; "
            f"{' or '.join(_REST_LENGTHS)} is allowed"
        )
    return Bounds(**table)


def _values(value: Any) -> FloatArray:
    if not isinstance(value, list) or any(type(v) not in (int, float) for v in value):
        raise FileFormatError(f"`knee` must hold {WIDTH} numbers")
    return check_physical(array(value, (WIDTH,), "knee"), "knee")

"""A page's state as a file, from which a server that starts again goes on."""

import json
from dataclasses import asdict, fields
from functools import lru_cache
from pathlib import Path
from typing import Any, get_args

from kneecore import (
    FileFormatError,
    KneecoreError,
    KneeFile,
    SearchResult,
    dump_knee,
    packaged_knee,
    parse_knee,
)
from kneecore.files.digest import DIGEST
from kneecore.files.folder import to_json
from kneecore.files.load import read_object
from kneecore.files.model import array
from kneecore.knee.parameters import check_physical
from kneecore.knee.response import RestLength
from kneeviz.state import results
from kneeviz.state.bounds import WIDTH, Bounds
from kneeviz.state.snapshot import FloatArray, Settings, Snapshot

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
        "result": None if state.result is None else _told(state.result),
    }


def to_text(state: Snapshot) -> str:
    """Return a state as JSON: the same state, the same text."""
    return to_json(to_document(state))


@lru_cache(maxsize=2)
def _told(result: SearchResult) -> dict[str, Any]:
    """Return a result as JSON-ready values; a page tells the same one many times."""
    return result.to_dict()


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
    document = read_object(path)
    try:
        return from_document(document)
    except KneecoreError as error:
        raise FileFormatError(f"{path}: {error}") from None


def from_document(document: dict[str, Any]) -> Snapshot:
    """Return the state that `to_document` has told.

    Raises
    ------
    KneecoreError
        If it is of another version or disagrees with itself.
    """
    if document.get("schema") != SCHEMA:
        raise FileFormatError(
            f"`schema` is {str(document.get('schema'))[:40]!r}; {SCHEMA!r} is allowed"
        )
    wrong = sorted(_KEYS ^ (set(document) - {DIGEST}))
    if wrong:
        raise FileFormatError(f"the key {wrong[0][:40]!r} is missing or unknown")
    knee = knee_of(document["baseline"])
    bounds = _bounds(document["bounds"])
    bounds.space(knee)  # raises where no knee fits them
    return Snapshot(
        knee=knee,
        bounds=bounds,
        x=_values(document["knee"]),
        result=_result(document["result"]),
        overlay=_flag(document, "overlay"),
        live=_flag(document, "live"),
        settings=_settings(document["settings"]),
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


def _result(table: Any) -> SearchResult | None:
    if table is None:
        return None
    try:
        return results.of_knees(SearchResult.from_json(json.dumps(table)))
    except KneecoreError as error:
        raise FileFormatError(f"`result`: {error}") from None


def _flag(document: dict[str, Any], key: str) -> bool:
    if not isinstance(document[key], bool):
        raise FileFormatError(f"`{key}` is {str(document[key])[:40]!r}; true or false is allowed")
    return bool(document[key])


def _settings(table: Any) -> Settings:
    if not isinstance(table, dict):
        raise FileFormatError("`settings` is no table")
    return tuple(table.items())

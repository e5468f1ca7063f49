"""A state without results as a short text, which a link carries: ``?knee=...``.

Only what differs from the baseline and from a new page is in it, exact to the bit: JSON, packed by
zlib and written in the 64 characters that an address takes as they are.
"""

import base64
import json
import re
import zlib
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from kneecore import FileFormatError, KneeFile, packaged_knee, parameter_table
from kneecore.files.load import parse_object
from kneecore.knee.parameters import widened
from kneeviz.state import saved
from kneeviz.state.bounds import WIDTH, Bounds
from kneeviz.state.snapshot import Settings, Snapshot

SCHEMA = "kneeviz.link/1"
MOST_CHARACTERS = 6000
"""Of a link; a server takes addresses of 8 kB."""
MOST_UNPACKED = 64 * 1024
"""Bytes that it may hold; a knee file with all its sources has some ten thousand."""
_CODE = re.compile(r"[A-Za-z0-9_-]+")
_NAMES = tuple(row.name for row in parameter_table(rest_lengths=True))
_PARTS = ("bounds", "knee", "settings")
_KEYS = {"schema", "baseline", *_PARTS}


class Offered(NamedTuple):
    """What a visitor may open for all."""

    state: Snapshot
    question: Any
    """The widget that asks him."""


@dataclass
class LinksState:
    """The links of a page."""

    made: Snapshot | None = None
    """What the link on the page opens."""
    offered: dict[int, Offered] = field(default_factory=dict)
    """By the visitor's number."""


def to_code(state: Snapshot, first: Settings) -> str:
    """Return the knee, bounds and settings of a state; the same state, the same text.

    Parameters
    ----------
    state : Snapshot
    first : Settings
        The settings of a new page.

    Raises
    ------
    FileFormatError
        If they are too much for a link.
    """
    told, new = _told(state), _told(_new_page(state.knee, first))
    content: dict[str, Any] = {"schema": SCHEMA}
    if state.knee is not packaged_knee():
        content["baseline"] = told["baseline"]
    for part in _PARTS:
        # As they are written: minus zero is another number than zero, to the bit.
        differs = {k: v for k, v in told[part].items() if repr(v) != repr(new[part][k])}
        if differs:
            content[part] = differs
    text = json.dumps(content, allow_nan=False, sort_keys=True, separators=(",", ":"))
    code = base64.urlsafe_b64encode(zlib.compress(text.encode(), 9)).decode().rstrip("=")
    if len(code) > MOST_CHARACTERS:
        raise FileFormatError(
            f"a link would have {len(code):,} characters; at most {MOST_CHARACTERS:,} are allowed; "
            "the file knee.toml holds any knee"
        )
    return code


def _new_page(knee: KneeFile, first: Settings) -> Snapshot:
    x = widened(knee.baseline, WIDTH)
    return Snapshot(knee=knee, bounds=Bounds(), x=x, settings=first)


def _told(state: Snapshot) -> dict[str, Any]:
    """Return a state without results as a state's file tells it, its knee by parameter."""
    told = saved.to_document(replace(state, result=None, overlay=False, live=False))
    return told | {"knee": dict(zip(_NAMES, told["knee"], strict=True))}


def from_code(code: str) -> Snapshot:
    """Return the state in a link, of which the settings are only those that it names.

    Raises
    ------
    KneecoreError
        If it is no such text, is too large, or what it holds is no state.
    """
    content = _content(_unpacked(code))
    knee = saved.knee_of(content["baseline"]) if "baseline" in content else packaged_knee()
    told = _told(_new_page(knee, ()))
    for part in _PARTS:
        told[part] |= _table(content, part)
    if set(told["knee"]) != set(_NAMES):
        raise FileFormatError("the link's `knee` names an unknown parameter")
    return saved.from_document(told | {"knee": [told["knee"][name] for name in _NAMES]})


def _unpacked(code: str) -> str:
    """Return the text that is packed in a link; never more than it may hold is unpacked."""
    if len(code) > MOST_CHARACTERS:
        raise FileFormatError(
            f"the link has {len(code):,} characters; at most {MOST_CHARACTERS:,} are allowed"
        )
    if not _CODE.fullmatch(code):
        raise FileFormatError(
            "the link holds other characters than A to Z, a to z, 0 to 9, - and _"
        )
    unpacker = zlib.decompressobj()
    try:
        packed = base64.urlsafe_b64decode(code + "=" * (-len(code) % 4))
        text = unpacker.decompress(packed, MOST_UNPACKED).decode()
    except (ValueError, zlib.error):
        raise FileFormatError("the link is not whole") from None
    if unpacker.unconsumed_tail:
        raise FileFormatError(f"the link holds more than {MOST_UNPACKED:,} bytes")
    if not unpacker.eof or unpacker.unused_data:
        raise FileFormatError("the link is not whole")
    return text


def _content(text: str) -> dict[str, Any]:
    content = parse_object(text, MOST_UNPACKED)
    if content.get("schema") != SCHEMA:
        told = str(content.get("schema"))[:40]
        raise FileFormatError(f"the link's `schema` is {told!r}; {SCHEMA!r} is allowed")
    unknown = sorted(set(content) - _KEYS)
    if unknown:
        raise FileFormatError(f"the link's key {unknown[0][:40]!r} is unknown")
    return content


def _table(content: dict[str, Any], part: str) -> dict[str, Any]:
    table = content.get(part, {})
    if not isinstance(table, dict):
        raise FileFormatError(f"the link's `{part}` is no table")
    return table

r"""Files from strangers: read and parsed without being stopped, filled or fooled by them.

Reading opens regular files only, never waits, and takes in no more than it may. Before a parser
sees the text, one pass of linear time tells how deep it is nested: TOML's parser takes time with
the square of the dotted parts of a key (14 s for 40 kB), and JSON's goes down the stack with every
bracket. The pass hides texts and comments first, by patterns that never step back (``*+``), so that
no text makes the pass itself slow; where it reads a broken text otherwise than the parser does, the
parser has already refused it.
"""

import json
import math
import os
import re
import stat
import tomllib
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from kneecore._arguments import shown
from kneecore.errors import FileFormatError

__all__ = ["decoded", "parse_json", "parse_toml", "read_bytes", "read_text"]

LONGEST_LINE = 50_000
"""Characters: a note of the length that is allowed, each character written as an escape."""
DEEPEST_KEY = 8
"""Dotted parts of a TOML key."""
DEEPEST_TOML = 32
DEEPEST_JSON = 64
"""Brackets within brackets."""
MOST_TOML_ITEMS = 10_000
"""Keys, values and brackets of a TOML file; a knee has some 300."""
_MOST_DIGITS = 100  # of a whole number in JSON: far more than a generator's state needs

_TOML_TEXTS = re.compile(
    r"""
    \"{3} (?: [^"\\]++ | \\.? | "(?!"") )*+ (?: \"{3,5} | \Z )   # several lines, with escapes
  | '{3} (?: [^']++ | '(?!'') )*+ (?: '{3,5} | \Z )              # several lines, as they are
  | "(?: [^"\\\n]++ | \\[^\n]? )*+ "?
  | '[^'\n]*+ '?
  | \#[^\n]*+
    """,
    re.VERBOSE | re.DOTALL,
)
_NOT_BRACKETS = re.compile(r"[^\[\]{}]++")
_JSON_NOT_BRACKETS = re.compile(r'"(?:[^"\\]++|\\.?)*+"?|[^\[\]{}"]++', re.DOTALL)
_BETWEEN_KEYS = re.compile(r"[\n=,\[\]{}]")
_HALF_CHARACTER = re.compile(r"\\u[dD][89a-fA-F]")


def read_bytes(path: str | Path, limit: int) -> bytes:
    """Return the content of the regular file at `path`, of at most `limit` bytes.

    Raises
    ------
    FileFormatError
        If it cannot be read, is no regular file (a folder, a device, a pipe) or is larger; the
        message does not name the file.
    """
    try:
        # Opening may already act (a tape rewinds) or wait (a pipe), so the kind is looked at first;
        # and once more, as somebody may have put another file there meanwhile.
        _check_regular(os.stat(path))
        descriptor = os.open(
            path,
            os.O_RDONLY
            | getattr(os, "O_BINARY", 0)
            | getattr(os, "O_NONBLOCK", 0)
            | getattr(os, "O_NOCTTY", 0),
        )
        try:
            _check_regular(os.fstat(descriptor))
            return _read(descriptor, limit)
        finally:
            os.close(descriptor)
    except OSError as error:
        raise FileFormatError(f"cannot be read ({error.strerror or error})") from None
    except ValueError as error:  # a null character in the name, or half of a character
        if isinstance(error, FileFormatError):
            raise
        raise FileFormatError("cannot be read (no name of a file)") from None


def _check_regular(status: os.stat_result) -> None:
    if not stat.S_ISREG(status.st_mode):
        kind = "a folder" if stat.S_ISDIR(status.st_mode) else "a device, a pipe or a socket"
        raise FileFormatError(f"cannot be read (it is {kind}; a regular file is allowed)")


def _read(descriptor: int, limit: int) -> bytes:
    parts, left = [], limit + 1
    while left > 0 and (part := os.read(descriptor, min(left, 1 << 20))):
        parts.append(part)
        left -= len(part)
    if left == 0:
        raise FileFormatError(f"larger than {limit:,} bytes")
    return b"".join(parts)


def decoded(content: bytes) -> str:
    """Return `content` as text: UTF-8, with or without a byte-order mark.

    Raises
    ------
    FileFormatError
        If it is anything else.
    """
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FileFormatError("not a text file in UTF-8") from None


def read_text(path: str | Path, limit: int) -> str:
    """Return the text in the regular file at `path`, of at most `limit` bytes.

    Raises
    ------
    FileFormatError
        As `read_bytes` and `decoded`; the message does not name the file.
    """
    return decoded(read_bytes(path, limit))


def _own_text(text: str, limit: int) -> str:
    """Return `text`, as a file of at most `limit` bytes could hold it, without byte-order mark."""
    if not isinstance(text, str):
        raise FileFormatError(f"not a text but {shown(text)}")
    try:
        size = len(text.encode("utf-8"))
    except UnicodeEncodeError:
        raise FileFormatError("not a text that UTF-8 can hold") from None
    if size > limit:
        raise FileFormatError(f"larger than {limit:,} bytes")
    return text.removeprefix("\ufeff")


def _depth(brackets: str) -> int:
    """Return how deep `brackets`, a text of nothing else, are nested."""
    codes = np.frombuffer(brackets.encode("ascii"), dtype=np.uint8)
    opening = (codes == ord("[")) | (codes == ord("{"))
    steps = np.where(opening, np.int8(1), np.int8(-1))
    return int(np.cumsum(steps, dtype=np.int32).max(initial=0))


def _check_toml(text: str) -> None:
    longest = max(map(len, text.split("\n")))
    if longest > LONGEST_LINE:
        raise FileFormatError(
            f"a line has {longest:,} characters; at most {LONGEST_LINE:,} are allowed"
        )
    bare = _TOML_TEXTS.sub("_", text)
    brackets = _NOT_BRACKETS.sub("", bare)
    deepest = _depth(brackets)
    if deepest > DEEPEST_TOML:
        raise FileFormatError(
            f"brackets are nested {deepest:,} deep; at most {DEEPEST_TOML} are allowed"
        )
    items = bare.count("=") + bare.count(",") + len(brackets)
    if items > MOST_TOML_ITEMS:
        raise FileFormatError(
            f"it has {items:,} keys, values and brackets; at most {MOST_TOML_ITEMS:,} are allowed"
        )
    parts = 1 + max(part.count(".") for part in _BETWEEN_KEYS.split(bare))
    if parts > DEEPEST_KEY:
        raise FileFormatError(
            f"a key has {parts:,} dotted parts; at most {DEEPEST_KEY} are allowed"
        )


def parse_toml(text: str, limit: int) -> dict[str, Any]:
    """Return the document in the TOML `text`, of at most `limit` bytes.

    Raises
    ------
    FileFormatError
        If the text is longer, has lines, keys or brackets that no file of ours has, or is no TOML.
    """
    text = _own_text(text, limit)
    _check_toml(text)
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise FileFormatError(f"not a TOML file: {error}") from None


def _whole_number(digits: str) -> int:
    if len(digits) > _MOST_DIGITS:
        raise FileFormatError(
            f"a whole number has {len(digits):,} digits; at most {_MOST_DIGITS} are allowed"
        )
    return int(digits)


def _real_number(digits: str) -> float:
    value = float(digits)
    if not math.isfinite(value):
        raise FileFormatError(f"the number {shown(digits)[1:-1]} is too large")
    return value


def _constant(name: str) -> None:
    raise FileFormatError(f"not a JSON file: {name} is no number there; null is allowed")


def _table(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        twice = Counter(key for key, _ in pairs).most_common(1)[0][0]
        raise FileFormatError(f"the key {shown(twice)} is there twice")
    return table


def parse_json(text: str, limit: int) -> Any:
    """Return the document in the JSON `text`, of at most `limit` bytes.

    Every number in it is finite, every key of a table unique, and every text whole characters.

    Raises
    ------
    FileFormatError
        If the text is longer, nested deeper than any file of ours, or no such JSON.
    """
    text = _own_text(text, limit)
    deepest = _depth(_JSON_NOT_BRACKETS.sub("", text))
    if deepest > DEEPEST_JSON:
        raise FileFormatError(
            f"brackets are nested {deepest:,} deep; at most {DEEPEST_JSON} are allowed"
        )
    try:
        document = json.loads(
            text,
            parse_int=_whole_number,
            parse_float=_real_number,
            parse_constant=_constant,
            object_pairs_hook=_table,
        )
        if _HALF_CHARACTER.search(text):
            json.dumps(document, ensure_ascii=False).encode("utf-8")
    except FileFormatError:
        raise
    except UnicodeEncodeError:
        raise FileFormatError("a text in it holds half a character (\\ud800 to \\udfff)") from None
    except (ValueError, RecursionError) as error:
        raise FileFormatError(f"not a JSON file: {error}") from None
    return document

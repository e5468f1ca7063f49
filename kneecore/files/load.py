"""Results read back: one way in for every type, one line for every fault.

What a file says must agree with itself and with its digest. A file without one, of an earlier
version or made by hand, is read with all other checks.
"""

from pathlib import Path
from typing import Any

import numpy as np

from kneecore._arguments import file_name, shown, shown_name
from kneecore._untrusted import parse_json, read_text
from kneecore.errors import FileFormatError, KneecoreError
from kneecore.files.consistent import check_plain, check_same
from kneecore.files.digest import check_digest
from kneecore.files.study_relations import check_relations
from kneecore.presented import Format, format_with_schema

__all__ = [
    "MAX_BYTES",
    "from_json",
    "load",
    "load_with",
    "parse_object",
    "read_document",
    "read_object",
]

MAX_BYTES = 50_000_000
WITH_OTHERS = "paper.json"
"""The result that has others beside it: the paper's searches and samples."""


def parse_object(text: str, limit: int = MAX_BYTES) -> dict[str, Any]:
    """Return the JSON object in a text of at most `limit` bytes.

    Raises
    ------
    FileFormatError
        If it is none.
    """
    document = parse_json(text, limit)
    if not isinstance(document, dict):
        raise FileFormatError("not a JSON object")
    return document


def read_document(document: dict[str, Any], form: Format) -> Any:
    """Return the result in a parsed document, checked against itself and its digest."""
    schema = document.get("schema")
    if schema != form.schema:
        raise FileFormatError(f"`schema` is {shown(schema)}; {form.schema!r} is allowed")
    try:
        check_plain(document)
        with np.errstate(all="ignore"):  # a stranger's numbers may have any size
            result = form.from_dict(document)
            check_relations(result)
            check_same(document, form.to_dict(result))
        check_digest(document)
        return result
    except FileFormatError:
        raise
    except KneecoreError as error:
        raise FileFormatError(f"no usable result: {error}") from None
    except KeyError as error:
        raise FileFormatError(f"the key {error} is missing") from None
    except (TypeError, ValueError, AttributeError, IndexError, OverflowError) as error:
        raise FileFormatError(f"no usable result: {error}") from None


def from_json(text: str, form: Format) -> Any:
    """Return the result in a JSON text.

    Raises
    ------
    FileFormatError
        If the text is no result of this form.
    """
    return read_document(parse_object(text), form)


def _path(given: str | Path) -> Path:
    """Return a path that the system can be asked for."""
    path = Path(file_name("path", given))
    try:
        path.is_dir()
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else "no name of a file"
        raise FileFormatError(f"{shown(str(path))}: cannot be read ({reason})") from None
    return path


def _text_of(path: Path) -> str:
    return read_text(path, MAX_BYTES)


def read_object(path: str | Path) -> dict[str, Any]:
    """Return the JSON object in the file at `path`, checked against its digest.

    Raises
    ------
    FileFormatError
        If it cannot be read, is no such file or was changed after it was written; the message
        names the file.
    """
    try:
        document = parse_object(_text_of(_path(path)))
        check_plain(document)
        check_digest(document)
    except FileFormatError as error:
        raise FileFormatError(f"{shown_name(str(path))}: {error}") from None
    return document


def load_with(path: str | Path, form: Format) -> Any:
    """Return the result of one form in the file, or in the folder, at `path`.

    Raises
    ------
    FileFormatError
        If it cannot be read or is no such result; the message names the file.
    """
    path = _path(path)
    if path.is_dir():
        path = path / form.file
    try:
        return from_json(_text_of(path), form)
    except FileFormatError as error:
        raise FileFormatError(f"{shown_name(str(path))}: {error}") from None


def load(path: str | Path) -> Any:
    """Return whatever result is in the file, or in the folder, at `path`.

    Raises
    ------
    FileFormatError
        If there is none, or more than one in a folder; the message names the file.
    """
    path = _path(path)
    if path.is_dir():
        path = _only_result(path)
    try:
        document = parse_object(_text_of(path))
        form = format_with_schema(document.get("schema"))
        if form is None:
            raise FileFormatError(
                f"`schema` is {shown(document.get('schema'))}, which is no result's"
            )
        return read_document(document, form)
    except FileFormatError as error:
        raise FileFormatError(f"{shown_name(str(path))}: {error}") from None


def _only_result(folder: Path) -> Path:
    """Return the JSON file in a folder of `save`."""
    found = sorted(folder.glob("*.json"))
    found = [path for path in found if path.name == WITH_OTHERS] or found
    if len(found) != 1:
        names = ", ".join(path.name for path in found) or "none"
        raise FileFormatError(f"{folder}: one JSON file is needed, there are: {names}")
    return found[0]

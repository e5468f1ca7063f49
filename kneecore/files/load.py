"""Results read back: one way in for every type, one line for every fault."""

from pathlib import Path
from typing import Any

from kneecore._arguments import file_name, shown, shown_name
from kneecore._untrusted import parse_json, read_text
from kneecore.errors import FileFormatError, KneecoreError
from kneecore.presented import Format, format_with_schema

__all__ = ["MAX_BYTES", "from_json", "load", "load_with"]

MAX_BYTES = 50_000_000
WITH_OTHERS = "paper.json"
"""The result that has others beside it: the paper's searches and samples."""


def _document(text: str) -> dict[str, Any]:
    document = parse_json(text, MAX_BYTES)
    if not isinstance(document, dict):
        raise FileFormatError("not a JSON object")
    return document


def _read(document: dict[str, Any], form: Format) -> Any:
    schema = document.get("schema")
    if schema != form.schema:
        raise FileFormatError(f"`schema` is {shown(schema)}; {form.schema!r} is allowed")
    try:
        return form.from_dict(document)
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
    return _read(_document(text), form)


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
        document = _document(_text_of(path))
        form = format_with_schema(document.get("schema"))
        if form is None:
            raise FileFormatError(
                f"`schema` is {shown(document.get('schema'))}, which is no result's"
            )
        return _read(document, form)
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

"""What the files of all kinds of pages share: how a state is written, read and refused."""

import json
from collections.abc import Callable, Set
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

from kneecore import FileFormatError, KneecoreError, SearchResult
from kneecore.files.digest import DIGEST
from kneecore.files.load import read_object
from kneeviz.state.snapshot import Settings

__all__ = ["check_keys", "flag", "read_result", "read_settings", "read_state", "told"]

StateT = TypeVar("StateT")


@lru_cache(maxsize=2)
def told(result: SearchResult) -> dict[str, Any]:
    """Return a result as JSON-ready values; a page tells the same one many times."""
    return result.to_dict()


def read_state(path: str | Path, read: Callable[[dict[str, Any]], StateT]) -> StateT:
    """Return what `read` makes of the document in the file at `path`.

    Raises
    ------
    FileFormatError
        If it cannot be read, or `read` refuses it; the message names the file.
    """
    document = read_object(path)
    try:
        return read(document)
    except KneecoreError as error:
        raise FileFormatError(f"{path}: {error}") from None


def check_keys(document: dict[str, Any], schema: str, keys: Set[str]) -> None:
    """Raise a `FileFormatError` if a document is of another schema, or has other keys."""
    if document.get("schema") != schema:
        raise FileFormatError(
            f"`schema` is {str(document.get('schema'))[:40]!r}; {schema!r} is allowed"
        )
    wrong = sorted(keys ^ (set(document) - {DIGEST}))
    if wrong:
        raise FileFormatError(f"the key {wrong[0][:40]!r} is missing or unknown")


def read_result(table: Any, checked: Callable[[SearchResult], SearchResult]) -> SearchResult | None:
    """Return a result that `told` has told and that is `checked` to be the page's, or None."""
    if table is None:
        return None
    try:
        return checked(SearchResult.from_json(json.dumps(table)))
    except KneecoreError as error:
        raise FileFormatError(f"`result`: {error}") from None


def flag(document: dict[str, Any], key: str) -> bool:
    """Return what must be true or false."""
    if not isinstance(document[key], bool):
        raise FileFormatError(f"`{key}` is {str(document[key])[:40]!r}; true or false is allowed")
    return bool(document[key])


def read_settings(table: Any) -> Settings:
    """Return settings; whether a page has them is not known here."""
    if not isinstance(table, dict):
        raise FileFormatError("`settings` is no table")
    return tuple(table.items())

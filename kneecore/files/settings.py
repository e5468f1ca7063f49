"""The options of a settings class in a result's JSON, each at its place, and back."""

import dataclasses
from typing import Any, TypeVar

from kneecore.errors import FileFormatError, ParameterError
from kneecore.options import options_of

__all__ = ["read_settings", "write_settings"]

_Settings = TypeVar("_Settings")


def _plain(value: Any) -> Any:
    """Return an option's value as JSON holds it."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return dataclasses.asdict(value)
    return list(value) if isinstance(value, tuple) else value


def write_settings(settings: Any, document: dict[str, Any], *, without: frozenset[str]) -> None:
    """Put every option at its place in `document`; those `without` are told there by others."""
    for one in options_of(type(settings)):
        if one.name in without:
            continue
        table = document
        for key in one.place[:-1]:
            table = table.setdefault(key, {})
        table[one.place[-1]] = _plain(getattr(settings, one.name))


def _at(document: dict[str, Any], place: tuple[str, ...]) -> tuple[bool, Any]:
    table: Any = document
    for key in place:
        if not isinstance(table, dict) or key not in table:
            return False, None
        table = table[key]
    return True, table


def read_settings(kind: type[_Settings], document: dict[str, Any], **known: Any) -> _Settings:
    """Return the settings that `write_settings` has put there.

    An option that was not yet there when the file was written has its default; `known` ones are
    not looked for.

    Raises
    ------
    FileFormatError
        If a value is not allowed; the message names it as the file does.
    """
    values = dict(known)
    for one in options_of(kind):
        if one.name in known:
            continue
        there, value = _at(document, one.place)
        if not there:
            continue
        if dataclasses.is_dataclass(one.default) and isinstance(value, dict):
            kind_of_value: Any = type(one.default)
            value = kind_of_value(**value)
        elif isinstance(value, list):
            value = tuple(value)
        values[one.name] = value
    try:
        return kind(**values)
    except ParameterError as error:
        told = str(error)
    for one in options_of(kind):
        told = told.replace(f"`{one.name}`", f"`{'.'.join(one.place)}`")
    raise FileFormatError(told)

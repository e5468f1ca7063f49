"""Checks of arguments that every callable shares: one line that names what it got.

A value that somebody else hands over may be anything, also something whose text is a megabyte, has
lines, or cannot be made at all (Python refuses to print whole numbers of 4,301 digits). `shown` is
how such a value comes into a message.
"""

import math
import os
from collections.abc import Callable, Sequence
from numbers import Integral, Real
from typing import Any, TypeVar

from kneecore.errors import ParameterError

__all__ = [
    "LARGEST_COUNT",
    "callback_or_none",
    "choice",
    "file_name",
    "flag",
    "number",
    "one_line",
    "shown",
    "shown_name",
    "text",
    "whole_number",
]

LARGEST_COUNT = 2**31 - 1
"""No count of models, pairs or generations above it could ever be computed."""
_LONGEST = 80

_T = TypeVar("_T", bound=str)
_C = TypeVar("_C")


def shown(value: object, longest: int = _LONGEST) -> str:
    """Return `value` as a message shows it: its repr, in one line and not too long."""
    try:
        line = " ".join(repr(value).split())
    except Exception:  # whatever a stranger's __repr__ raises
        return f"a value of type {type(value).__name__}"
    if len(line) <= longest:
        return line
    return f"{line[: longest - 20]}... ({len(line):,} characters)"


def shown_name(path: str) -> str:
    """Return the name of a file as a message shows it: as it is, unless it is long or odd."""
    longest = 4 * _LONGEST
    return path if path.isprintable() and len(path) <= longest else shown(path, longest)


def choice(name: str, value: Any, allowed: Sequence[_T], said: str | None = None) -> _T:
    """Return `value`, one of the words `allowed`; `said` is how the message lists them.

    Raises
    ------
    ParameterError
        If it is anything else.
    """
    # A whole array would be compared with each word.
    if isinstance(value, str):
        for word in allowed:
            if value == word:
                return word
    listed = said or f"{' or '.join(repr(str(word)) for word in allowed)} is allowed"
    raise ParameterError(f"`{name}` is {shown(value)}; {listed}")


def flag(name: str, value: Any) -> bool:
    """Return `value`, True or False.

    Raises
    ------
    ParameterError
        If it is anything else.
    """
    # NumPy's is known by its name: command lines check flags before NumPy is loaded.
    if isinstance(value, bool) or type(value).__name__ in ("bool", "bool_"):
        return bool(value)
    raise ParameterError(f"`{name}` is {shown(value)}; True or False is allowed")


def whole_number(name: str, value: Any, least: int, most: int, said: str | None = None) -> int:
    """Return `value`, a whole number from `least` to `most`; `said` is how the message has it.

    Raises
    ------
    ParameterError
        If it is anything else.
    """
    if isinstance(value, Integral) and not isinstance(value, bool):
        exact = int(value)
        if least <= exact <= most:
            return exact
    allowed = said or f"a whole number from {least:,} to {most:,}"
    raise ParameterError(f"`{name}` is {shown(value)}; {allowed} is allowed")


def number(
    name: str, value: Any, *, unit: str = "", least: float = -math.inf, most: float = math.inf
) -> float:
    """Return `value` as a float: a finite number from `least` to `most`.

    Raises
    ------
    ParameterError
        If it is anything else.
    """
    unit = f" {unit}" if unit else ""
    allowed = "a finite number"
    if math.isfinite(least) and math.isfinite(most):
        allowed += f" from {least:g} to {most:g}{unit}"
    elif math.isfinite(least):
        allowed += f" of at least {least:g}{unit}"
    elif math.isfinite(most):
        allowed += f" of at most {most:g}{unit}"
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ParameterError(f"`{name}` is {shown(value)}; {allowed} is allowed")
    try:
        converted = float(value)
    except (OverflowError, ValueError, TypeError):  # a whole number that no float can hold
        raise ParameterError(f"`{name}` is {shown(value)}; {allowed} is allowed") from None
    if not (math.isfinite(converted) and least <= converted <= most):
        raise ParameterError(f"`{name}` is {converted:g}{unit}; {allowed} is allowed")
    return converted


def text(name: str, value: Any, longest: int) -> str:
    """Return `value`, a text of at most `longest` characters that UTF-8 can hold.

    Raises
    ------
    ParameterError
        If it is anything else.
    """
    if not isinstance(value, str):
        raise ParameterError(f"`{name}` is {shown(value)}; text is allowed")
    if len(value) > longest:
        raise ParameterError(
            f"`{name}` has {len(value):,} characters; at most {longest:,} are allowed"
        )
    try:
        value.encode("utf-8")
    except UnicodeEncodeError:
        raise ParameterError(
            f"`{name}` is {shown(value)}, with half a character in it; text is allowed"
        ) from None
    return value


def one_line(name: str, value: Any, longest: int) -> str:
    """Return a checked `text` in one line: a title of several passes for other lines of a report.

    Raises
    ------
    ParameterError
        As `text`.
    """
    return " ".join(text(name, value, longest).split())


def file_name(name: str, value: Any) -> str:
    """Return `value`, the name of a file or a folder, as text.

    A number would be taken for an open file's descriptor: True is that of stdout.

    Raises
    ------
    ParameterError
        If it is anything else.
    """
    path = os.fspath(value) if isinstance(value, str | os.PathLike) else None
    if not isinstance(path, str):
        raise ParameterError(f"`{name}` is {shown(value)}; the name of a file is allowed")
    return path


def callback_or_none(
    value: Callable[..., _C] | None, name: str = "callback"
) -> Callable[..., _C] | None:
    """Return `value`, a callable or None.

    Raises
    ------
    ParameterError
        If it is anything else.
    """
    if value is None or callable(value):
        return value
    raise ParameterError(f"`{name}` is {shown(value)}; a callable or None is allowed")

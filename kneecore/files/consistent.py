"""A file must say the same in all places: what was read, told again, is held against it."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kneecore._arguments import shown
from kneecore._version import versions
from kneecore.errors import FileFormatError

__all__ = ["check_equal", "check_finite_or_not", "check_holds", "check_plain", "check_same"]

ROUNDING = 1e-8
"""Knees' numbers have ten decimals; what is derived from several has lost two."""
_WORDS = frozenset({"summary", "answer", "command", "description"})
"""Another version may have other words for the same numbers."""
_NOT_READ = frozenset({"digest", "title", "flexion_at_rest_deg"})
"""What a file has beside its result; a baseline's title is read and compared further down."""


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def check_plain(document: dict[str, Any]) -> None:
    """Raise a `FileFormatError` if a time is below 0, or a count no whole number of at least 0."""
    for where, value in _numbers(document, ""):
        keys = where.split(".")
        if "seconds" in keys and value < 0:
            raise FileFormatError(f"`{where}` is {value:g}; a number of at least 0 is allowed")
        counted = keys[0] == "counts" or keys[-1].startswith(("n_", "models_"))
        if counted and (value < 0 or value != math.floor(value)):
            raise FileFormatError(
                f"`{where}` is {value:g}; a whole number of at least 0 is allowed"
            )


def _numbers(value: Any, where: str) -> Iterator[tuple[str, float]]:
    """Yield the numbers in tables, and in lists of times and counts, with their places."""
    if isinstance(value, dict):
        for key, one in value.items():
            yield from _numbers(one, f"{where}.{key}" if where else str(key))
    elif isinstance(value, list) and where.rpartition(".")[2] in ("seconds", "n_failed", "rounds"):
        for one in value:
            yield from _numbers(one, where)
    elif _is_number(value):
        yield where, value


def check_same(document: dict[str, Any], again: dict[str, Any]) -> None:
    """Raise a `FileFormatError` if what a file says is not what its result says again.

    Keys that the file lacks are from later versions; keys that the result lacks, and other words
    for the same numbers, are allowed to files of other versions.
    """
    written_by = document.get("versions", {}).get("kneecore")
    ours = written_by in (None, versions()["kneecore"])
    _compare(document, again, "", ours=ours)


def _compare(said: Any, follows: Any, where: str, *, ours: bool) -> None:
    if isinstance(said, dict) and isinstance(follows, dict):
        if "[" in where and (left := [key for key in follows if key not in said]):
            raise FileFormatError(f"`{where}` lacks {shown(left[0])}, which follows from the rest")
        for key, value in said.items():
            place = f"{where}.{key}" if where else str(key)
            if key in follows and (ours or key not in _WORDS):
                if where or key not in _NOT_READ:
                    _compare(value, follows[key], place, ours=ours)
            elif key not in follows and ours and (where or key not in _NOT_READ):
                raise FileFormatError(f"the key {shown(place)} is none of such a result's")
    elif isinstance(said, list | tuple) and isinstance(follows, list | tuple):
        if len(said) != len(follows):
            raise FileFormatError(
                f"`{where}` has {len(said)} entries; {len(follows)} follow from the rest"
            )
        for i, (one, other) in enumerate(zip(said, follows, strict=True)):
            _compare(one, other, f"{where}[{i}]", ours=ours)
    elif _is_number(said) and _is_number(follows):
        if not math.isclose(said, follows, rel_tol=ROUNDING, abs_tol=ROUNDING):
            raise _disagree(where, said, follows)
    elif type(said) is not type(follows) or said != follows:
        raise _disagree(where, said, follows)


def _disagree(where: str, said: Any, follows: Any) -> FileFormatError:
    return FileFormatError(f"`{where}` is {shown(said)}; {shown(follows)} follows from the rest")


def check_equal(
    where: str, said: ArrayLike | None, follows: ArrayLike | None, rounding: float = ROUNDING
) -> None:
    """Raise a `FileFormatError` if numbers differ beyond rounding; None and NaN are unknown."""
    one, other = np.broadcast_arrays(
        *(np.asarray(math.nan if v is None else v, dtype=np.float64) for v in (said, follows))
    )
    differ = ~np.isclose(one, other, rtol=rounding, atol=rounding, equal_nan=True)
    if differ.any():
        first = int(np.argmax(differ.ravel()))
        shown_ones = (
            None if math.isnan(v.flat[first]) else float(v.flat[first]) for v in (one, other)
        )
        raise _disagree(where, *shown_ones)


def check_holds(where: str, holds: ArrayLike, allowed: str) -> None:
    """Raise a `FileFormatError` if not everything `holds`; `allowed` says in words what should."""
    if not np.all(holds):
        raise FileFormatError(f"`{where}` contradicts the rest of the file; {allowed}")


def check_finite_or_not(where: str, rows: ArrayLike) -> None:
    """Raise a `FileFormatError` if a row is neither known as a whole nor unknown as a whole."""
    known = np.isfinite(np.asarray(rows, dtype=np.float64))
    known = known.reshape(len(known), -1)
    check_holds(where, known.all(axis=1) | ~known.any(axis=1), "a model has all numbers or none")

"""Knee files (TOML): a baseline with units, half-ranges and sources; optionally a current knee."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from numpy.typing import ArrayLike, NDArray

from kneecore import _untrusted
from kneecore._arguments import file_name, flag, one_line, shown, shown_name
from kneecore._arguments import text as checked_text
from kneecore._arrays import numbers
from kneecore._assets import asset_path
from kneecore.errors import FileFormatError, ParameterError
from kneecore.knee import units
from kneecore.knee.likely import KneeDistribution, Likely
from kneecore.knee.parameters import (
    ALL_NAMES,
    LARGEST,
    NAMES,
    REST_LENGTH_NAMES,
    STRUCTURE,
    Parameter,
    check_physical,
    in_display_unit,
    widened,
)

__all__ = ["KneeFile", "dump_knee", "packaged_knee", "parameter_table", "parse_knee", "read_knee"]

SCHEMA = "kneecore.knee/1"
MAX_BYTES = 1_000_000
LONGEST_TEXT = 4_000
"""Characters of a title, a note or a source."""
_DISPLAY_UNITS = {row[0]: row[3] for row in STRUCTURE}
_TOP_KEYS = {
    "schema", "title", "note", "prior", "distribution", "deviations", "parameters", "current",
}  # fmt: skip
_PARAMETER_KEYS = {"value", "unit", "half_range", "half_range_unit", "source"}

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class KneeFile:
    """What a knee file holds."""

    title: str
    """Name of the baseline."""
    note: str | None
    """What a reader of results must know about it."""
    baseline: FloatArray
    """Baseline values, SI, shape (28,); (32,) if the file changes rest lengths."""
    half_ranges: FloatArray
    """Half-ranges, same shape, SI."""
    sources: tuple[str, ...]
    """Where each baseline value is from."""
    current: FloatArray | None
    """A knee apart from the baseline, same shape, SI, or None."""
    distribution: KneeDistribution = "uniform"
    """How samples of its space are drawn."""
    deviations: float | None = None
    """How many standard deviations of a normal distribution the half-ranges are; 3 for None."""


def _number(where: str, value: Any) -> float:
    try:
        if isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value):
            return float(value)
    except OverflowError:  # a whole number that no float can hold
        pass
    raise FileFormatError(f"`{where}` is {shown(value)}; a finite number is allowed")


def _text(where: str, value: Any) -> str:
    try:
        return checked_text(where, value, LONGEST_TEXT).strip()
    except ParameterError as error:
        raise FileFormatError(str(error)) from None


def _table(where: str, value: Any) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise FileFormatError(f"`{where}` is {shown(value)}; a table is allowed")
    return value


def _known(where: str, table: Mapping[str, Any], allowed: set[str] | tuple[str, ...]) -> None:
    for key in table:
        if key not in allowed:
            names = ", ".join(sorted(allowed)) if len(allowed) < 10 else "the 28 parameters' names"
            raise FileFormatError(f"`{where}` has the unknown key {shown(key)}; allowed: {names}")


def _parameter(name: str, entry: Any) -> tuple[float, float, float, str]:
    """Return (SI factor, value, half-range, source) of one parameter's table."""
    where = f"parameters.{name}"
    table = _table(where, entry)
    _known(where, table, _PARAMETER_KEYS)
    for key in ("value", "unit"):
        if key not in table:
            raise FileFormatError(f"`{where}` lacks the key {key!r}")
    try:
        factor = units.si_factor(_text(f"{where}.unit", table["unit"]), _DISPLAY_UNITS[name])
    except FileFormatError as error:
        raise FileFormatError(f"`{where}.unit`: {error}") from None
    value = factor * _number(f"{where}.value", table["value"])
    half = _number(f"{where}.half_range", table.get("half_range", 0.0))
    if half < 0.0:
        raise FileFormatError(
            f"`{where}.half_range` is {half:g}; a number of at least 0 is allowed"
        )
    unit_of_half = table.get("half_range_unit", table["unit"])
    if unit_of_half == "%":
        half *= 0.01 * abs(value)
    elif unit_of_half == table["unit"]:
        half *= factor
    else:
        raise FileFormatError(
            f"`{where}.half_range_unit` is {shown(unit_of_half)}; "
            f"{table['unit']!r} or '%' is allowed"
        )
    if not math.isfinite(half):
        raise FileFormatError(f"`{where}.half_range` is {half:g}; a finite number is allowed")
    return factor, value, half, _text(f"{where}.source", table.get("source", ""))


def parse_knee(text: str | bytes) -> KneeFile:
    """Return the knee that the TOML `text` describes, a file's content in UTF-8 or decoded.

    Raises
    ------
    FileFormatError
        For text that is larger than 1 MB, too deeply nested or not TOML, an unknown schema, key or
        unit, a missing parameter, or values that no knee can have.
    """
    if isinstance(text, bytes | bytearray):
        text = _untrusted.decoded(bytes(text))
    elif not isinstance(text, str):
        raise ParameterError(f"`text` is {shown(text)}; a knee file's text is allowed")
    document = _untrusted.parse_toml(text, MAX_BYTES)
    if document.get("schema") != SCHEMA:
        raise FileFormatError(f"`schema` is {shown(document.get('schema'))}; {SCHEMA!r} is allowed")
    _known("the file", document, _TOP_KEYS)
    table = _table("parameters", document.get("parameters", {}))
    _known("parameters", table, ALL_NAMES)
    missing = [name for name in NAMES if name not in table]
    if missing:
        raise FileFormatError(
            f"`parameters` lacks {missing[0]!r}"
            + (f" and {len(missing) - 1} more" if len(missing) > 1 else "")
            + "; all 28 are needed"
        )
    entries = _table("current", document.get("current", {}))
    names, table = _with_rest_lengths(table, entries)
    rows = [_parameter(name, table[name]) for name in names]
    factors, values, halves, sources = zip(*rows, strict=True)
    baseline = _possible(np.array(values), "parameters")
    half_ranges = _usable(names, np.array(halves))
    current = None
    if "current" in document:
        current = baseline.copy()
        _known("current", entries, names)
        for name, value in entries.items():
            index = names.index(name)
            current[index] = factors[index] * _number(f"current.{name}", value)
        current = _possible(current, "current")
    likely = _likely(document)
    title = _text("title", document.get("title", "Untitled knee"))
    note = _text("note", document["note"]) if "note" in document else None
    for array in (baseline, half_ranges, current):
        if array is not None:
            array.setflags(write=False)
    return KneeFile(
        title=one_line("title", title, LONGEST_TEXT),
        note=note,
        baseline=baseline,
        half_ranges=half_ranges,
        sources=sources,
        current=current,
        distribution=likely.distribution,
        deviations=likely.deviations,
    )


def _likely(document: Mapping[str, Any]) -> Likely:
    given = {key: document[key] for key in ("distribution", "deviations") if key in document}
    try:
        return Likely(**given).checked()
    except ParameterError as error:
        raise FileFormatError(str(error)) from None


def _with_rest_lengths(
    table: Mapping[str, Any], current: Mapping[str, Any]
) -> tuple[tuple[str, ...], Mapping[str, Any]]:
    """Return the names to read and the table, rest lengths included if any is named."""
    if not any(name in table or name in current for name in REST_LENGTH_NAMES):
        return NAMES, table
    unchanged = {"value": 0.0, "unit": "mm"}
    return ALL_NAMES, dict.fromkeys(REST_LENGTH_NAMES, unchanged) | dict(table)


def _possible(values: FloatArray, where: str) -> FloatArray:
    try:
        return check_physical(values, where)
    except ParameterError as error:
        raise FileFormatError(str(error)) from None


def _usable(names: tuple[str, ...], half_ranges: FloatArray) -> FloatArray:
    """Return the half-ranges, if none is larger than any knee's value."""
    for column, (name, half) in enumerate(zip(names, half_ranges, strict=True)):
        if half > LARGEST[column]:
            raise FileFormatError(
                f"`parameters.{name}.half_range` is {in_display_unit(column, half)}; at most "
                f"{in_display_unit(column, LARGEST[column])} is allowed (which unit?)"
            )
    return half_ranges


def read_knee(path: str | Path) -> KneeFile:
    """Return the knee in the file at `path`.

    Raises
    ------
    FileFormatError
        If the file cannot be read, is no regular file, is larger than 1 MB, or is no knee; the
        message names the file.
    ParameterError
        If `path` is no name of a file.
    """
    name = file_name("path", path)
    if name == "":
        raise FileFormatError("the name of a knee file is empty")
    try:
        return parse_knee(_untrusted.read_bytes(name, MAX_BYTES))
    except FileFormatError as error:
        raise FileFormatError(f"{shown_name(name)}: {error}") from None


@cache
def packaged_knee() -> KneeFile:
    """Return the packaged baseline (a reconstruction: see its note)."""
    return read_knee(asset_path("baseline.toml"))


def parameter_table(*, rest_lengths: bool = False) -> tuple[Parameter, ...]:
    """Return the 28 parameters, one row each, with the packaged baseline's values.

    With `rest_lengths` the changes of the four rest lengths follow.
    """
    return _table_of(flag("rest_lengths", rest_lengths))


@cache
def _table_of(rest_lengths: bool) -> tuple[Parameter, ...]:
    knee = packaged_knee()
    rows = STRUCTURE if rest_lengths else STRUCTURE[: len(NAMES)]
    baseline, half_ranges = (widened(v, len(rows)) for v in (knee.baseline, knee.half_ranges))
    sources = knee.sources + ("none: the paper leaves rest lengths out",) * len(REST_LENGTH_NAMES)
    return tuple(
        Parameter(
            name=name,
            group=group,
            kind=kind,
            unit=unit,
            meaning=meaning,
            baseline=float(baseline[i]),
            half_range=float(half_ranges[i]),
            source=sources[i],
        )
        for i, (name, group, kind, unit, meaning) in enumerate(rows)
    )


def dump_knee(
    *,
    baseline: ArrayLike,
    half_ranges: ArrayLike,
    sources: tuple[str, ...] | None = None,
    current: ArrayLike | None = None,
    title: str = "My knee",
    note: str | None = None,
    distribution: KneeDistribution = "uniform",
    deviations: float | None = None,
) -> str:
    """Return a knee file's text; `parse_knee` of it gives the same bits back.

    Parameters
    ----------
    baseline, half_ranges, current : array_like, shape (28,) or (32,)
        SI values; `current` is a knee apart from the baseline. What the longest of them has more,
        the others have as 0.
    sources : tuple of str, optional
        Where each baseline value is from.
    title, note : str, optional
        For reports.
    distribution : {"uniform", "normal", "truncated-normal", "triangular"}
        How samples are drawn.
    deviations : float, optional
        How many standard deviations of a normal distribution the half-ranges are; 3 for None.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    values = _one_knee("baseline", baseline)
    halves = _half_ranges(half_ranges)
    now = None if current is None else _one_knee("current", current)
    title = one_line("title", title, LONGEST_TEXT)
    for name, said in (("note", "" if note is None else note), *_named(sources)):
        checked_text(name, said, LONGEST_TEXT)
    width = max(len(a) for a in (values, halves, now) if a is not None)
    values, halves = widened(values, width), widened(halves, width)
    now = None if now is None else widened(now, width)
    document: dict[str, Any] = {"schema": SCHEMA, "title": title}
    if note:
        document["note"] = note
    document |= Likely(distribution, deviations).told
    document["parameters"] = {}
    document |= {} if now is None else {"current": {}}
    for i, name in enumerate(ALL_NAMES[:width]):
        numbers = [values[i], halves[i]] + ([] if now is None else [now[i]])
        unit, shown = _in_a_lossless_unit(numbers, _DISPLAY_UNITS[name])
        document["parameters"][name] = {
            "value": shown[0],
            "unit": unit,
            "half_range": shown[1],
            "source": sources[i] if sources and i < len(sources) else "",
        }
        if now is not None:
            document["current"][name] = shown[2]
    return tomli_w.dumps(document)


def _one_knee(name: str, values: ArrayLike) -> FloatArray:
    knee = check_physical(values, name)
    if knee.ndim != 1:
        raise ParameterError(f"`{name}` has shape {knee.shape}; (28,) or (32,) is allowed")
    return knee


def _half_ranges(values: ArrayLike) -> FloatArray:
    halves = numbers("half_ranges", values)
    if halves.shape not in ((len(NAMES),), (len(ALL_NAMES),)):
        raise ParameterError(f"`half_ranges` has shape {halves.shape}; (28,) or (32,) is allowed")
    if not (np.isfinite(halves) & (halves >= 0.0)).all():
        raise ParameterError("`half_ranges` holds a number that is below 0 or not finite")
    absurd = halves > LARGEST[: len(halves)]
    if absurd.any():
        column = int(np.argmax(absurd))
        raise ParameterError(
            f"`half_ranges`: that of `{ALL_NAMES[column]}` is "
            f"{in_display_unit(column, halves[column])}; at most "
            f"{in_display_unit(column, LARGEST[column])} is allowed (which unit?)"
        )
    return halves


def _named(sources: Any) -> list[tuple[str, Any]]:
    if sources is None:
        return []
    if isinstance(sources, str) or not isinstance(sources, Sequence):
        raise ParameterError(f"`sources` is {shown(sources)}; texts are allowed")
    return [(f"sources[{i}]", source) for i, source in enumerate(sources)]


def _in_a_lossless_unit(numbers: list[float], unit: str) -> tuple[str, list[float]]:
    """Return a unit, and SI `numbers` in it that map back to the same bits.

    That is `unit` wherever it can be: one in some thousands of SI values is not the product of
    any float and the unit's factor, and is then written in SI.
    """
    decimals = [_decimal(float(number), units.si_factor(unit)) for number in numbers]
    if all(number is not None for number in decimals):
        return unit, [float(number) for number in decimals if number is not None]
    return units.si_unit(unit), [float(number) for number in numbers]


def _decimal(value: float, factor: float) -> float | None:
    """Return the shortest decimal that times `factor` is exactly `value`, if there is one."""
    near = value / factor
    for digits in range(6, 18):
        number = float(f"{near:.{digits}g}")
        if factor * number == value:
            return number
    for number in (math.nextafter(near, -math.inf), math.nextafter(near, math.inf)):
        if factor * number == value:
            return number
    return None

"""A model in a TOML file: inputs, outputs, and a function or a program.

The file names code that is run: read none that you would not run as a program.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from kneecore._arguments import file_name, shown, shown_name
from kneecore._untrusted import parse_toml, read_text
from kneecore.errors import FileFormatError, KneecoreError
from kneecore.inputs import Input
from kneecore.outputs import Output
from kneecore.runs.functions import function_named
from kneecore.runs.program import Program
from kneecore.runs.readers import CsvOutput, JsonOutput, Read, TextOutput

__all__ = ["read_model_file"]

LARGEST = 1 << 20
"""Bytes of a model's file."""

_TOP = ("name", "note", "inputs", "outputs", "correlation", "function", "program", "runs")
_INPUT = (
    "name", "nominal", "tolerance_percent", "half_range", "lower", "upper", "integer", "choices",
    "distribution", "deviations", "mode", "least", "most", "quantile", "unit", "shown_unit",
    "shown_scale", "measurement",
)  # fmt: skip
_OUTPUT = ("name", "unit", "axis", "axis_name", "axis_unit", "scale")
_FUNCTION = ("run", "batched", "gradient", "draw", "picture_unit")
_PROGRAM = ("command", "template", "read", "files", "folder", "keep_runs")
_RUNS = ("workers", "keep", "timeout_s", "on_failure", "retries", "rerun_failures")
_READ = ("json", "keys", "csv", "column", "delimiter", "text", "pattern", "function")


class _Wrong(Exception):
    """What is wrong, without the file's name."""


def _table(value: Any, where: str, known: Sequence[str], needed: Sequence[str] = ()) -> Any:
    if not isinstance(value, Mapping):
        raise _Wrong(f"`{where}` is {shown(value)}; a table is allowed")
    for key in value:
        if key not in known:
            at = f"{where}.{key}" if where else key
            raise _Wrong(f"`{at}` is no key of a model's file; {', '.join(known)} are allowed")
    for key in needed:
        if key not in value:
            raise _Wrong(f"`{f'{where}.{key}' if where else key}` is missing")
    return value


def _tables(value: Any, where: str) -> list[Any]:
    if not isinstance(value, list) or not value:
        raise _Wrong(f"`{where}` is {shown(value)}; at least one table [[{where}]] is needed")
    return value


@contextmanager
def _at(where: str) -> Iterator[None]:
    """Name the place in the file in what is raised about a value of it."""
    try:
        yield
    except KneecoreError as error:
        raise _Wrong(f"`{where}`: {error}") from None
    except TypeError as error:
        raise _Wrong(f"`{where}`: {' '.join(str(error).split())[:200]}") from None


def _all_of(kind: Callable[..., Any], value: Any, where: str, known: Sequence[str]) -> list[Any]:
    made = []
    for k, one in enumerate(_tables(value, where), start=1):
        place = f"{where}[{k}]"
        table = _table(one, place, known, ("name",))
        with _at(place):
            made.append(kind(**table))
    return made


def _reader(value: Any, where: str, folder: Path) -> Read:
    table = _table(value, where, _READ)
    kinds: dict[str, tuple[tuple[str, ...], Callable[[], Any]]] = {
        "json": (("keys",), lambda: JsonOutput(table["json"], *_texts(table, "keys", where))),
        "csv": (
            ("column",),
            lambda: CsvOutput(table["csv"], table["column"], table.get("delimiter", ",")),
        ),
        "text": (("pattern",), lambda: TextOutput(table["text"], table["pattern"])),
        "function": ((), lambda: function_named("function", table["function"], folder)),
    }
    chosen = [kind for kind in kinds if kind in table]
    if len(chosen) != 1:
        raise _Wrong(
            f"`{where}` has {len(chosen)} ways to read the output; one is needed: "
            f"{', '.join(kinds)}"
        )
    needed, make = kinds[chosen[0]]
    for key in needed:
        if key not in table:
            raise _Wrong(f"`{where}.{key}` is missing")
    with _at(where):
        made: Read = make()
    return made


def _texts(table: Mapping[str, Any], key: str, where: str) -> list[str]:
    value = table[key]
    several = [value] if isinstance(value, str) else value
    if not isinstance(several, list) or not all(isinstance(one, str) for one in several):
        raise _Wrong(f"`{where}.{key}` is {shown(value)}; texts are allowed")
    return several


def _path(folder: Path, key: str, value: Any) -> str:
    with _at(key):
        return str(folder / file_name(key.rpartition(".")[2], value))


def _program(table: Any, folder: Path, inputs: list[Input], runs: Mapping[str, Any]) -> Program:
    _table(table, "program", _PROGRAM, ("command", "read"))
    reads = table["read"] if isinstance(table["read"], list) else [table["read"]]
    readers = [_reader(one, f"program.read[{k}]", folder) for k, one in enumerate(reads, start=1)]
    where = {
        key: _path(folder, f"program.{key}", table[key])
        for key in ("template", "folder")
        if key in table
    }
    command = table["command"]
    with _at("program.command"):
        words = command if isinstance(command, list) else [command]
        here = folder / str(words[0] if isinstance(command, list) else command.split()[0])
        if isinstance(command, list) and here.is_file():
            command = [str(here), *command[1:]]
    with _at("program"):
        return Program(
            command,
            where.get("template"),
            readers,
            names=[i.name for i in inputs],
            whole=[i.name for i in inputs if i.whole],
            needed=[i.name for i in inputs if i.upper > i.lower],
            files=[_path(folder, "program.files", f) for f in _list(table.get("files", []))],
            folder=where.get("folder"),
            keep_runs=table.get("keep_runs", "failed"),
            timeout_s=runs.get("timeout_s"),
        )


def _list(value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise _Wrong(f"`program.files` is {shown(value)}; a list of files is allowed")
    return value


def _functions(table: Any, folder: Path) -> dict[str, Any]:
    _table(table, "function", _FUNCTION, ("run",))
    options = {key: table[key] for key in ("batched", "picture_unit") if key in table}
    for key in ("run", "gradient", "draw"):
        if key in table:
            with _at(f"function.{key}"):
                options[key] = function_named(key, table[key], folder)
    return options


def _options(document: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    _table(document, "", _TOP, ("inputs", "outputs"))
    if ("function" in document) == ("program" in document):
        raise _Wrong("`function` or `program` is needed, and not both")
    runs = dict(_table(document.get("runs", {}), "runs", _RUNS))
    if "keep" in runs:
        runs["keep"] = _path(folder, "runs.keep", runs["keep"])
    inputs = _all_of(Input, document["inputs"], "inputs", _INPUT)
    outputs = _all_of(Output, document["outputs"], "outputs", _OUTPUT)
    options: dict[str, Any] = {"inputs": inputs, "outputs": outputs, **runs}
    if "function" in document:
        options |= _functions(document["function"], folder)
    else:
        options["run"] = _program(document["program"], folder, inputs, runs)
    for key in ("correlation", "name"):
        if key in document:
            options[key] = document[key]
    return options


def read_model_file(path: Any, make: Callable[..., Any]) -> Any:
    """Return what `make` makes of the arguments of a `Model` in a file.

    Raises
    ------
    FileFormatError
        If the file cannot be used: one line with its name and the key.
    """
    name = file_name("path", path)
    folder = Path(name).resolve().parent
    try:
        document = parse_toml(read_text(name, LARGEST), LARGEST)
        made = make(**_options(document, folder))
        made.file = name
        return made
    except (_Wrong, KneecoreError) as error:
        raise FileFormatError(f"{shown_name(name)}: {error}") from None

r"""What a program has written, as the numbers that a model returns.

Examples
--------
>>> import tempfile, pathlib
>>> from kneecore.runs.readers import CsvOutput, JsonOutput, TextOutput
>>> folder = pathlib.Path(tempfile.mkdtemp())
>>> _ = (folder / "out.json").write_text('{"stress": {"max": 12.5, "at": [1, 2]}}')
>>> JsonOutput("out.json", "stress.max", "stress.at")(folder)
[12.5, 1.0, 2.0]
>>> _ = (folder / "out.csv").write_text("t,gain\n0,1.5\n1,2.5\n")
>>> CsvOutput("out.csv", "gain")(folder)
[1.5, 2.5]
>>> _ = (folder / "stdout.txt").write_text("f_1 = 3.2 Hz\nf_2 = 8 Hz\n")
>>> TextOutput("stdout.txt", r"f_\d = (\S+)")(folder)
[3.2, 8.0]
"""

import csv
import io
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from kneecore._arguments import shown, text
from kneecore._untrusted import parse_json, read_text
from kneecore.errors import FileFormatError, ParameterError

__all__ = ["CsvOutput", "JsonOutput", "Read", "TextOutput", "checked_read"]

Read = Callable[[Path], Any]
LARGEST = 256 << 20
"""Bytes of a file that a program has written."""


def _content(folder: Path, name: str) -> str:
    if not (folder / name).exists():
        raise FileFormatError(f"the program has not written {name}")
    try:
        return read_text(folder / name, LARGEST)
    except FileFormatError as error:
        raise FileFormatError(f"{name}: {error}") from None


def _name(file: Any) -> str:
    name = text("file", file, 300)
    if not name or Path(name).is_absolute() or ".." in Path(name).parts:
        raise ParameterError(f"`file` is {shown(file)}; a file in the run's folder is allowed")
    return name


def _number(value: Any, where: str) -> float:
    try:
        return float(value.strip() if isinstance(value, str) else value)
    except (TypeError, ValueError):
        raise FileFormatError(f"{where} is {shown(value)}; a number is needed") from None


class _Output:
    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in vars(self).items())})"


class JsonOutput(_Output):
    """Numbers, and lists of numbers, of a JSON file.

    Parameters
    ----------
    file : str
        In the run's folder.
    *keys : str
        Where they are, such as ``"stress.max"`` or ``"modes.0.frequency"``; in the order in which
        the model returns them.
    """

    def __init__(self, file: str, *keys: str) -> None:
        self.file = _name(file)
        self.keys = tuple(text("keys", key, 300) for key in keys)
        if not keys:
            raise ParameterError("`keys` is empty; at least one, such as 'stress.max', is needed")

    def __call__(self, folder: Path) -> list[float]:
        """Return the numbers."""
        content = _content(folder, self.file)
        try:
            document = parse_json(content, LARGEST)
        except FileFormatError as error:
            raise FileFormatError(f"{self.file}: {error}") from None
        numbers: list[float] = []
        for key in self.keys:
            value = self._at(document, key)
            values = value if isinstance(value, list) else [value]
            numbers += [_number(v, f"{key} in {self.file}") for v in values]
        return numbers

    def _at(self, document: Any, key: str) -> Any:
        for part in key.split("."):
            try:
                document = document[int(part) if isinstance(document, list) else part]
            except (KeyError, IndexError, ValueError, TypeError):
                raise FileFormatError(f"{self.file} has no key {key}") from None
        return document


class CsvOutput(_Output):
    """A column of a CSV file with a header line.

    Parameters
    ----------
    file : str
        In the run's folder.
    column : str
        Its name in the header.
    delimiter : str
        Between the columns.
    """

    def __init__(self, file: str, column: str, delimiter: str = ",") -> None:
        self.file, self.column = _name(file), text("column", column, 300)
        if not isinstance(delimiter, str) or len(delimiter) != 1:
            raise ParameterError(f"`delimiter` is {shown(delimiter)}; one character is allowed")
        self.delimiter = delimiter

    def __call__(self, folder: Path) -> list[float]:
        """Return the numbers, one a row."""
        try:
            rows = list(
                csv.reader(io.StringIO(_content(folder, self.file)), delimiter=self.delimiter)
            )
        except csv.Error as error:
            raise FileFormatError(f"{self.file}: {error}") from None
        head = [name.strip() for name in rows[0]] if rows else []
        if self.column not in head:
            raise FileFormatError(f"{self.file} has no column {self.column}")
        k = head.index(self.column)
        where = f"{self.column} in {self.file}"
        return [_number(row[k] if k < len(row) else None, where) for row in rows[1:] if row]


class TextOutput(_Output):
    """What a regular expression finds in a text file; ``stdout.txt`` is what was printed.

    Parameters
    ----------
    file : str
        In the run's folder.
    pattern : str
        Each group of each find is a number; without groups each find is one.
    """

    def __init__(self, file: str, pattern: str) -> None:
        self.file, self.pattern = _name(file), text("pattern", pattern, 2000)
        try:
            re.compile(pattern)
        except (re.error, RecursionError, OverflowError) as error:
            raise ParameterError(
                f"`pattern` is {shown(pattern)} ({error}); a regular expression is allowed"
            ) from None

    def __call__(self, folder: Path) -> list[float]:
        """Return the numbers, in the order of the text."""
        finds = re.finditer(self.pattern, _content(folder, self.file), re.MULTILINE)
        numbers = [
            _number(group, f"what {shown(self.pattern)} finds in {self.file}")
            for find in finds
            for group in (find.groups() or (find[0],))
        ]
        if not numbers:
            raise FileFormatError(f"nothing in {self.file} looks like {shown(self.pattern)}")
        return numbers


def checked_read(value: Any) -> tuple[Read, ...]:
    """Return how a program's output is read: one function of the run's folder, or several.

    Raises
    ------
    ParameterError
        If it is anything else.
    """
    several = list(value) if isinstance(value, Sequence) and not isinstance(value, str) else [value]
    if not several or not all(callable(one) for one in several):
        raise ParameterError(
            f"`read` is {shown(value)}; a function of the run's folder is allowed, such as "
            "kneecore.JsonOutput('out.json', 'stress.max'), or a list of them"
        )
    return tuple(several)

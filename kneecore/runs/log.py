"""A file of runs that were done: append-only, and read again before any of them is done anew.

The first line says what the file is. Each further line is one run as JSON: the model's digest, the
inputs, the outputs, what failed, and a check of the line itself. A line that was half written when
the study was killed is cut off; one that is damaged in the middle is left out and counted.
"""

import json
import math
import os
import threading
import zlib
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore._arguments import shown_name
from kneecore._locks import lock
from kneecore._untrusted import decoded, read_bytes
from kneecore.errors import FileFormatError, OutputError
from kneecore.runs.part import Trouble

__all__ = ["Kept", "RunLog"]

FloatArray = NDArray[np.float64]
SCHEMA = "kneecore.runs/1"
LARGEST = 4 << 30
"""Bytes of a file of runs: some ten million runs of thirty inputs and outputs."""
_CHECK = ',"check":"'
_ODD = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}


@dataclass(frozen=True)
class Kept:
    """One run of the file."""

    y: FloatArray
    trouble: Trouble | None


def _told(values: FloatArray) -> list[Any]:
    # repr gives back every bit of a float; JSON has no word for those that are no number.
    return [v if math.isfinite(v) else repr(v) for v in values.tolist()]


def _read(values: Sequence[Any]) -> FloatArray:
    return np.array([_ODD[v] if isinstance(v, str) else float(v) for v in values], dtype=float)


def _line(record: dict[str, Any]) -> bytes:
    text = json.dumps(record, separators=(",", ":"), allow_nan=False)
    return f'{text[:-1]}{_CHECK}{zlib.crc32(text.encode()):08x}"}}\n'.encode()


def _record(line: str) -> dict[str, Any] | None:
    """Return what a line says; None if it is not what was written."""
    text, found, check = line.rpartition(_CHECK)
    text += "}"
    if not found or check != f'{zlib.crc32(text.encode()):08x}"}}':
        return None
    record: dict[str, Any] = json.loads(text)
    return record


def _trouble(told: dict[str, Any] | None) -> Trouble | None:
    return None if told is None else Trouble(row=0, **told)


class RunLog:
    """The runs in a file, of one model.

    Parameters
    ----------
    path : str
    digest : str
        The model's: runs of others are left alone.
    rerun_failures : bool
        Whether runs that failed are not known.

    Raises
    ------
    FileFormatError
        If the file is something else.
    OutputError
        If it cannot be written, or another study writes to it.
    """

    def __init__(self, path: str, digest: str, *, rerun_failures: bool = False) -> None:
        self.path, self._digest = path, digest
        self.n_damaged = self.n_of_others = 0
        self._known: dict[bytes, Kept] = {}
        self._lock = threading.Lock()
        self._file = self._opened()
        try:
            self._load(rerun_failures)
        except BaseException:
            self.close()
            raise

    def _opened(self) -> int:
        flags = os.O_RDWR | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0)
        try:
            file = os.open(self.path, flags, 0o666)
        except (OSError, ValueError) as error:
            said = getattr(error, "strerror", None) or error
            raise OutputError(f"{shown_name(self.path)} cannot be written ({said})") from None
        if not lock(file):
            os.close(file)
            raise OutputError(
                f"{shown_name(self.path)} is written by another study; each needs its own file"
            )
        return file

    def _load(self, rerun_failures: bool) -> None:
        try:
            content = read_bytes(self.path, LARGEST)
        except FileFormatError as error:
            raise FileFormatError(f"{shown_name(self.path)}: {error}") from None
        whole, _, half = content.rpartition(b"\n")
        if not whole:
            if half and not _line({"schema": SCHEMA}).startswith(half):
                raise self._another()
            self._cut(0)
            self._append(_line({"schema": SCHEMA}))
            return
        try:
            lines = decoded(whole).split("\n")
        except FileFormatError:
            lines = whole.decode("utf-8", errors="replace").split("\n")
        head = _record(lines[0])
        if head is None or head.get("schema") != SCHEMA:
            raise self._another()
        if half:
            self._cut(len(whole) + 1)
        for line in lines[1:]:
            self._take(line, rerun_failures)

    def _another(self) -> FileFormatError:
        return FileFormatError(
            f"{shown_name(self.path)} is no file of runs ({SCHEMA}); a new file, or one that "
            "`keep` has written, is allowed"
        )

    def _take(self, line: str, rerun_failures: bool) -> None:
        record = _record(line)
        if record is None:
            self.n_damaged += 1
        elif record["model"] != self._digest:
            self.n_of_others += 1
        elif not (rerun_failures and record["failure"]):
            kept = Kept(_read(record["y"]), _trouble(record["failure"]))
            self._known[_read(record["x"]).tobytes()] = kept

    def __len__(self) -> int:
        return len(self._known)

    def get(self, x: FloatArray) -> Kept | None:
        """Return the run of a point (d,), if it is known."""
        return self._known.get(x.tobytes())

    def add(self, x: FloatArray, y: FloatArray, troubles: dict[int, Trouble]) -> None:
        """Keep the runs of points (n, d).

        Raises
        ------
        OutputError
            If the disk takes no more.
        """
        lines = []
        for row, (point, values) in enumerate(zip(x, y, strict=True)):
            trouble = troubles.get(row)
            told = None
            if trouble is not None:
                told = {k: v for k, v in vars(trouble).items() if k not in ("row", "error")}
                trouble = replace(trouble, row=0, error=None)
            record = {"model": self._digest, "x": _told(point), "y": _told(values), "failure": told}
            lines.append(_line(record))
            self._known[point.tobytes()] = Kept(values.copy(), trouble)
        self._append(b"".join(lines))

    def _append(self, content: bytes) -> None:
        with self._lock:
            try:
                while content:
                    content = content[os.write(self._file, content) :]
            except OSError as error:
                said = error.strerror or error
                raise OutputError(f"{shown_name(self.path)} cannot be written ({said})") from None

    def _cut(self, size: int) -> None:
        try:
            os.truncate(self.path, size)
        except OSError as error:
            said = error.strerror or error
            raise OutputError(f"{shown_name(self.path)} cannot be written ({said})") from None

    def write_traceback(self, number: int, text: str) -> str | None:
        """Write a failed run's traceback beside the file; return its name."""
        folder = Path(f"{self.path}.failures")
        name = folder / f"run_{number:06d}.txt"
        try:
            folder.mkdir(exist_ok=True)
            name.write_text(text, encoding="utf-8", errors="replace")
        except OSError:  # the runs themselves are kept; a full disk is told by those
            return None
        return str(name)

    def close(self) -> None:
        """Let others write to the file."""
        with suppress(OSError):
            os.close(self._file)

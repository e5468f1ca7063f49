"""What a command keeps of its work in its folder until it is done, to go on with after a stop.

The folder ``checkpoint`` holds ``runs``, to which what the model answered is appended, and a file
for the state of each longer step, replaced as a whole. Every file begins with a description of the
command, and every record carries a check of itself: what was half written when the process was
killed is left out, and computed again.
"""

import json
import logging
import os
import shutil
import threading
import time
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np

from kneecore.errors import OutputError
from kneecore.record import Arrays

__all__ = ["FOLDER", "Checkpoint"]

_LOG = logging.getLogger("kneecore")

FOLDER = "checkpoint"
SCHEMA = "kneecore.checkpoint/1"
INTERVAL_S = 1.0
"""How much work may be lost; nothing is written before, so that short work leaves no trace."""
LARGEST = 4 << 30
"""Bytes of runs: then no more are kept, rather than the disk filled."""
_KINDS = ("f8", "i8", "u1")


def _packed(head: Mapping[str, Any], arrays: Arrays) -> bytes:
    """Return a record: its length and check, a line of JSON, and the arrays' bytes."""
    shapes = {n: [a.dtype.str[1:], list(a.shape)] for n, a in arrays.items()}
    line = json.dumps({**head, "arrays": shapes}, separators=(",", ":")).encode() + b"\n"
    body = line + b"".join(np.ascontiguousarray(a).tobytes() for a in arrays.values())
    return len(body).to_bytes(8, "little") + zlib.crc32(body).to_bytes(4, "little") + body


def _unpacked(content: memoryview, at: int) -> tuple[dict[str, Any], Arrays, int] | None:
    """Return the record at a place and the place behind it; None if it is not whole."""
    size = int.from_bytes(content[at : at + 8], "little")
    body = content[at + 12 : at + 12 + size]
    check = int.from_bytes(content[at + 8 : at + 12], "little")
    if len(body) != size or size == 0 or zlib.crc32(body) != check:
        return None
    line = bytes(body).partition(b"\n")[0]
    head = json.loads(line)
    arrays, begin = {}, len(line) + 1
    for name, (kind, shape) in head.pop("arrays").items():
        if kind not in _KINDS:
            return None
        count = int(np.prod(shape, dtype=np.int64))
        arrays[name] = np.frombuffer(body, kind, count, begin).reshape(shape).copy()
        begin += arrays[name].nbytes
    return head, arrays, at + 12 + size


class Checkpoint:
    """What a command keeps of its work; see `kneecore.record.Record`.

    Parameters
    ----------
    folder : path
        The folder of the results, which is there.
    about : dict
        JSON-ready: all that the results depend on.
    resume : bool
        Whether what is kept there shall be used; otherwise it makes way.

    Raises
    ------
    OutputError
        If it shall be used, but belongs to something else.
    """

    def __init__(self, folder: str | Path, about: Mapping[str, Any], *, resume: bool) -> None:
        self.folder = Path(folder) / FOLDER
        self._about = {"schema": SCHEMA, **json.loads(json.dumps(about, default=str))}
        self._runs: dict[bytes, Arrays] = {}
        self._states: dict[str, Arrays] = {}
        self._due = time.monotonic() + INTERVAL_S
        self._waiting: list[bytes] = []
        self._lock = threading.Lock()
        self._size, self._broken = 0, False
        self.found = False
        """Whether there was something to go on with."""
        if resume:
            self._read()
        else:
            self.remove()

    # Reading.

    def _read(self) -> None:
        for path in sorted(self.folder.glob("*")):
            if path.name.endswith(".tmp"):
                continue
            try:
                content = memoryview(path.read_bytes())
            except OSError as error:
                raise OutputError(f"{path}: cannot be read ({error.strerror})") from None
            first = _unpacked(content, 0)
            if first is None:  # killed while its first record was written
                continue
            self._check(path, first[0])
            self.found = True
            self._take(path, content, first)

    def _check(self, path: Path, head: dict[str, Any]) -> None:
        if head == self._about:
            return
        names = sorted(k for k in {*head, *self._about} if head.get(k) != self._about.get(k))
        was, wanted = (_shortly(d.get(names[0])) for d in (head, self._about))
        raise OutputError(
            f"{path.parent} belongs to another run: its {names[0]} is {was}, here {wanted}; the "
            "same options with --resume, or --force to start anew, are allowed"
        )

    def _take(
        self, path: Path, content: memoryview, first: tuple[dict[str, Any], Arrays, int]
    ) -> None:
        at = first[2]
        while (record := _unpacked(content, at)) is not None:
            head, arrays, at = record
            if "key" in head:
                self._runs[bytes.fromhex(head["key"])] = arrays
            else:
                self._states[head["step"]] = arrays
        if path.name == "runs":
            self._size = at
            if at < len(content):
                with suppress(OSError):  # then no more is appended
                    os.truncate(path, at)
                    return
                self._broken = True

    # Keeping.

    def run(
        self, what: str, identity: bytes, given: Arrays, compute: Callable[[], Arrays]
    ) -> Arrays:
        """Return what `compute` returned earlier for the same model and arrays, or returns now."""
        digest = blake2b(what.encode() + b"\0" + identity, digest_size=16)
        for name, array in given.items():
            digest.update(f"\0{name}{array.shape}".encode())
            digest.update(np.ascontiguousarray(array).tobytes())
        key = digest.digest()
        found = self._runs.get(key)
        if found is not None:
            return found
        answer = compute()
        if not self._broken:
            self._waiting.append(_packed({"key": key.hex()}, answer))
            if time.monotonic() >= self._due:
                self.flush()
        return answer

    def load(self, step: str) -> Arrays | None:
        """Return the state in which a step was left, if it was begun."""
        return self._states.get(step)

    def save(self, step: str, state: Callable[[], Arrays], *, now: bool = False) -> None:
        """Keep a step's state, from time to time only unless it must be now."""
        if self._broken or not (now or time.monotonic() >= self._due):
            return
        content = _packed(self._about, {}) + _packed({"step": step}, state())
        with self._careful():
            path = self.folder / f"state_{blake2b(step.encode(), digest_size=8).hexdigest()}"
            staged = path.with_name(f"{path.name}.tmp")
            staged.write_bytes(content)
            os.replace(staged, path)
        self._due = time.monotonic() + INTERVAL_S

    def flush(self) -> None:
        """Write the runs that are not written yet."""
        with self._lock:
            self._flush()

    def _flush(self) -> None:
        waiting, self._waiting = self._waiting, []
        if self._broken or not waiting:
            return
        content = b"".join(waiting)
        if self._size == 0:
            content = _packed(self._about, {}) + content
        with self._careful(), open(self.folder / "runs", "ab") as file:
            file.write(content)
            self._size += len(content)
        if self._size > LARGEST:
            self._stop(f"its runs fill {LARGEST >> 30} GB already")
        self._due = time.monotonic() + INTERVAL_S

    @contextmanager
    def _careful(self) -> Iterator[None]:
        """Write what may fail: then what was kept before stays, and no more is."""
        try:
            self.folder.mkdir(exist_ok=True)
            yield
        except OSError as error:
            self._stop(error.strerror or str(error))

    def _stop(self, why: str) -> None:
        """Keep no more: the work itself goes on."""
        self._broken = True
        for half in self.folder.glob("*.tmp"):
            half.unlink(missing_ok=True)
        with suppress(OSError):  # only if nothing was kept before
            self.folder.rmdir()
        _LOG.warning("no more can be kept in %s (%s); going on without", self.folder, why)

    @property
    def is_kept(self) -> bool:
        """Whether something is there to go on with."""
        return self.folder.is_dir() and any(self.folder.iterdir())

    def remove(self) -> None:
        """Remove what was kept: the work is done."""
        self._waiting.clear()
        shutil.rmtree(self.folder, ignore_errors=True)


def _shortly(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}..."

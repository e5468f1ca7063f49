"""Uploaded files, parsed in a process of their own that is ended when it takes too long.

The limits on a file bound the work of its parser; but a thread cannot be stopped, and while it
parses it keeps all pages of the server waiting in turn. A process can, and keeps nobody waiting.

Run as ``python -m kneeviz.jobs.uploads NAME``: it takes the content on stdin and writes the object
on stdout.
"""

import contextlib
import os
import pickle
import subprocess
import sys
import threading
from typing import Any, NamedTuple

from kneecore import (
    FileFormatError,
    KneecoreError,
    KneeFile,
    ParameterError,
    SearchResult,
    parse_knee,
)
from kneeviz.jobs.messages import Post

DEADLINE = 15.0
"""s that a file may take; a large one takes half a second, and starting the process as long."""
AT_ONCE, MOST_WAITING = 2, 16
"""Processes of this server at the same time, and files that may wait for one."""
NAMELESS = "a file without a name"
_COMMAND = (sys.executable, "-m", "kneeviz.jobs.uploads")
_turns = threading.BoundedSemaphore(AT_ONCE)
_waiting = threading.BoundedSemaphore(MOST_WAITING)


class Uploaded(NamedTuple):
    """What became of an uploaded file."""

    name: str
    client_id: int
    loaded: KneeFile | SearchResult | None
    why: str | None
    """What is wrong with the file, if there is nothing in it."""


def parse(name: str, content: bytes) -> KneeFile | SearchResult:
    """Return the knee (TOML) or the result (JSON) in an uploaded file.

    The content decides, not the name, which comes from outside.

    Raises
    ------
    ParameterError
        If `name` is no text.
    FileFormatError
        If the file is neither, with the reason.
    """
    if not isinstance(name, str):
        raise ParameterError(f"`name` is {name!r}; the name of a file is allowed")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FileFormatError("not a text file in UTF-8") from None
    is_json = text.lstrip().startswith(("{", "[")) and not _looks_like_toml(text)
    if is_json or name.lower().endswith(".json"):
        return SearchResult.from_json(text)
    return parse_knee(text)


def _looks_like_toml(text: str) -> bool:
    # A table's header, "[parameters...]", also starts with a bracket.
    first = text.lstrip().splitlines()[0].strip()
    return first.startswith("[") and first.endswith("]") and not first.startswith(("[{", '["'))


def parse_apart(name: str, content: bytes) -> KneeFile | SearchResult:
    """Do as `parse`, in a process that is ended after `DEADLINE`.

    Raises
    ------
    KneecoreError
        As `parse`, and if it took too long or the process has failed.
    """
    with subprocess.Popen(
        [*_COMMAND, name.encode("ascii", "replace").replace(b"\0", b"").decode()],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
    ) as process:
        try:
            said, _ = process.communicate(content, timeout=DEADLINE)
        except subprocess.TimeoutExpired:
            raise FileFormatError(
                f"given up after {DEADLINE:g} s; a file of ours takes one"
            ) from None
        finally:
            process.kill()
    if process.returncode != 0:
        raise FileFormatError("it cannot be read; the process that tried has failed")
    found: KneeFile | SearchResult | KneecoreError = pickle.loads(said)  # of our own process
    if isinstance(found, KneecoreError):
        raise found
    return found


class Uploads:
    """Posts ("uploaded", client's number) with an `Uploaded` for the latest file of each client."""

    def __init__(self, post: Post) -> None:
        self._post = post
        self._latest: dict[int, object] = {}

    def read(self, name: str, content: bytes, client_id: int) -> bool:
        """Begin to read a file; a client's earlier one is dropped. False if too many wait."""
        if not _waiting.acquire(blocking=False):
            return False
        mark = self._latest[client_id] = object()

        def work() -> None:
            try:
                with _turns:
                    said = self._read(name, content, client_id)
            finally:
                _waiting.release()
            if self._latest.get(client_id) is mark:
                del self._latest[client_id]
                self._post(("uploaded", client_id), said)

        threading.Thread(target=work, name="upload", daemon=True).start()
        return True

    def stop(self) -> None:
        """Want none of them any more."""
        self._latest.clear()

    def _read(self, name: str, content: bytes, client_id: int) -> Uploaded:
        told = name or NAMELESS
        try:
            return Uploaded(told, client_id, parse_apart(name, content), None)
        except KneecoreError as error:
            return Uploaded(told, client_id, None, str(error))
        except Exception as error:
            return Uploaded(told, client_id, None, f"{type(error).__name__}: {error}")


def _main() -> None:
    found: Any
    if hasattr(os, "nice"):
        os.nice(5)  # the pages go first
    try:
        found = parse(sys.argv[1], sys.stdin.buffer.read())
    except KneecoreError as error:
        found = error
    with contextlib.suppress(BrokenPipeError):
        sys.stdout.buffer.write(pickle.dumps(found))
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    _main()

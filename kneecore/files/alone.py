"""A file that one process at a time writes."""

import contextlib
import os
from pathlib import Path

from kneecore._locks import lock
from kneecore.errors import OutputError

__all__ = ["Alone"]


class Alone:
    """The right to write a file, which nobody else has until it is given back.

    The file itself is replaced at each writing, so that a small one beside it is locked. It goes
    with the right; after a crash it stays and hinders nobody.

    Parameters
    ----------
    path : Path
        The file; it need not be there yet.
    name : str
        What the user has named it by.

    Raises
    ------
    OutputError
        If another has the right, or nothing can be written there.
    """

    def __init__(self, path: Path, name: str) -> None:
        self._path = path.with_name(f".{path.name}.lock")
        try:
            self._handle = self._locked()
        except BlockingIOError:
            raise OutputError(
                f"`{name}` is {str(path)!r}, to which another process is writing; "
                "another file is allowed"
            ) from None
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else str(error)
            raise OutputError(f"{path}: cannot be written ({reason})") from None

    def _locked(self) -> int:
        while True:
            handle = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o600)
            if not lock(handle):
                os.close(handle)
                raise BlockingIOError
            if self._is_there(handle):
                return handle
            os.close(handle)  # removed between opening and locking, by who gave back the right

    def _is_there(self, handle: int) -> bool:
        try:
            return os.path.samestat(os.stat(self._path), os.fstat(handle))
        except FileNotFoundError:
            return False

    def give_back(self) -> None:
        """Let others write."""
        if self._handle >= 0:
            with contextlib.suppress(OSError):  # where an open file cannot be removed, it stays
                self._path.unlink()
            os.close(self._handle)
            self._handle = -1

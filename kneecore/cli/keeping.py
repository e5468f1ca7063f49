"""What the long commands share: one writer of a folder, a checkpoint, and going on from it."""

import dataclasses
import hashlib
import os
import re
import shlex
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from kneecore._locks import lock
from kneecore.errors import OutputError, ParameterError

if TYPE_CHECKING:
    from kneecore.files.checkpoint import Checkpoint

__all__ = ["Keeping"]

_NOT_IN_THE_NUMBERS = frozenset(
    {"out", "force", "json", "quiet", "resume", "threads", "workers", "scheduler", "keep"}
)
_FILES = ("baseline", "result", "model")


class Keeping:
    """The folder of a command's files, from the first look to the last file.

    Use it as a context manager around the whole command; without ``--out`` it does nothing.

    Parameters
    ----------
    command : str
        Such as ``python -m kneecore.search``.
    options : dataclass
        With `out`, `force` and `resume`.
    arguments : sequence of str, optional
        What the command was started with; the process's own for None.
    """

    def __init__(self, command: str, options: Any, arguments: Sequence[str] | None) -> None:
        self._command, self._options = command, options
        self._arguments = sys.argv[1:] if arguments is None else list(arguments)
        self._lock: int | None = None
        self.checkpoint: Checkpoint | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_exception: object) -> None:
        if self.checkpoint is not None:
            self.checkpoint.flush()
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    @contextmanager
    def opened(self, holds: str) -> Iterator[None]:
        """Take the folder, and let what is computed within keep what it does.

        Parameters
        ----------
        holds : str
            The file that tells that a result is in the folder.

        Raises
        ------
        OutputError
            If the folder cannot be used, or belongs to another run.
        """
        from kneecore.record import recording

        if self._options.resume and self._options.out is None:
            raise ParameterError("`resume` needs `out`, the folder in which the run was stopped")
        if self._options.out is not None:
            self._take(holds)
        with recording(self.checkpoint):
            yield
            if self.checkpoint is not None:
                self.checkpoint.flush()

    def _take(self, holds: str) -> None:
        from kneecore.files.checkpoint import FOLDER, Checkpoint
        from kneecore.files.folder import prepare_folder

        out, resume, force = self._options.out, self._options.resume, self._options.force
        # Unlike a Path's, this takes any name; a wrong one is told below.
        begun, ended = (os.path.exists(os.path.join(out, name)) for name in (FOLDER, holds))
        if resume and ended and not begun:
            raise OutputError(
                f"`folder` is {out!r}, which holds a finished {holds}: nothing is left to go on "
                "with; another folder or --force is allowed"
            )
        if begun and not (resume or force):
            raise OutputError(
                f"`folder` is {out!r}, which holds the checkpoint of a run that was stopped; "
                "--resume to go on with it, or --force to start anew, is allowed"
            )
        folder = prepare_folder(out, force=force or begun, holds=holds)
        self._lock_out_others(folder)
        if not begun:  # one who wrote there until now has left his result
            prepare_folder(out, force=force, holds=holds)
        _remove_what_the_dead_left(folder)
        self.checkpoint = Checkpoint(folder, self._about(), resume=resume)

    def _lock_out_others(self, folder: Path) -> None:
        """Lock the folder itself: the lock leaves no file, and goes with the process."""
        if os.name != "posix":  # there, a folder cannot be opened
            return
        self._lock = os.open(folder, os.O_RDONLY)
        if not lock(self._lock):
            raise OutputError(
                f"`folder` is {str(folder)!r}, to which another process is writing; "
                "another folder is allowed"
            )

    def _about(self) -> dict[str, Any]:
        """Return all that the results depend on."""
        from kneecore._version import versions

        values = {
            f.name: getattr(self._options, f.name)
            for f in dataclasses.fields(self._options)
            if f.name not in _NOT_IN_THE_NUMBERS
        }
        for name in _FILES:
            if (path := values.get(name)) is not None:
                values[name] = _digest(Path(path))
        told = {name.replace("_", "-"): repr(value) for name, value in values.items()}
        return {
            "command": f"{self._command} {type(self._options).__name__}",
            **{f"--{name}": value for name, value in told.items()},
            "versions": dict(versions()),
        }

    def done(self) -> None:
        """Tell that all files are written: nothing is left to go on with."""
        if self.checkpoint is not None:
            self.checkpoint.remove()

    def way_on(self) -> str:
        """Return how to go on, as the end of a sentence; empty if nothing was kept."""
        if self.checkpoint is None:
            return ""
        self.checkpoint.flush()
        if not self.checkpoint.is_kept:
            return ""
        words = [w for w in self._arguments if w not in ("--resume", "--force")]
        return f"; to go on: {self._command} {shlex.join([*words, '--resume'])}"


def _digest(path: Path) -> str:
    path = path / "result.json" if path.is_dir() else path
    with suppress(OSError):  # it was read before: what it was is in the other options then
        return hashlib.sha256(path.read_bytes()).hexdigest()
    return str(path)


def _remove_what_the_dead_left(folder: Path) -> None:
    """Remove temporary files of processes that were killed while they wrote."""
    for path in folder.glob(".*.tmp"):
        owner = re.fullmatch(r"\..*\.(\d+)\.tmp", path.name)
        if owner and not _is_alive(int(owner[1])):
            with suppress(OSError):
                path.unlink()


def _is_alive(process: int) -> bool:
    if os.name != "posix":  # there, a signal of 0 would end it
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True

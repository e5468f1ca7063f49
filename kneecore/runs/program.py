"""An external program as a model's function: a folder a run, with its input and what it wrote."""

import inspect
import os
import shlex
import shutil
import subprocess
import tempfile
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from kneecore._arguments import choice, file_name, shown, shown_name
from kneecore._untrusted import read_text
from kneecore.errors import FileFormatError, KneecoreError, ParameterError
from kneecore.runs.processes import end, forget, started
from kneecore.runs.readers import checked_read
from kneecore.runs.template import fields_in, filled
from kneecore.runs.work import RunFailed

__all__ = ["KeepRuns", "Program"]

FloatArray = NDArray[np.float64]
KeepRuns = Literal["failed", "all", "none"]
LARGEST_TEMPLATE = 64 << 20
OUT, ERR = "stdout.txt", "stderr.txt"
"""Where a run's folder has what the program printed."""


def _command(given: Any) -> tuple[str, ...]:
    try:
        words = shlex.split(given) if isinstance(given, str) else list(given)
    except (TypeError, ValueError):
        words = []
    if not words or not all(isinstance(word, str) and "\0" not in word for word in words):
        raise ParameterError(
            f"`command` is {shown(given)}; a program and its arguments are allowed, such as "
            "['solver', '{input}']"
        )
    # A program that is named by a path is found from where it was named, not from a run's folder.
    if os.sep in words[0] and os.path.exists(words[0]):
        words[0] = os.path.abspath(words[0])
    return tuple(words)


class Program:
    """Runs an external program for one point.

    Each run has a folder of its own, which is the program's working folder: the template, filled
    in; the program's output; what it printed, as ``stdout.txt`` and ``stderr.txt``. No shell is
    involved.

    Parameters
    ----------
    command : str or sequence of str
        The program and its arguments; ``{input}`` stands for the filled template, ``{folder}`` for
        the run's folder, and fields such as ``{k_1}`` for inputs.
    template : str or path, optional
        The input file with fields; without one all fields are in the command. Its copy in the run's
        folder has its name, less ``.template``.
    read : callable or sequence of callables
        What the run's folder (a `Path`) holds, as numbers.
    names : sequence of str
        The inputs in the order of a point.
    whole : sequence of str
        Those that are whole numbers, and are written so.
    needed : sequence of str
        Those that must have a field.
    files : sequence of str or path
        What else is copied to each run's folder.
    folder : str or path, optional
        Where the runs' folders are; the system's place for temporary files for None.
    keep_runs : {"failed", "all", "none"}
        Which of them stay.
    timeout_s : float, optional
        After which a run, with all that it has started, is ended.

    Raises
    ------
    ParameterError
        If an argument is not allowed, or an input has no field.
    FileFormatError
        If the template cannot be read.
    """

    def __init__(
        self,
        command: str | Sequence[str],
        template: str | os.PathLike[str] | None,
        read: Any,
        *,
        names: Sequence[str],
        whole: Sequence[str] = (),
        needed: Sequence[str],
        files: Sequence[str | os.PathLike[str]] = (),
        folder: str | os.PathLike[str] | None = None,
        keep_runs: KeepRuns = "failed",
        timeout_s: float | None = None,
    ) -> None:
        self.command = _command(command)
        self.names, self.timeout_s = tuple(names), timeout_s
        self.whole = frozenset(whole)
        self.read = checked_read(read)
        self.keep_runs = choice("keep_runs", keep_runs, get_args(KeepRuns))
        self.files = tuple(os.path.abspath(file_name("files", file)) for file in files)
        self.folder = None if folder is None else os.path.abspath(file_name("folder", folder))
        self.template, self.input_name = self._read_template(template)
        self._check_fields(needed)
        self._running: set[subprocess.Popen[bytes]] = set()
        self._lock = threading.Lock()

    @staticmethod
    def _read_template(template: Any) -> tuple[str | None, str]:
        if template is None:
            return None, ""
        path = file_name("template", template)
        try:
            content = read_text(path, LARGEST_TEMPLATE)
        except FileFormatError as error:
            raise FileFormatError(f"`template` {shown_name(path)}: {error}") from None
        return content, Path(path).name.removesuffix(".template")

    def _check_fields(self, needed: Sequence[str]) -> None:
        found = fields_in("\n".join([*self.command, self.template or ""]), self.names, self.whole)
        missing = [name for name in needed if name not in found]
        if missing:
            raise ParameterError(
                f"`template` has no field for {missing[0]!r}; each uncertain input needs one, such "
                f"as {{{missing[0]}}}, there or in the command"
            )
        for file in self.files:
            if not os.path.exists(file):
                raise ParameterError(f"`files` has {shown_name(file)}, which is not there")

    def __getstate__(self) -> dict[str, Any]:
        """Leave behind what is running."""
        return {k: v for k, v in vars(self).items() if k not in ("_running", "_lock")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._running, self._lock = set(), threading.Lock()

    def identity(self) -> list[str]:
        """Return what tells its runs from another program's."""
        sources = []
        for one in self.read:
            with suppress(OSError, TypeError):
                sources.append(inspect.getsource(one))
            if not inspect.isroutine(one):
                sources.append(repr(one))
        return ["program", *self.command, self.template or "", self.input_name, *sources]

    def __call__(self, x: FloatArray) -> FloatArray:
        """Return the outputs for one point (d,).

        Raises
        ------
        RunFailed
            If the program fails, takes too long, or does not write what is to be read.
        """
        folder = self._made_folder()
        values = dict(zip(self.names, x.tolist(), strict=True))
        values |= {name: int(values[name]) for name in self.whole}
        try:
            self._fill(folder, values)
            self._run(folder, values)
            numbers = self._numbers(folder)
        except RunFailed:
            if self.keep_runs == "none":
                shutil.rmtree(folder, ignore_errors=True)
            raise
        if self.keep_runs != "all":
            shutil.rmtree(folder, ignore_errors=True)
        return numbers

    def _made_folder(self) -> Path:
        try:
            if self.folder is None:
                return Path(tempfile.mkdtemp(prefix="kneecore-run-"))
            os.makedirs(self.folder, exist_ok=True)
            return Path(tempfile.mkdtemp(prefix="run_", dir=self.folder))
        except OSError as error:
            said = error.strerror or error
            raise RunFailed(f"could not make a folder for the run ({said})") from None

    def _failed(self, message: str, folder: Path, kind: str = "raised") -> RunFailed:
        kept = None if self.keep_runs == "none" else str(folder)
        return RunFailed(" ".join(message.split())[:500], kept, kind)

    def _fill(self, folder: Path, values: Mapping[str, float]) -> None:
        try:
            for file in self.files:
                copy = shutil.copytree if os.path.isdir(file) else shutil.copy2
                copy(file, folder / os.path.basename(file))
            if self.template is not None:
                content = filled(self.template, values)
                (folder / self.input_name).write_text(content, encoding="utf-8", newline="")
        except OSError as error:
            raise self._failed(f"could not lay its input ({error})", folder) from None

    def _words(self, folder: Path, values: Mapping[str, float]) -> list[str]:
        own = {"{input}": str(folder / self.input_name), "{folder}": str(folder)}
        words = [filled(word, values) for word in self.command]
        for mark, value in own.items():
            words = [word.replace(mark, value) for word in words]
        return words

    def _run(self, folder: Path, values: Mapping[str, float]) -> None:
        words = self._words(folder, values)
        with open(folder / OUT, "wb") as out, open(folder / ERR, "wb") as err:
            try:
                process = started(
                    words, cwd=folder, stdin=subprocess.DEVNULL, stdout=out, stderr=err
                )
            except OSError as error:
                said = error.strerror or error
                raise self._failed(f"could not start {words[0]} ({said})", folder) from None
            with self._lock:
                self._running.add(process)
            try:
                code = process.wait(self.timeout_s)
            except subprocess.TimeoutExpired:
                raise self._failed(
                    f"took longer than {self.timeout_s:g} s", folder, "timed out"
                ) from None
            finally:
                self._leave(process)
        if code:
            said = self._last_line(folder / ERR) or self._last_line(folder / OUT)
            told = f": {said}" if said else ""
            how = f"signal {-code}" if code < 0 else f"exit code {code}"
            raise self._failed(f"ended with {how}{told}", folder)

    def _leave(self, process: "subprocess.Popen[bytes]") -> None:
        with self._lock:
            self._running.discard(process)
        if process.returncode is None:
            end(process)
        else:
            forget(process)

    @staticmethod
    def _last_line(file: Path) -> str:
        with suppress(OSError), open(file, "rb") as stream:
            stream.seek(0, os.SEEK_END)
            stream.seek(max(stream.tell() - 2000, 0))
            lines = stream.read().decode("utf-8", errors="replace").split("\n")
            return next((line.strip()[:200] for line in reversed(lines) if line.strip()), "")
        return ""

    def _numbers(self, folder: Path) -> FloatArray:
        try:
            found = [np.atleast_1d(np.asarray(read(folder), dtype=float)) for read in self.read]
            return np.concatenate(found)
        except KneecoreError as error:
            raise self._failed(str(error), folder) from None
        except Exception as error:  # whatever a stranger's function raises
            told = f"could not be read ({type(error).__name__}: {error})"
            raise self._failed(told, folder) from error

    def stop_programs(self) -> None:
        """End all runs that are on their way."""
        with self._lock:
            running = list(self._running)
        for process in running:
            end(process)

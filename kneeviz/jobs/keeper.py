"""Keeps the latest state of a page in a file, off the page's own thread."""

import threading
from collections.abc import Callable
from pathlib import Path

from kneecore import KneecoreError
from kneecore.files.folder import write_file

_BETWEEN = 0.5  # s between two writes: a slider in motion is not worth twenty a second


class Keeper:
    """Writes what it was given last, whole or not at all.

    Parameters
    ----------
    path : Path
        The file; what was there is replaced.
    failed : callable
        Told, once for each run of failures, why the file cannot be written.
    """

    def __init__(self, path: Path, failed: Callable[[str], None]) -> None:
        self._path, self._failed = path, failed
        self._latest: Callable[[], str] | None = None
        self._news, self._ended = threading.Event(), threading.Event()
        self._writes = threading.Lock()
        self._told = False
        self._thread = threading.Thread(target=self._run, name="keeper", daemon=True)
        self._thread.start()

    def keep(self, text: Callable[[], str]) -> None:
        """Have `text()` written soon; it is called on another thread."""
        self._latest = text
        self._news.set()

    def stop(self) -> None:
        """Write what has not been written yet, and end."""
        self._ended.set()
        self._news.set()
        self._write()

    def _run(self) -> None:
        while not self._ended.is_set():
            self._news.wait()
            self._news.clear()
            self._write()
            self._ended.wait(_BETWEEN)

    def _write(self) -> None:
        with self._writes:
            text, self._latest = self._latest, None
            if text is None:
                return
            try:
                write_file(self._path, text().encode())
                self._told = False
            except KneecoreError as error:
                if not self._told:
                    self._failed(str(error))
                self._told = True

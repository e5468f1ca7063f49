"""The file in which the state of the shared page outlives the server."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from kneecore import KneecoreError
from kneecore.files.alone import Alone
from kneecore.files.folder import write_file
from kneeviz.jobs.keeper import Keeper
from kneeviz.page.loop import Loop


class KeptState:
    """A state's file: read once, and written by this server alone.

    Parameters
    ----------
    path : path
        The file; it need not be there yet.
    read : callable
        Reads it, for the kind of page that there is.

    Raises
    ------
    FileFormatError
        If it cannot be read.
    OutputError
        If another server writes it, or it cannot be written.
    """

    def __init__(self, path: str | Path, read: Callable[[Path], Any]) -> None:
        self._path = Path(path)
        self._alone = Alone(self._path, "state")
        self._keeper: Keeper | None = None
        try:
            self._left = read(self._path) if self._path.exists() else None
        except KneecoreError:
            self._alone.give_back()
            raise

    def follow(self, session: Loop[Any]) -> None:
        """Open a page as it was left, and keep its state from now on.

        Raises
        ------
        FileFormatError
            If the page has no such settings.
        OutputError
            If the file cannot be written.
        """
        if self._left is not None:
            session.open_as_left(self._left)
        write_file(self._path, session.told(session.page.snapshot()).encode())
        self._keeper = Keeper(self._path, lambda why: session.post("not_kept", why))
        keep = self._keeper.keep
        session.page.keep = lambda state: keep(lambda: session.told(state))

    def stop(self) -> None:
        """Write what has not been written yet, and let others write."""
        if self._keeper is not None:
            self._keeper.stop()
        self._alone.give_back()

"""The file in which the state of the shared page outlives the server."""

from pathlib import Path

from kneecore import KneecoreError
from kneecore.files.alone import Alone
from kneecore.files.folder import write_file
from kneeviz.actions import undo
from kneeviz.jobs.keeper import Keeper
from kneeviz.server.session import Session
from kneeviz.state import saved
from kneeviz.state.snapshot import Snapshot


class KeptState:
    """A state's file: read once, and written by this server alone.

    Parameters
    ----------
    path : path
        The file; it need not be there yet.

    Raises
    ------
    FileFormatError
        If it cannot be read.
    OutputError
        If another server writes it, or it cannot be written.
    """

    def __init__(self, path: str | Path) -> None:
        self._path = Path(path)
        self._alone = Alone(self._path, "state")
        self._keeper: Keeper | None = None
        try:
            self._left = saved.read(path) if self._path.exists() else None
        except KneecoreError:
            self._alone.give_back()
            raise

    def follow(self, session: Session) -> None:
        """Open a page as it was left, and keep its state from now on.

        Raises
        ------
        FileFormatError
            If the page has no such settings.
        OutputError
            If the file cannot be written.
        """
        if self._left is not None:
            undo.open_as_left(session.page, self._left)
        write_file(self._path, saved.to_text(session.page.snapshot()).encode())
        self._keeper = Keeper(self._path, lambda why: session.post("not_kept", why))
        session.page.keep = self._keep

    def _keep(self, state: Snapshot) -> None:
        assert self._keeper is not None
        self._keeper.keep(lambda: saved.to_text(state))

    def stop(self) -> None:
        """Write what has not been written yet, and let others write."""
        if self._keeper is not None:
            self._keeper.stop()
        self._alone.give_back()

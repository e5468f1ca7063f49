"""How a tab shows that something long runs."""

from typing import Any, Protocol


class Runs(Protocol):
    """A tab with buttons that start long work."""

    runs: dict[str, Any]
    progress: Any
    cancel: Any


def show_running(tab: Runs, running: bool) -> None:
    """Shut the buttons and open *Cancel*, or the other way round.

    What stands there is never hidden: nothing below it may move under a pointer.
    """
    for handle in tab.runs.values():
        handle.disabled = running
    tab.cancel.disabled = not running
    tab.progress.value = 0.0

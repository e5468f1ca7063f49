"""How a tab shows that something long runs."""

from typing import Any, Protocol


class Runs(Protocol):
    """A tab with buttons that start long work."""

    runs: dict[str, Any]
    progress: Any
    cancel: Any


def show_running(tab: Runs, running: bool) -> None:
    """Show the progress and shut the buttons, or the other way round."""
    for handle in tab.runs.values():
        handle.disabled = running
    tab.progress.visible = tab.cancel.visible = running
    if running:
        tab.progress.value = 0.0

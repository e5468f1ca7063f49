"""What a key does on a model's page that no single widget does. Runs on the session's worker."""

from collections.abc import Callable

from kneeviz.anymodel.actions import search, study
from kneeviz.anymodel.page import ModelPage
from kneeviz.jobs.messages import Asked


def _dark(page: ModelPage, value: Asked) -> None:
    set_dark(page, bool(value.value))


def set_dark(page: ModelPage, dark: bool) -> None:
    """Change between the light and the dark theme."""
    if page.view.dark_box.value != dark:
        page.view.dark_box.value = dark
    page.view.repaint(dark)
    _write_all(page)


def _large(page: ModelPage, value: Asked) -> None:
    set_large(page, bool(value.value))


def set_large(page: ModelPage, large: bool) -> None:
    """Show everything large, for a class, or at a desk's size."""
    if page.view.large_box.value != large:
        page.view.large_box.value = large
    page.view.resize(large)
    _write_all(page)


def _write_all(page: ModelPage) -> None:
    """Write and draw what has the theme's colours and sizes."""
    search.write_result(page)
    study.write_influence(page)
    study.draw_landscape(page)
    page.touched = True


def _toggle(page: ModelPage, value: Asked, what: str) -> None:
    """Turn round what is on or off."""
    if what == "dark":
        set_dark(page, not page.view.dark)
    elif what == "large":
        set_large(page, not page.view.large)
    elif page.state.result is None:
        page.notices.tell(value.client_id, "Not now", "No search has been made yet.")
    else:
        search.set_overlay(page, not page.state.overlay)


def _cancel(page: ModelPage, value: Asked) -> None:
    """Cancel whatever runs: a run, the learning, a search or a study."""
    if page.state.job is not None:
        page.state.job.cancel()
    elif page.told_running:
        page.runs.cancel()
    else:
        page.notices.tell(value.client_id, "Nothing to cancel", "Nothing is running.")


ACTIONS: dict[str, Callable[..., None]] = {
    "dark": _dark,
    "large": _large,
    "toggle": _toggle,
    "cancel": _cancel,
}

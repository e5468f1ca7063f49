"""What a key does that no single widget does. Runs on the session's worker."""

from collections.abc import Callable

from kneeviz.actions import ghosts, live, view
from kneeviz.jobs.messages import Asked
from kneeviz.page.page import Page


def _toggle(page: Page, value: Asked, what: str) -> None:
    """Turn round what is on or off."""
    if what == "overlay":
        _toggle_overlay(page, value.client_id)
    elif what == "live":
        live.set_live(page, not page.live.on)
    elif what == "forces":
        view.set_forces(page, not page.view.scene.forces)
    elif what == "beside":
        view.set_beside(page, not page.beside)
    elif what == "ghosts":
        ghosts.show_ghosts(page, not page.keeps_ghosts)
    elif what == "dark":
        view.set_dark(page, not page.view.dark)


def _toggle_overlay(page: Page, client_id: int) -> None:
    if page.state.result is None:
        page.notices.tell(client_id, "Not now", "No search has been made yet.")
    else:
        view.set_overlay(page, not page.overlay)


def _step(page: Page, value: Asked) -> None:
    """Move the position by per cent of its way."""
    view.set_playing(page, False)
    page.playback.set_share(page.playback.share + 0.01 * float(value.value))


ACTIONS: dict[str, Callable[..., None]] = {"toggle": _toggle, "step": _step}

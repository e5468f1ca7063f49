"""A pointer over a chart: the knee stands as the curve says there. Runs on the session's worker."""

import math
from collections.abc import Callable

from kneeviz.geometry.sweep import Sweep
from kneeviz.jobs.messages import Asked
from kneeviz.page.page import Page
from kneeviz.state.pointing import Pointing


def _point(page: Page, value: Asked, what: str) -> None:
    """Pose the paused knee at a moment (N m) or an angle (deg) until the pointer leaves."""
    sweep, pointing, playback = _still_sweep(page), page.pointing, page.playback
    if sweep is None or not _may_point(page, value.client_id):
        return
    stands = pointing is not None and pointing.shown == playback.phase
    before = pointing.before if pointing is not None and stands else playback.phase
    place = float(value.value)
    share = sweep.share_at(place) if what == "moment" else sweep.share_bent(math.radians(place))
    playback.set_share(share)
    page.pointing = Pointing(client_id=value.client_id, before=before, shown=playback.phase)


def _still_sweep(page: Page) -> Sweep | None:
    """Return the visitor's knee through the loads, if nothing moves it now."""
    current, playback = page.state.current, page.playback
    if playback.playing or playback.mode != "sweep" or page.animation.gliding:
        return None
    return None if current is None else current.sweep


def _may_point(page: Page, client_id: int) -> bool:
    """Tell whether no other visitor points: who came first has it until he leaves."""
    pointing = page.pointing
    return (
        pointing is None
        or pointing.client_id == client_id
        or pointing.client_id not in page.clients()
    )


def _left(page: Page, value: Asked) -> None:
    """Put the knee back where it was, unless somebody has moved it on since."""
    pointing, playback = page.pointing, page.playback
    if pointing is None or pointing.client_id != value.client_id:
        return
    page.pointing = None
    if not playback.playing and playback.phase == pointing.shown:
        playback.phase = pointing.before


def _keep(page: Page, value: Asked) -> None:
    """Leave the knee where the pointer has put it."""
    if page.pointing is not None and page.pointing.client_id == value.client_id:
        page.pointing = None


ACTIONS: dict[str, Callable[..., None]] = {
    "point": _point,
    "point_left": _left,
    "point_keep": _keep,
}

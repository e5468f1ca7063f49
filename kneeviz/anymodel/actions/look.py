"""How a model's page looks: theme, cameras, charts. Runs on the session's worker."""

from collections.abc import Callable
from typing import Any

import viser

from kneeviz import viser_internals
from kneeviz.anymodel.frame import CENTRE
from kneeviz.anymodel.page import ModelPage
from kneeviz.geometry import surfaces
from kneeviz.jobs.messages import Asked
from kneeviz.views.scene import camera

_NARROW = 700
"""px; no window that has room for charts beside the controls."""


def camera_position() -> tuple[float, float, float]:
    """Return where the camera stands: in front of the picture."""
    return CENTRE[0], CENTRE[1], float(camera.DISTANCE)


def place_cameras(page: ModelPage, only: int | None = None) -> None:
    """Put the cameras of all clients, or of one, where the view wants them."""
    for client_id, client in page.clients().items():
        if only in (None, client_id):
            _place_camera(page, client)


def _place_camera(page: ModelPage, client: viser.ClientHandle) -> None:
    landscape = page.state.landscape_shown
    viser_internals.set_camera_lock(client, locked=False)
    with client.atomic():
        client.camera.up_direction = (0.0, 1.0, 0.0)
        client.camera.position = camera.landscape_position() if landscape else camera_position()
        client.camera.look_at = surfaces.CENTRE if landscape else CENTRE
    client.flush()
    if not landscape:
        viser_internals.set_camera_lock(client, locked=True)


def _joined(page: ModelPage, _value: Any, client_id: int) -> None:
    client = page.clients().get(client_id)
    if client is not None:
        _place_camera(page, client)
        viser_internals.watch_charts(client)
        _fit_charts(page, client)


def _fit_charts(page: ModelPage, client: viser.ClientHandle) -> None:
    """Fit charts without a picture into the latest window: its first word is how wide it is."""
    width = client.camera.image_width  # or, if it came late, what is left between the panels
    if not page.view.has_picture and not page.state.landscape_shown and width > _NARROW:
        page.view.fit_wide(width)


def _reset_view(page: ModelPage, value: Asked) -> None:
    page.frame = None
    place_cameras(page, only=value.client_id)
    page.touched = True


def _chart(page: ModelPage, _value: Any) -> None:
    page.view.charts.show_chosen()
    page.touched = True


ACTIONS: dict[str, Callable[..., None]] = {
    "joined": _joined,
    "reset_view": _reset_view,
    "chart": _chart,
}

"""What a session does with motion and looks. Runs on its worker."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from kneeviz import viser_internals as wire
from kneeviz.actions.result import show_result
from kneeviz.geometry import surfaces as landscape
from kneeviz.views.scene import knee as scene
from kneeviz.views.scene import landscape as landscape_scene
from kneeviz.views.tabs import controls

if TYPE_CHECKING:
    from kneeviz.server.session import Session


def _play(session: "Session", value: Any) -> None:
    set_playing(session, value.value == "Play")


def set_playing(session: "Session", playing: bool) -> None:
    """Start or pause the motion."""
    session.stop_glide()
    session.playback.play(playing)


def _position(session: "Session", value: Any) -> None:
    set_playing(session, False)
    session.playback.set_share(float(value.value) / 100.0)


def _mode(session: "Session", value: Any) -> None:
    set_mode(session, controls.MODES[value.value])


def set_mode(session: "Session", mode: str) -> None:
    """Choose between the motion through the loads and the runs in time."""
    session.stop_glide()
    session.playback.set_mode(mode)
    session.forget_runs()
    label = next(text for text, name in controls.MODES.items() if name == mode)
    if session.view.look.mode.value != label:
        session.view.look.mode.value = label


def _speed(session: "Session", value: Any) -> None:
    session.playback.speed = float(value.value)


def _loop(session: "Session", value: Any) -> None:
    session.playback.loop = bool(value.value)


def _view(session: "Session", value: Any) -> None:
    view = session.view.scene
    if session.landscape.shown and value.value != "Reset":
        leave_landscape(session)
    if value.value == "Reset":
        place_cameras(session, only=value.client_id)
        return
    spatial = value.value == "3D"
    if spatial != view.spatial:
        view.spatial = spatial
        view.repaint()
        session.touch()
    place_cameras(session)


def leave_landscape(session: "Session") -> None:
    """Put the knee back in the landscape's place; the cameras are the caller's."""
    session.landscape.shown = False
    view = session.view
    if view.landscape is not None:
        view.landscape.set_visible(False)
    view.scene.set_hidden(False)
    view.study.show_landscape(False)
    session.touch()


def place_cameras(session: "Session", only: int | None = None) -> None:
    """Put the cameras of all clients, or of one, where the view wants them."""
    for client_id, client in session.clients().items():
        if only in (None, client_id):
            _place_camera(session, client, *_camera(session))


def restore_cameras(session: "Session") -> None:
    """Put the cameras back to where they were before the landscape."""
    for client_id, client in session.clients().items():
        kept = session.landscape.cameras.get(client_id, _camera(session))
        _place_camera(session, client, *kept)


def _camera(session: "Session") -> tuple[Any, Any]:
    """Return where the view wants a camera to stand, and to look."""
    if session.landscape.shown:
        return landscape_scene.camera_position(), landscape.CENTRE
    return scene.camera_position(session.view.scene.spatial), scene.CENTRE


def _place_camera(session: "Session", client: Any, position: Any, look_at: Any) -> None:
    """Put one client's camera somewhere, and lock or free its turning."""
    wire.set_camera_lock(client, locked=False)
    with client.atomic():
        client.camera.up_direction = (0.0, 1.0, 0.0)
        client.camera.position = position
        client.camera.look_at = look_at
    client.flush()
    if not (session.view.scene.spatial or session.landscape.shown):
        wire.set_camera_lock(client, locked=True)


def _joined(session: "Session", _value: Any, client_id: int) -> None:
    client = session.clients().get(client_id)
    if client is not None:
        _place_camera(session, client, *_camera(session))
        wire.watch_charts(client)


def _dark(session: "Session", value: Any) -> None:
    session.view.repaint(session.target.gui, bool(value.value))
    session.show_legends()
    show_result(session)
    session.touch()


def _forces(session: "Session", value: Any) -> None:
    set_forces(session, bool(value.value))


def set_forces(session: "Session", shown: bool) -> None:
    """Write tensions beside the ligaments' names, or not."""
    session.view.scene.forces = shown
    if session.view.look.forces.value != shown:
        session.view.look.forces.value = shown


def _overlay(session: "Session", value: Any) -> None:
    session.show_overlay(bool(value.value))


def set_overlay(session: "Session", shown: bool) -> None:
    """Show or hide both worst cases, and let the box agree."""
    if session.view.search.overlay.value != shown:
        session.view.search.overlay.value = shown
    session.show_overlay(shown)


DEEDS: dict[str, Callable[..., None]] = {
    "play": _play,
    "position": _position,
    "mode": _mode,
    "speed": _speed,
    "loop": _loop,
    "view": _view,
    "joined": _joined,
    "dark": _dark,
    "forces": _forces,
    "overlay": _overlay,
}

"""Motion, cameras and looks. Runs on the session's worker."""

import time
from collections.abc import Callable

from kneeviz import viser_internals
from kneeviz.jobs.messages import Asked
from kneeviz.page.page import Page
from kneeviz.views.tabs.look import MODES

_CROSSING_SECONDS = 0.5
"""For so long may what we set the position slider to be on its way to a browser whose visitor has
moved it meanwhile: then his value must follow, or his slider stays at ours."""


def _play(page: Page, _value: Asked) -> None:
    set_playing(page, not page.playback.playing)


def set_playing(page: Page, playing: bool) -> None:
    """Start or pause the motion."""
    page.animation.stop_glide()
    page.playback.play(playing)


def _position(page: Page, value: Asked) -> None:
    set_playing(page, False)
    page.playback.set_share(float(value.value) / 100.0)
    handle = page.view.transport.position
    if time.monotonic() - page.mirrored_at < _CROSSING_SECONDS:
        handle.value = value.value
        viser_internals.force_value(page.target.gui, handle)


def _mode(page: Page, value: Asked) -> None:
    set_mode(page, MODES[value.value])


def set_mode(page: Page, mode: str) -> None:
    """Choose between the motion through the loads and the runs in time."""
    page.animation.stop_glide()
    page.playback.set_mode(mode)
    page.motion.forget()
    label = next(text for text, name in MODES.items() if name == mode)
    if page.view.look.mode.value != label:
        page.view.look.mode.value = label


def _speed(page: Page, value: Asked) -> None:
    page.playback.speed = float(value.value)


def _loop(page: Page, value: Asked) -> None:
    page.playback.loop = bool(value.value)


def _view(page: Page, value: Asked) -> None:
    view = page.view.scene
    if page.landscape.shown and value.value != "Reset":
        leave_landscape(page)
    if value.value == "Reset":
        page.framing.reset(page.subject, time.monotonic(), only=value.client_id)
        return
    spatial = value.value == "3D"
    if spatial != view.spatial:
        view.spatial = spatial
        view.repaint()
        page.touched = True
    page.framing.reset(page.subject, time.monotonic())


def leave_landscape(page: Page) -> None:
    """Put the knee back in the landscape's place; the cameras are the caller's."""
    page.landscape.shown = False
    view = page.view
    if view.landscape is not None:
        view.landscape.set_visible(False)
    view.scene.set_hidden(False)
    view.study.show_landscape(False)
    page.touched = True


def _dark(page: Page, value: Asked) -> None:
    set_dark(page, bool(value.value))


def set_dark(page: Page, dark: bool) -> None:
    """Change between the light and the dark theme."""
    page.view.repaint(page.target.gui, dark)
    if page.view.look.dark.value != dark:
        page.view.look.dark.value = dark


def _large(page: Page, value: Asked) -> None:
    page.view.resize(page.target.gui, bool(value.value))
    page.touched = True


def _forces(page: Page, value: Asked) -> None:
    set_forces(page, bool(value.value))


def set_forces(page: Page, shown: bool) -> None:
    """Write tensions beside the ligaments' names, or not."""
    page.view.scene.forces = shown
    if page.view.look.forces.value != shown:
        page.view.look.forces.value = shown


def _overlay(page: Page, value: Asked) -> None:
    page.show_overlay(bool(value.value))


def set_overlay(page: Page, shown: bool) -> None:
    """Show or hide both worst cases, and let the box agree."""
    if page.view.search.overlay.value != shown:
        page.view.search.overlay.value = shown
    page.show_overlay(shown)


def _beside(page: Page, value: Asked) -> None:
    set_beside(page, bool(value.value))


def set_beside(page: Page, beside: bool) -> None:
    """Let both worst cases stand beside the visitor's knee, or over it."""
    page.beside, page.touched = beside, True
    if page.view.search.beside.value != beside:
        page.view.search.beside.value = beside


ACTIONS: dict[str, Callable[..., None]] = {
    "play": _play,
    "position": _position,
    "mode": _mode,
    "speed": _speed,
    "loop": _loop,
    "view": _view,
    "dark": _dark,
    "large": _large,
    "forces": _forces,
    "overlay": _overlay,
    "beside": _beside,
}

"""What a session does for each thing that can be asked of it. Runs on the session's worker."""

import time
from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, Any

import numpy as np

import kneecore
from kneecore import Knee, KneecoreError, Trajectory
from kneeviz import controls, files, markup, scene, theme, wire
from kneeviz.lesson import STEPS
from kneeviz.search_job import SearchJob, SearchReport, SearchSettings
from kneeviz.state import (
    PRESETS,
    KneeState,
    Solved,
    preset_knee,
    random_knee,
    shown_bounds,
    with_bound,
)

if TYPE_CHECKING:
    from kneeviz.session import Session


def perform(session: "Session", key: Hashable, value: Any) -> None:
    """Do what was asked under `key`.

    `value` is (widget, client number) for what came from a browser.
    """
    name, *rest = key if isinstance(key, tuple) else (key,)
    if isinstance(value, tuple) and len(value) == 2 and isinstance(value[1], int):
        session.notices.withdraw(value[1], value[0])
    _DEEDS[name](session, value, *rest)


# Kernels


def _ready(session: "Session", _value: Any, what: str) -> None:
    state = session.state
    if what == "model":
        session.model_ready = True
        state.solve_baseline()
        session.show_knee(state.x, final=True)
        session.say("Preparing the surrogate …", "busy")
        return
    session.surrogate_ready = True
    session.refit()
    session.say("Ready.")


def _not_ready(session: "Session", value: Any, _rest: Any = None) -> None:
    session.say(f"The model cannot be prepared: {markup.escape(str(value))}", "bad")


# The knee


def _param(session: "Session", value: Any, index: int) -> None:
    session.set_parameter(index, float(value[0].value))
    _name_knee(session, controls.OWN_KNEE)


def _name_knee(session: "Session", name: str) -> None:
    handle = session.view.knee.preset
    if name in handle.options and handle.value != name:
        handle.value = name


def _preset(session: "Session", value: Any) -> None:
    choose_preset(session, value[0].value)


def choose_preset(session: "Session", name: str) -> None:
    """Make one of the list's knees the visitor's."""
    state = session.state
    if name == controls.OWN_KNEE:
        return
    if name == controls.BASELINE:
        x = np.array(state.space.baseline)
    elif name == controls.RANDOM:
        x = random_knee(state.space, session.rng)
    elif name in controls.WORST and state.result is not None:
        x = np.array(state.result.x[controls.WORST.index(name)])
    elif name in PRESETS:
        x = preset_knee(name, state.space)
    else:
        return
    session.move_to(x)
    _name_knee(session, name)


def _reset_all(session: "Session", _value: Any) -> None:
    choose_preset(session, controls.BASELINE)


def _reset_group(session: "Session", _value: Any, group: str) -> None:
    x = np.array(session.state.x)
    for i, row in enumerate(kneecore.parameter_table()):
        if row.group == group:
            x[i] = session.state.space.baseline[i]
    session.move_to(x)
    _name_knee(session, controls.OWN_KNEE)


def _bound(session: "Session", value: Any, name: str) -> None:
    handle, client_id = value
    state = session.state
    try:
        state.set_bounds(with_bound(state.bounds, name, handle.value))
    except KneecoreError as error:
        session.notices.tell(client_id, "Bounds not changed", str(error))
        _mirror_bounds(session)
        return
    session.mirror_sliders()
    if session.model_ready:
        state.solve_baseline()
        session.show_knee(state.x, final=True)
    _refit(session, client_id)
    show_result(session)


def _refit(session: "Session", client_id: int | None) -> None:
    try:
        session.refit()
    except KneecoreError as error:
        session.say("There is no surrogate for these bounds.", "bad")
        if client_id is not None:
            session.notices.tell(client_id, "No surrogate", str(error))


def _mirror_bounds(session: "Session") -> None:
    state, tab = session.state, session.view.knee
    given = (state.bounds.geometry_mm, state.bounds.slope_deg, state.bounds.material_percent)
    for handle, value, own in zip(
        tab.bounds.values(), given, shown_bounds(state.knee), strict=True
    ):
        wanted = round(own if value is None else value, 4)
        if handle.value != wanted:
            handle.value = wanted
        else:
            wire.force_value(session.target.gui, handle)
    tab.case.value, tab.rest_length.value = state.bounds.case, state.bounds.rest_length


# Motion and view


def _play(session: "Session", value: Any) -> None:
    set_playing(session, value[0].value == "Play")


def set_playing(session: "Session", playing: bool) -> None:
    """Start or pause the motion."""
    session.stop_glide()
    session.playback.play(playing)


def _position(session: "Session", value: Any) -> None:
    set_playing(session, False)
    session.playback.set_share(float(value[0].value) / 100.0)


def _mode(session: "Session", value: Any) -> None:
    set_mode(session, controls.MODES[value[0].value])


def set_mode(session: "Session", mode: str) -> None:
    """Choose between the motion through the loads and the runs in time."""
    session.stop_glide()
    session.playback.set_mode(mode)
    session.forget_runs()
    label = next(text for text, name in controls.MODES.items() if name == mode)
    if session.view.look.mode.value != label:
        session.view.look.mode.value = label


def _speed(session: "Session", value: Any) -> None:
    session.playback.speed = float(value[0].value)


def _loop(session: "Session", value: Any) -> None:
    session.playback.loop = bool(value[0].value)


def _view(session: "Session", value: Any) -> None:
    handle, client_id = value
    view = session.view.scene
    if handle.value == "Reset":
        place_cameras(session, only=client_id)
        return
    spatial = handle.value == "3D"
    if spatial != view.spatial:
        view.spatial = spatial
        view.repaint()
        session.touch()
    place_cameras(session)


def place_cameras(session: "Session", only: int | None = None) -> None:
    """Put the cameras of all clients, or of one, where the view wants them."""
    spatial = session.view.scene.spatial
    for client_id, client in session.clients().items():
        if only in (None, client_id):
            place_camera(client, spatial)


def place_camera(client: Any, spatial: bool) -> None:
    """Put one client's camera where the view wants it, and lock or free its turning."""
    wire.set_camera_lock(client, locked=False)
    with client.atomic():
        client.camera.up_direction = (0.0, 1.0, 0.0)
        client.camera.position = scene.camera_position(spatial)
        client.camera.look_at = scene.CENTRE
    client.flush()
    if not spatial:
        wire.set_camera_lock(client, locked=True)


def _joined(session: "Session", client_id: int) -> None:
    client = session.clients().get(client_id)
    if client is not None:
        place_camera(client, session.view.scene.spatial)


def _dark(session: "Session", value: Any) -> None:
    session.view.repaint(session.target.gui, bool(value[0].value))
    session.view.show_legends(session.overlay)
    show_result(session)
    session.touch()


def _forces(session: "Session", value: Any) -> None:
    set_forces(session, bool(value[0].value))


def set_forces(session: "Session", shown: bool) -> None:
    """Write tensions beside the ligaments' names, or not."""
    session.view.scene.forces = shown
    if session.view.look.forces.value != shown:
        session.view.look.forces.value = shown


# Searching


def _search(session: "Session", value: Any, search_space: str) -> None:
    start_search(session, search_space, None if value is None else value[1])


def start_search(session: "Session", search_space: str, client_id: int | None) -> None:
    """Start a search, unless one is running."""
    tab, state = session.view.search, session.state
    refused = None
    if session.job is not None:
        refused = "A search is running already; cancel it first."
    elif not session.surrogate_ready:
        refused = "The model is still being prepared; try again in a moment."
    if refused is not None:
        if client_id is not None:
            session.notices.tell(client_id, "Not now", refused)
        return
    settings = SearchSettings(
        space=state.space,
        rest_length=state.bounds.rest_length,
        search_space=search_space,
        objective=tab.objective.value,
        pop_size=round(tab.pop_size.value),
        n_generations=round(tab.n_generations.value),
        seed=round(tab.seed.value),
    )
    session.job, session.rising = SearchJob(settings, session.post), []
    tab.set_running(True)
    where = "stand-in" if search_space == "surrogate" else "true model"
    session.say(f"Searching in the {where} …", "busy")
    session.job.start()


def _progress(session: "Session", value: tuple[SearchJob, SearchReport]) -> None:
    job, report = value
    if job is not session.job:
        return
    tab = session.view.search
    tab.progress.value = report.percent
    if report.best_deg is not None:
        session.rising.append(report.best_deg)
        colour = theme.palette(session.view.dark).current
        tab.rising.content = markup.box(
            f"Best f so far: <b>{markup.number(report.best_deg, 0, '°')}</b>"
            + markup.sparkline(session.rising, colour)
        )


def _search_done(session: "Session", value: tuple[SearchJob, Any, str | None]) -> None:
    job, result, why = value
    if job is not session.job:
        return
    session.job = None
    session.view.search.set_running(False)
    if result is not None:
        take_result(session, result)
        session.say("The search is done: model 1 in blue, model 2 in orange.")
    elif why is not None:
        session.say(f"The search failed: {markup.escape(why)} What you had stands.", "bad")
    else:
        session.say("The search was cancelled; what you had stands.")


def _cancel(session: "Session", value: Any) -> None:
    if session.job is not None:
        session.job.cancel()
    elif value is not None:
        session.notices.tell(value[1], "Nothing to cancel", "No search is running.")


def take_result(session: "Session", result: Any) -> None:
    """Show a result's two knees and offer its files."""
    session.state.take_result(result)
    tab, knee = session.view.search, session.view.knee
    tab.overlay.visible = tab.adopt.visible = True
    tab.overlay.value = True
    chosen = knee.preset.value
    knee.preset.options = (
        controls.OWN_KNEE,
        controls.BASELINE,
        *controls.WORST,
        *PRESETS,
        controls.RANDOM,
    )
    knee.preset.value = chosen
    for handle in session.view.files.result.values():
        handle.disabled = False
    session.show_overlay(True)
    show_result(session)


def show_result(session: "Session") -> None:
    """Write what the last search found, greyed if the bounds have changed since."""
    result, view = session.state.result, session.view
    if result is None:
        return
    stale = session.state.result_is_stale
    style = "opacity:.45" if stale else ""
    note = "<b>Bounds changed since this search.</b><br>" if stale else ""
    sentence = markup.escape(result.summary())
    view.search.found.content = markup.box(
        f"{note}<b>{sentence}</b><br>{markup.objective_line(result)}", style=style
    )
    colours = theme.palette(view.dark)
    command = "The same without a browser:" + markup.command_line(result.command())
    view.search.table.content = markup.box(
        markup.differences(result, colours)
        + f'<div style="margin-top:5px">{markup.bound_names(result)}</div>'
        + f'<div style="margin-top:5px">{command}</div>',
        style=style,
    )
    view.found.content = markup.box(f"{note}{sentence}", style=style)
    view.files.command.content = markup.box(command, style=style)


def _overlay(session: "Session", value: Any) -> None:
    session.show_overlay(bool(value[0].value))


def set_overlay(session: "Session", shown: bool) -> None:
    """Show or hide both worst cases, and let the box agree."""
    if session.view.search.overlay.value != shown:
        session.view.search.overlay.value = shown
    session.show_overlay(shown)


def _adopt(session: "Session", value: Any) -> None:
    choose_preset(session, controls.WORST[0 if value[0].value == "Model 1" else 1])


# Files


def _download(session: "Session", value: Any, name: str) -> None:
    client = session.clients().get(value[1])
    if client is None:
        return
    if name == "knee.toml":
        content = session.state.knee_text().encode()
    elif session.state.result is None:
        session.notices.tell(value[1], "Nothing to download", "No search has been made yet.")
        return
    else:
        content = files.result_files(session.state.result, name)
    client.send_file_download(name, content, save_immediately=True)


def _upload(session: "Session", value: tuple[str, bytes, int]) -> None:
    name, content, client_id = value
    try:
        loaded = files.read_upload(name, content)
    except KneecoreError as error:
        session.notices.tell(client_id, "File not loaded", f"{name[:80]}: {str(error)[:300]}")
        return
    if isinstance(loaded, Knee):
        load_knee(session, loaded)
        session.say(f"Loaded the knee “{markup.escape(loaded.title[:60])}”.")
    else:
        take_result(session, loaded)
        session.say("Loaded the result: model 1 in blue, model 2 in orange.")


def load_knee(session: "Session", knee: Knee) -> None:
    """Take a knee file: baseline, half-ranges and, if it has them, current values."""
    state = session.state
    result, worst = state.result, state.worst
    state.set_knee(knee)
    state.result, state.worst = result, worst
    _mirror_bounds(session)
    session.mirror_sliders()
    if session.model_ready:
        state.solve_baseline()
        session.show_knee(state.x, final=True)
    _refit(session, None)
    _name_knee(session, controls.OWN_KNEE)
    show_result(session)


# Lesson


def _lesson_press(session: "Session", value: Any) -> None:
    if session.lesson is None:
        open_step(session, 0)
        return
    for deed in STEPS[session.lesson].press:
        stage(session, deed, None if value is None else value[1])


def _lesson_turn(session: "Session", value: Any) -> None:
    at = -1 if session.lesson is None else session.lesson
    to = at + (1 if value[0].value == "Next" else -1)
    if 0 <= to < len(STEPS):
        open_step(session, to)
    else:
        session.lesson = None
        session.view.learn.show(None)


def open_step(session: "Session", number: int) -> None:
    """Open a step of the lesson and set its stage."""
    session.lesson = number
    session.view.learn.show(number)
    for deed in STEPS[number].stage:
        stage(session, deed, None)


def stage(session: "Session", deed: tuple[Any, ...], client_id: int | None) -> None:
    """Do one thing on the lesson's stage."""
    name, *rest = deed
    simple: dict[str, Callable[..., None]] = {
        "overlay": set_overlay,
        "mode": set_mode,
        "forces": set_forces,
        "play": set_playing,
        "preset": choose_preset,
    }
    if name in simple:
        simple[name](session, *rest)
    elif name == "baseline":
        choose_preset(session, controls.BASELINE)
    elif name in ("moment", "glide"):
        session.glide_to(*rest)
    elif name == "search":
        start_search(session, "surrogate", client_id)


# Helpers of the session


def runs_in_time(
    state: KneeState, knees: tuple[Solved | None, ...]
) -> tuple[Trajectory | None, ...]:
    """Return the motions in time of the visitor's knee and the two worst cases."""
    current, *worst = knees
    runs: list[Trajectory | None] = [None if current is None else state.trajectory(current.x)]
    for knee in worst:
        if knee is None or knee.sweep is None:
            runs.append(None)
            continue
        result = state.result
        runs.append(
            kneecore.trajectory(
                knee.x, baseline=result.space.baseline, rest_length=result.rest_length
            )
        )
    return tuple(runs)


def training_curves(state: KneeState) -> Any:
    """Return the surrogate's training curves that did not fail, shape (n, 12), rad, or None."""
    if state.surrogate is None:
        return None
    curves = state.surrogate.training_flexion
    return curves[np.isfinite(curves).all(axis=1)]


def _reject(session: "Session", value: Any, _client: int) -> None:
    client_id, handle, fault = value
    session.notices.complain(client_id, handle, fault, now=time.monotonic())


_DEEDS: dict[str, Callable[..., None]] = {
    "ready": _ready,
    "not_ready": _not_ready,
    "param": _param,
    "preset": _preset,
    "reset_all": _reset_all,
    "reset_group": _reset_group,
    "bound": _bound,
    "play": _play,
    "position": _position,
    "mode": _mode,
    "speed": _speed,
    "loop": _loop,
    "view": _view,
    "joined": lambda session, _value, client_id: _joined(session, client_id),
    "dark": _dark,
    "forces": _forces,
    "search": _search,
    "progress": _progress,
    "search_done": _search_done,
    "cancel": _cancel,
    "overlay": _overlay,
    "adopt": _adopt,
    "download": _download,
    "upload": _upload,
    "lesson_press": _lesson_press,
    "lesson_turn": _lesson_turn,
    "reject": _reject,
}

"""One view of one knee: its state, its handles, and the thread that brings them together.

A session belongs to the server (everybody sees the same knee) or to a single client. Callbacks post
to the session's mailbox; its worker thread alone touches the state and the handles.
"""

import logging
import math
import time
from collections.abc import Callable, Hashable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore import Knee, Trajectory
from kneecore.knee.parameters import widened
from kneecore.knee.physics.forces import THETA_0
from kneecore.knee.physics.pose import STATION
from kneeviz import viser_internals as wire
from kneeviz.actions import landscape as do_landscape
from kneeviz.actions import live as do_live
from kneeviz.actions import methods as do_methods
from kneeviz.actions import study as do_study
from kneeviz.actions import table as deeds
from kneeviz.actions.live import Live
from kneeviz.actions.result import show_result
from kneeviz.geometry.mechanism import Pose, tibia_at_contact
from kneeviz.geometry.sweep import pose_in_time
from kneeviz.jobs.live_search import LiveSearch
from kneeviz.jobs.search_job import SearchJob
from kneeviz.jobs.worker import Actions, Worker
from kneeviz.page import sliders
from kneeviz.page.notices import Notices
from kneeviz.state.knee import SCALE, WIDTH, KneeState, Solved, runs_in_time, training_curves
from kneeviz.state.landscape import LandscapeShow
from kneeviz.state.playback import FRAME_SECONDS, Playback
from kneeviz.state.study import StudyDesk
from kneeviz.views.charts import series
from kneeviz.views.charts.curves import Band, Markers, Shown
from kneeviz.views.html import pieces as markup
from kneeviz.views.view import View

FloatArray = NDArray[np.float64]

_LOG = logging.getLogger(__name__)
_MORPH_SECONDS = 0.35
_FADE_SECONDS = 0.6
_SEND_SECONDS = 0.004  # s: about what it takes to pack and send the curves
_DRAG_SECONDS, _DRAG_FRAME = 0.4, 0.1  # s: how long a slider counts as moving, and a frame then
_REST_SECONDS = 0.1  # s: so much later what stands behind other tabs follows
_SLOW_FRAMES = 3  # hidden tabs, numbers and the position slider follow at a third of the rate


class Session:
    """A knee, its view and its worker.

    Parameters
    ----------
    target : ViserServer or ClientHandle
        Where the view is built; both have ``gui``, ``scene``, ``atomic`` and ``flush``.
    knee : Knee
        The baseline.
    clients : callable
        Returns the clients that look at this view, by their number.
    """

    def __init__(self, target: Any, knee: Knee, clients: Callable[[], dict[int, Any]]) -> None:
        self.target, self.clients = target, clients
        self.state = KneeState(knee)
        self.playback = Playback()
        self.worker = Worker(self._step, self._failed)
        self.view = View(target, self.post, self.state)
        self.notices = Notices(clients, target.gui)
        self.job: SearchJob | None = None
        self.live = Live()
        self.live_search = LiveSearch(self.post)
        self.settle_at: float | None = None
        """When to bring sliders and surrogate to bounds that moved, s of `time.monotonic`."""
        self.rising: list[float] = []
        self.overlay = False
        self.study = StudyDesk()
        self.methods = do_methods.MethodsDesk()
        self.landscape = LandscapeShow(self.post)
        self.band: Band | None = None
        self.lesson: int | None = None
        self.rng = np.random.default_rng()
        self.model_ready = False
        self.surrogate_ready = False
        self.exact_ready = False
        self.shown_stale = False
        """Whether the page says that its result belongs to other bounds."""
        self._runs: tuple[Trajectory | None, ...] | None = None
        self._morph: tuple[FloatArray, float] | None = None
        self._fade_start: float | None = None
        self._stale = True  # the charts' content, beyond the markers
        self._held = False
        self._rest_at: float | None = None
        """When to draw what stands behind other tabs, s of `time.monotonic`."""
        self._frame = 0
        self._glide: tuple[float, float, float] | None = None
        self._edited = -math.inf
        """When a slider was last moved, s of `time.monotonic`."""
        wire.guard(target.gui, self.reject)

    def start(self) -> None:
        """Draw the knee and start the worker."""
        self.draw_at_rest()
        self.show_legends()
        self.worker.start()

    def stop(self) -> None:
        """End the worker and a running search."""
        if self.job is not None:
            self.job.cancel()
        for job in (self.study.job, self.methods.job):
            if job is not None:
                job.cancel()
        self.landscape.stop()
        self.worker.stop()
        self.live_search.stop()

    def post(self, key: Hashable, value: Any = None) -> None:
        """Ask the worker for something; returns at once."""
        self.worker.mailbox.post(key, value)

    def reject(self, client_id: int, handle: Any, fault: str) -> None:
        """Note that a client's message was turned away; it is told once it stops."""
        self.post(("reject", client_id), (client_id, handle, fault))

    # The worker's thread from here on.

    def _step(self, actions: Actions) -> float | None:
        now, moving = time.monotonic(), self._moving()
        for key, value in actions:
            self._perform(key, value)
        if self.settle_at is not None and now >= self.settle_at:
            self._perform("settle", None)
        slow_at = do_live.follow(self)
        if actions and self.shown_stale != self.is_stale():
            show_result(self)
        self._ease(now)
        self.playback.advance(now)
        news = self._stale or moving or self._moving() or (bool(actions) and not self._held)
        self._held = False
        if self.model_ready and news:
            self.draw()
        else:
            self.target.flush()
        if self._rest_at is not None and now >= self._rest_at:
            self._draw_rest()
        times = (self.notices.deliver(now), slow_at, self.settle_at, self._rest_at)
        due = min((t for t in times if t is not None), default=None)
        if self._moving() and self.clients():
            # Under a moving slider its answers are the frames: more would only keep them waiting.
            frame = _DRAG_FRAME if now - self._edited < _DRAG_SECONDS else FRAME_SECONDS
            due = now + frame if due is None else min(due, now + frame)
        elif self._moving():
            due = now + 0.5  # nobody looks
        return due

    def is_stale(self) -> bool:
        """Tell whether the result on the page belongs to other bounds than those set now."""
        return self.state.result_is_stale and not self.live.keeps_up

    def _perform(self, key: Hashable, value: Any) -> None:
        """Do one thing; if it fails, the rest goes on and whoever asked is told."""
        try:
            deeds.perform(self, key, value)
        except Exception as error:
            _LOG.exception("%s failed", key)
            self.say(f"That did not work: {markup.escape(str(error))}", "bad")
            client_id = deeds.asked_by(value)
            if client_id is not None:
                self.notices.tell(client_id, "That did not work", str(error)[:300])

    def _moving(self) -> bool:
        return self.model_ready and (
            self.playback.playing
            or self._morph is not None
            or self._fade_start is not None
            or self._glide is not None
        )

    def _ease(self, now: float) -> None:
        """Carry on what changes over a moment instead of at once."""
        if self._morph is not None:
            start, began = self._morph
            part = min((now - began) / _MORPH_SECONDS, 1.0)
            smooth = part * part * (3.0 - 2.0 * part)
            self.show_knee(start + smooth * (self.state.x - start), final=part >= 1.0)
            if part >= 1.0:
                self._morph = None
        if self._fade_start is not None:
            part = min((now - self._fade_start) / _FADE_SECONDS, 1.0)
            self.view.scene.fade_overlays(part)
            if part >= 1.0:
                self._fade_start = None
        if self._glide is not None:
            self._follow_glide(now)

    def _follow_glide(self, now: float) -> None:
        assert self._glide is not None
        start, end, began = self._glide
        part = min((now - began) / 1.2, 1.0)
        self.playback.set_share(start + (end - start) * part * part * (3.0 - 2.0 * part))
        if part >= 1.0:
            self._glide = None

    def show_knee(self, x: FloatArray, *, final: bool) -> None:
        """Solve the knee `x` for display; the last one is also the one that is kept."""
        if final:
            solved = self.state.update(self.state.x)
            if solved.sweep is None:
                self.say("The model fails for this knee; the last good one is shown.", "bad")
        else:
            self.state.preview(x)
        self._stale, self._runs = True, None

    def move_to(self, x: FloatArray) -> None:
        """Make `x` the visitor's knee; the one on screen turns into it."""
        shown = self.state.x if self.state.current is None else self.state.current.x
        self.state.x = widened(x, WIDTH)
        if self.model_ready:
            self._morph = (np.array(shown), time.monotonic())
        self.mirror_sliders()

    def set_parameter(self, index: int, value: float) -> None:
        """Take a slider's value, in the parameter's unit."""
        if abs(value - sliders.shown_value(self.view.knee, self.state, index)) < 1e-9:
            return  # the browser repeats what it was told, with fewer digits than we keep
        self.state.x[index] = value * SCALE[index]
        handle = self.view.knee.sliders[index]
        if handle.value != value:  # set by us while the visitor moved it
            handle.value = value
        self._morph = None
        self._edited = time.monotonic()
        if self.model_ready:
            self.show_knee(self.state.x, final=True)

    def mirror_sliders(self) -> None:
        """Let all sliders show the present knee, also in a browser that missed something."""
        sliders.mirror(self.view.knee, self.state, self.target.gui)

    def refit(self) -> None:
        """Fit the surrogate anew, if the kernels are there."""
        if self.surrogate_ready:
            self.state.fit()
            self._stale = True

    def show_overlay(self, shown: bool) -> None:
        """Show or hide the two worst cases; they fade in."""
        shown = shown and self.state.result is not None
        if shown and not self.overlay:
            self._fade_start = time.monotonic()
            self.view.scene.fade_overlays(0.0)
        self.overlay = shown
        self.show_legends()
        self._stale, self._runs = True, None

    def show_band(self, band: Band | None) -> None:
        """Draw a sampling band behind the curves, or none."""
        self.band = band
        self.show_legends()
        self._stale = True

    def show_legends(self) -> None:
        """Write the charts' keys."""
        self.view.show_legends(self.overlay, self.band)

    def glide_to(self, moment: float) -> None:
        """Turn the knee smoothly to where it rests under a moment, N m."""
        sweep = None if self.state.current is None else self.state.current.sweep
        if sweep is None:
            return
        self.playback.play(False)
        self._glide = (self.playback.share, sweep.share_at(moment), time.monotonic())

    def hold(self) -> None:
        """Leave the picture as it is: drawing it once more would only delay what comes."""
        self._held = True

    def touch(self) -> None:
        """Draw the charts anew at the next frame."""
        self._stale = True

    def forget_runs(self) -> None:
        """Compute motions in time anew."""
        self._runs = None

    def stop_glide(self) -> None:
        """Leave the knee where it is."""
        self._glide = None

    def say(self, text: str, kind: str = "calm") -> None:
        """Write the status line."""
        self.view.transport.status.content = markup.status(text, kind=kind)

    def _failed(self, error: Exception) -> None:
        self.say(f"That did not work: {markup.escape(str(error))}", "bad")
        self.target.flush()

    def draw_at_rest(self) -> None:
        """Draw the load-free knee, for which no kernel is needed."""
        x = self.state.x
        pose = Pose(
            flexion=THETA_0,
            moment=0.0,
            tibia_position=tibia_at_contact(x, THETA_0, STATION, 0.0),
            tension=np.zeros(4),
            contact_force=0.0,
        )
        self.view.scene.draw(x, pose)
        self.view.show_readout(pose)

    def _knees(self) -> tuple[Solved | None, Solved | None, Solved | None]:
        one, two = self.state.worst if self.overlay else (None, None)
        return self.state.current, one, two

    def poses(self) -> tuple[Pose | None, Pose | None, Pose | None]:
        """Return the poses on screen: the visitor's knee and both worst cases, at one moment."""
        knees = self._knees()
        current = self.state.current
        if current is None or current.sweep is None:
            return None, None, None
        if self.playback.mode == "sweep":
            moment = current.sweep.moment_at(self.playback.share)
            poses = [
                None if k is None or k.sweep is None else k.sweep.at_moment(moment) for k in knees
            ]
        else:
            if self._runs is None:
                self._runs = runs_in_time(self.state, knees)
            direction = 0 if self.playback.mode == "extension" else 1
            poses = [
                None if r is None else pose_in_time(r, direction, self.playback.share * r.time[-1])
                for r in self._runs
            ]
        return poses[0], poses[1], poses[2]

    def draw(self) -> None:
        """Bring scene, charts and numbers up to date and send them off."""
        current, poses = self.state.current, self.poses()
        if current is None or poses[0] is None:
            self.target.flush()
            return
        stale, self._stale = self._stale, False
        self._frame += 1
        slow = stale or not self.playback.playing or self._frame % _SLOW_FRAMES == 0
        shown = self.shown()
        if slow:  # sixty curves cost a browser without a graphics card more than the knee
            self.view.curve.update(shown, Markers(poses=poses))
        if stale:  # the answer to a slider goes first
            self.target.flush()
            # The thread that sends it would have to wait for this one's next pause.
            time.sleep(_SEND_SECONDS)
        if not self.landscape.shown:
            self._draw_scene(current.x, poses)
        self.target.flush()
        if slow:
            self.view.show_readout(poses[0])
            self._mirror_position()
            if not stale and self._rest_at is None:
                self.view.show_other_charts(shown, Markers(poses=poses))
            self.target.flush()
        if stale and self._rest_at is None:
            self._rest_at = time.monotonic() + _REST_SECONDS

    def _draw_rest(self) -> None:
        """Draw what stands behind other tabs: a browser that draws it has no time for the knee."""
        self._rest_at = None
        shown, poses = self.shown(), self.poses()
        if poses[0] is None:
            return
        with self.target.atomic():
            self.view.show_other_charts(shown, Markers(poses=poses))
            self._show_numbers(shown)
        self.target.flush()
        do_study.refresh(self)
        do_methods.refresh(self)
        do_landscape.refresh(self)
        self.target.flush()

    def _draw_scene(self, x: FloatArray, poses: tuple[Pose | None, ...]) -> None:
        """Put the visitor's knee and the worst cases into their poses."""
        assert poses[0] is not None
        with self.target.atomic():
            self.view.scene.draw(x, poses[0])
            for i, knee in enumerate(self._knees()[1:]):
                self.view.scene.draw_overlay(i, None if knee is None else knee.x, poses[i + 1])

    def _mirror_position(self) -> None:
        handle = self.view.transport.position
        value = round(100.0 * self.playback.share, 1)
        if handle.value != value:
            handle.value = value

    def shown(self) -> Shown:
        """Return what the charts show now."""
        baseline, (current, one, two) = self.state.baseline, self._knees()
        knees = (baseline, current, one, two)
        return Shown(
            sweeps=tuple(None if k is None else k.sweep for k in knees),
            flexion=None if current is None else current.response.flexion,
            predicted=self.state.predicted,
            training=training_curves(self.state),
            strain_free=self.state.strain_free,
            band=self.band,
        )

    def _show_numbers(self, shown: Shown) -> None:
        state, error = self.state, None
        if state.predicted is not None and shown.flexion is not None:
            error = series.prediction_error(state.predicted, shown.flexion)
        loo = None if state.surrogate is None else state.surrogate.loo_rms_deg
        self.view.error.content = markup.error_line(error, loo)
        worst = [None, None] if not self.overlay else [k.x if k else None for k in state.worst]
        current = state.x if state.current is None else state.current.x
        self.view.show_comparison(state.space, (state.space.baseline, current, *worst))

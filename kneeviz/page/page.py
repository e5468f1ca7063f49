"""One page: a knee, what it looks like, and what runs for it. What actions act on.

The session's thread alone calls it; see `kneeviz.server.session`.
"""

import math
import time
from collections.abc import Callable, Mapping

import numpy as np
import viser
from numpy.typing import NDArray

from kneecore import KneeFile, SearchResult
from kneecore.knee.parameters import widened
from kneeviz.jobs.job import Job
from kneeviz.jobs.live_search import LiveSearch
from kneeviz.jobs.messages import Post
from kneeviz.jobs.uploads import Uploads
from kneeviz.page import sliders
from kneeviz.page.animation import Animation
from kneeviz.page.framing import Framing, Subject, room_between
from kneeviz.page.notices import Notices
from kneeviz.state.bounds import SCALE, WIDTH
from kneeviz.state.ghosts import Ghosts
from kneeviz.state.handles import HandlesState
from kneeviz.state.history import History
from kneeviz.state.knee import KneeState
from kneeviz.state.landscape import LandscapeState
from kneeviz.state.lesson import Answers, SetAside
from kneeviz.state.links import LinksState
from kneeviz.state.live import LiveState
from kneeviz.state.methods import MethodsState
from kneeviz.state.motion import Knees, Motion, Poses
from kneeviz.state.playback import Playback
from kneeviz.state.pointing import Pointing
from kneeviz.state.search import SearchState
from kneeviz.state.shown import Band
from kneeviz.state.snapshot import Snapshot
from kneeviz.state.study import StudyState
from kneeviz.views.html.pieces import status
from kneeviz.views.view import View

FloatArray = NDArray[np.float64]
Target = viser.ViserServer | viser.ClientHandle
Clients = Callable[[], dict[int, viser.ClientHandle]]


class Page:
    """A knee and its view.

    Parameters
    ----------
    target : ViserServer or ClientHandle
        Where the view is built; both have ``gui``, ``scene``, ``atomic`` and ``flush``.
    knee : KneeFile
        The baseline.
    clients : callable
        Returns the clients that look at this page, by their number.
    post : callable
        Asks for an action.
    """

    def __init__(self, target: Target, knee: KneeFile, clients: Clients, post: Post) -> None:
        self.target, self.clients, self.post = target, clients, post
        self.state = KneeState(knee)
        self.playback = Playback()
        self.view = View(target, post, self.state)
        self.notices = Notices(clients, target.gui)
        self.search = SearchState()
        self.live = LiveState()
        self.handles = HandlesState()
        self.live_search = LiveSearch(post)
        self.uploads = Uploads(post)
        self.study = StudyState()
        self.methods = MethodsState()
        self.landscape = LandscapeState(post)
        self.export_job: Job | None = None
        """What draws a file to take away."""
        self.motion = Motion()
        self.animation = Animation()
        self.framing = Framing(clients, self.view.left, post)
        self.rng = np.random.default_rng()
        self.overlay: bool = False
        """Whether both worst cases are shown."""
        self.other: SearchResult | None = None
        """The last result before the present one that had the other response: at rest, or in
        motion."""
        self.beside: bool = False
        """Whether they stand beside the visitor's knee, or over it."""
        self.ghosts: Ghosts = ()
        """The visitor's last few knees, kept faint."""
        self.keeps_ghosts: bool = False
        """Whether they are kept and shown."""
        self.keep: Callable[[Snapshot], None] | None = None
        """Takes each new state, where it is kept beyond the page."""
        self.links = LinksState()
        self.begin()
        self.band: Band | None = None
        """The sampling band behind the curves."""
        self.pointing: Pointing | None = None
        """The pointer over a chart that poses the knee."""
        self.lesson: int | None = None
        """The lesson's open step."""
        self.answers = Answers()
        """What was answered in the lesson, or in the last one."""
        self.set_aside: SetAside | None = None
        """What the visitor had before the lesson."""
        self.model_ready: bool = False
        self.surrogate_ready: bool = False
        self.exact_ready: bool = False
        self.settle_at: float | None = None
        """When to bring sliders and surrogate to bounds that moved, s of `time.monotonic`."""
        self.edited_at: float = -math.inf
        """When a slider was last moved, s of `time.monotonic`."""
        self.mirrored_at: float = -math.inf
        """When the position slider was last set by us, s of `time.monotonic`."""
        self.standing: object = None
        """What was drawn last of what belongs to what; see `kneeviz.actions.standing`."""
        self.touched: bool = True
        """Whether the charts' content, beyond the markers, is to be drawn anew."""
        self.unsolved: bool = False
        """Whether sliders have moved since the knee was solved last."""
        self.held: bool = False
        """Whether to leave the picture as it is for once."""

    def stop(self) -> None:
        """Cancel what runs; the threads that wait for requests end."""
        for job in (self.search.job, self.study.job, self.methods.job, self.export_job):
            if job is not None:
                job.cancel()
        self.landscape.stop()
        self.live_search.stop()
        self.uploads.stop()

    @property
    def moving(self) -> bool:
        """Whether the picture changes by itself."""
        return self.model_ready and (
            self.playback.playing or self.animation.running or self.framing.running
        )

    @property
    def knees(self) -> Knees:
        """The visitor's knee and, if they are shown, both worst cases."""
        one, two = self.state.worst if self.overlay else (None, None)
        return self.state.current, one, two

    @property
    def subject(self) -> Subject:
        """What the cameras are to show."""
        shown = self.ghosts if self.keeps_ghosts else ()
        spatial, landscape = self.view.scene.spatial, self.landscape.shown
        return Subject(self.knees, spatial, landscape, shown, self.apart)

    @property
    def apart(self) -> float:
        """How far to the sides of the visitor's knee both worst cases stand, m."""
        return room_between(self.knees) if self.beside and self.overlay else 0.0

    @property
    def poses(self) -> Poses:
        """The poses on screen: the visitor's knee and both worst cases, at one moment."""
        return self.motion.poses(self.state, self.knees, self.playback)

    def begin(self) -> None:
        """Let the present state be the one where the page began."""
        self.history: History[Snapshot] = History(self.snapshot())

    def snapshot(self) -> Snapshot:
        """Return what a visitor may change and want back, as it is now."""
        state = self.state
        return Snapshot(
            knee=state.knee,
            bounds=state.bounds,
            x=state.x,
            result=None if self.live.on else state.result,
            overlay=self.overlay,
            live=self.live.on,
            settings=self.view.settings.values,
            ghosts=self.ghosts,
        )

    def advance(self, now: float) -> None:
        """Carry on what moves; `now` is in s of `time.monotonic`."""
        morphed = self.animation.morph(self.state.x, now)
        if morphed is not None:
            x, final = morphed
            self.show_knee(x, final=final)
        faded = self.animation.fade(now)
        if faded is not None:
            self.view.scene.fade_overlays(faded)
        glided = self.animation.glide(now)
        if glided is not None:
            self.playback.set_share(glided)
        self.playback.advance(now)
        if not self.handles.grabs:  # nothing is moved away under a hand
            self.framing.follow(self.subject, now)
        self.framing.advance(now)

    def show_knee(self, x: FloatArray, *, final: bool) -> None:
        """Solve the knee `x` for display; the last one is also the one that is kept."""
        if final:
            solved = self.state.update(self.state.x)
            if solved.sweep is None:
                self.say("The model fails for this knee; the last good one is shown.", "bad")
        else:
            self.state.preview(x)
        self.touched = True
        self.motion.forget()

    def move_to(self, x: FloatArray) -> None:
        """Make `x` the visitor's knee; the one on screen turns into it."""
        shown = self.state.x if self.state.current is None else self.state.current.x
        self.state.x = widened(x, WIDTH)
        if self.model_ready:
            self.animation.start_morph(np.array(shown), time.monotonic())
        self.mirror_sliders()

    def set_parameter(self, index: int, value: float) -> None:
        """Take a slider's value, in the parameter's unit."""
        if abs(value - sliders.shown_value(self.view.knee, self.state, index)) < 1e-9:
            return  # the browser repeats what it was told, with fewer digits than we keep
        self.state.x[index] = value * SCALE[index]
        handle = self.view.knee.sliders[index]
        if handle.value != value:  # set by us while the visitor moved it
            handle.value = value
        self._edited()

    def put(self, values: Mapping[int, float]) -> None:
        """Give parameters values, SI, by their place in a knee; their sliders follow."""
        for index, value in values.items():
            self.state.x[index] = value
            handle = self.view.knee.sliders[index]
            shown = sliders.shown_value(self.view.knee, self.state, index)
            if handle.value != shown:
                handle.value = shown
        self._edited()

    def _edited(self) -> None:
        self.animation.stop_morph()
        self.edited_at = time.monotonic()
        self.unsolved = self.model_ready

    def catch_up(self) -> None:
        """Solve the knee once for all sliders that have moved."""
        if self.unsolved:
            self.unsolved = False
            self.show_knee(self.state.x, final=True)

    def mirror_sliders(self) -> None:
        """Let all sliders show the present knee, also in a browser that missed something."""
        sliders.mirror(self.view.knee, self.state, self.target.gui)

    def refit(self) -> None:
        """Fit the surrogate anew, if the kernels are there."""
        if self.surrogate_ready:
            self.state.fit()
            self.touched = True

    def show_overlay(self, shown: bool) -> None:
        """Show or hide the two worst cases; they fade in."""
        shown = shown and self.state.result is not None
        if shown and not self.overlay:
            self.animation.start_fade(time.monotonic())
            self.view.scene.fade_overlays(0.0)
        self.overlay = shown
        self.touched = True
        self.motion.forget()

    def show_band(self, band: Band | None) -> None:
        """Draw a sampling band behind the curves, or none."""
        self.band = band
        self.touched = True

    def glide_to(self, moment: float) -> None:
        """Turn the knee smoothly to where it rests under a moment, N m."""
        sweep = None if self.state.current is None else self.state.current.sweep
        if sweep is None:
            return
        self.playback.play(False)
        share = self.playback.share
        self.animation.start_glide(share, sweep.share_at(moment), time.monotonic())

    def say(self, text: str, kind: str = "calm") -> None:
        """Write the status line."""
        self.view.transport.status.content = status(text, kind=kind)

"""A model's page: what it shows, what is known, and what runs for it.

The session's thread alone calls it; see `kneeviz.anymodel.session`.
"""

import math
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kneecore import Model, Shape
from kneeviz import viser_internals
from kneeviz.anymodel.curves import curves_of
from kneeviz.anymodel.frame import HEIGHT, WIDTH, Frame, widened
from kneeviz.anymodel.pictures import ONE, OWN, TWO, Pictures
from kneeviz.anymodel.runs import ModelRuns, apart
from kneeviz.anymodel.snapshot import ModelSnapshot
from kneeviz.anymodel.state import ModelState
from kneeviz.anymodel.views import words
from kneeviz.anymodel.views.view import ModelView
from kneeviz.geometry import surfaces
from kneeviz.jobs.messages import Post
from kneeviz.jobs.uploads import Uploads
from kneeviz.page.framing import Framing
from kneeviz.page.notices import Notices
from kneeviz.page.page import Clients, Target
from kneeviz.state.history import History
from kneeviz.views.html.pieces import escape, sentence
from kneeviz.views.scene import camera

FloatArray = NDArray[np.float64]


class Subject(NamedTuple):
    """What is to be seen: a picture, or a landscape in its place."""

    size: tuple[float, float]
    """The picture's width and height, m."""
    landscape: bool

    @property
    def flat(self) -> bool:
        """Whether cameras only pan and zoom."""
        return not self.landscape

    @property
    def direction(self) -> FloatArray:
        """From the middle to the camera."""
        return camera.BEFORE_LANDSCAPE if self.landscape else camera.FRONT

    def points(self) -> FloatArray:
        """Return what must be in the picture."""
        if self.landscape:
            return surfaces.corners()
        x, y = (0.5 * length for length in self.size)
        return np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])


class ModelPage:
    """A model and its view.

    Parameters
    ----------
    target : ViserServer or ClientHandle
        Where the view is built.
    model : Model
    clients : callable
        Returns the clients that look at this page, by their number.
    post : callable
        Asks for an action.
    """

    def __init__(self, target: Target, model: Model, clients: Clients, post: Post) -> None:
        self.target, self.clients, self.post = target, clients, post
        self.state = ModelState.of(apart(model))
        self.view = ModelView(target, post, self.state)
        self.notices = Notices(clients, target.gui)
        self.runs = ModelRuns(model, post)
        self.pictures = Pictures(model, post)
        self.uploads = Uploads(post)
        # Charts that have the picture's place do not give way to it.
        charts = self.view.left if self.view.has_picture else None
        self.framing = Framing(clients, charts, post)
        self._kept: tempfile.TemporaryDirectory[str] | None = None
        self.frame: Frame | None = None
        self.touched = True
        """Whether the page shows something older than what is known."""
        self.troubles: dict[str, str] = {}
        """What is wrong now, the latest last: by what it is with, and why."""
        self.moved_at: float = -math.inf
        """When a slider was last moved, s of `time.monotonic`."""
        self.starting: bool = True
        """Whether the first run, the nominal model's, is to come: nothing may take its place."""
        self.told_running: bool = False
        """Whether the page says that the model is run."""
        self.after_learning: bool = False
        """Whether a search is to begin as soon as the learning has ended."""
        self.keep: Callable[[ModelSnapshot], None] | None = None
        """Takes each new state, where it is kept beyond the page."""
        self.begin()

    def begin(self) -> None:
        """Let the present state be the one where the page began."""
        self.history: History[ModelSnapshot] = History(self.snapshot())

    def snapshot(self) -> ModelSnapshot:
        """Return what a visitor may change and want back, as it is now."""
        state = self.state
        return ModelSnapshot(
            x=state.x,
            result=state.result,
            overlay=state.overlay,
            band=state.band,
            column=state.column,
            settings=self.view.settings.values,
        )

    def start(self) -> None:
        """Run the nominal model once, and have the sliders' picture drawn."""
        self.follow()
        self.runs.ask(self.state.model.nominal)
        self.draw()

    def stop(self) -> None:
        """Cancel what runs; threads and processes end."""
        if self.state.job is not None:
            self.state.job.cancel()
        self.runs.stop()
        self.pictures.stop()
        self.uploads.stop()
        self.state.model.close()
        if self._kept is not None:
            self._kept.cleanup()

    def keep_runs(self) -> None:
        """Keep the runs of a slow model while the page is open, unless its file says where.

        A search then goes on from what was learned, or from a search that was cancelled.
        """
        state = self.state
        if state.model.run_options.keep is None:
            self._kept = tempfile.TemporaryDirectory(prefix="kneeviz-", ignore_cleanup_errors=True)
            keep = str(Path(self._kept.name) / "runs.jsonl")
            state.model.close()
            state.model = state.model.with_runs(keep=keep, rerun_failures=True)

    @property
    def subject(self) -> Subject:
        """What the cameras are to show."""
        size = (WIDTH, HEIGHT) if self.frame is None else self.frame.size
        return Subject(size, self.state.landscape_shown)

    def say(self, text: str, kind: str = "calm") -> None:
        """Write the status line; `text` must be escaped."""
        self.view.say(text, kind)

    def tell_trouble(self, what: str, text: str | None) -> None:
        """Say what is wrong with the run, the surrogate or the picture, or that it is over."""
        had = bool(self.troubles)
        self.troubles.pop(what, None)
        if text is not None:
            self.troubles[what] = text
        if self.troubles:
            latest, why = list(self.troubles.items())[-1]
            told = sentence(f"{latest}: {why[:500]}")
            stays = "" if self.state.last is None else " The last good state stays."
            self.say(escape(told) + stays, "bad")
        elif had:
            self.say("Ready.")

    # The sliders' point.

    def move_to(self, x: FloatArray) -> None:
        """Make `x` the point that the sliders show."""
        self.state.x = x.copy()
        self.mirror_sliders()
        self.follow()

    def set_input(self, index: int, shown: float) -> None:
        """Take a slider's place, in the unit that it shows."""
        one = next(d for d in self.state.dials if d.index == index)
        old = one.shown(self.state.x[index])
        if abs(shown - old) <= 1e-9 * max(abs(old), one.step):
            return  # the browser repeats what it was told
        self.state.x[index] = value = one.value(shown)
        if one.allowed is not None:
            shown = one.shown(value)
        handle = self.view.inputs.sliders[index]
        if handle.value != shown:  # set by us while the visitor moved it, or not allowed
            handle.value = shown
        self.follow()

    def mirror_sliders(self) -> None:
        """Let all sliders show the present point, also in a browser that missed something."""
        for one in self.state.dials:
            handle = self.view.inputs.sliders[one.index]
            value = one.shown(self.state.x[one.index])
            if handle.value != value:
                handle.value = value
            else:
                viser_internals.force_value(self.target.gui, handle)

    def follow(self) -> None:
        """Let the model, where it is fast enough, and the picture follow the sliders."""
        self.touched, self.moved_at = True, time.monotonic()
        if not (self.starting or self.state.slow):
            self.runs.ask(self.state.x)
        if self.state.model.has_picture:
            self.pictures.ask(OWN, self.state.x)

    # What is shown.

    def show_overlay(self, shown: bool) -> None:
        """Show both worst models, or hide them."""
        state = self.state
        state.overlay = shown and state.result is not None
        if state.result is not None and state.model.has_picture and state.overlay:
            for whose, x in zip((ONE, TWO), state.result.x, strict=True):
                self.pictures.ask(whose, x)
        self.touched = True

    def show_pace(self) -> None:
        """Offer what a slow model needs, and say what runs cost."""
        state, view = self.state, self.view
        view.running.run.visible = state.slow
        if state.slow and state.seconds is not None:
            view.running.run.label = f"Run the model here ({words.duration(state.seconds)})"
        view.study.drawn.show()
        view.search.cost.content = words.cost(state, {"At most": view.search.n_runs})
        studies = {} if view.study.in_surrogate else view.study.n_runs(state.model.n_free)
        view.study.cost.content = words.cost(state, studies)
        self.touched = True

    def draw(self) -> None:
        """Bring charts, numbers and picture up to date; nothing is computed."""
        self.touched = False
        state, view = self.state, self.view
        shown, colours = curves_of(state), view.colours
        with self.target.atomic():
            view.legend.content = words.legend(state, shown, colours)
            for chart in view.all_charts:
                chart.update(shown)
            view.numbers.content = words.numbers(state, view.single, shown, colours)
            view.error.content = words.error_line(state, shown)
            view.comparison.content = words.comparison(state, colours)
            if view.has_picture and not state.landscape_shown:
                self._draw_picture()

    def _draw_picture(self) -> None:
        state = self.state
        pictures: list[Sequence[Shape] | None] = [state.shapes.get(OWN)]
        pictures += [state.shapes.get(w) if state.overlay else None for w in (ONE, TWO)]
        self.frame = widened(self.frame, [p for p in pictures if p])
        if self.frame is not None:
            scene, colours = self.view.scene, self.view.colours
            scene.draw(pictures, self.frame, colours)
            scene.draw_scale(self.frame, state.model.picture_unit, colours)

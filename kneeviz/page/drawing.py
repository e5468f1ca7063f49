"""Brings a page's handles up to date with its state: the answer to a slider goes first."""

import time

import numpy as np
from numpy.typing import NDArray

from kneecore.knee.physics.forces import THETA_0
from kneecore.knee.physics.pose import STATION
from kneeviz.geometry.mechanism import Pose, tibia_at_contact
from kneeviz.page import belonging
from kneeviz.page.handles import draw_handles
from kneeviz.page.lesson import held_back, hides
from kneeviz.page.page import Page
from kneeviz.state.lesson_steps import ERROR
from kneeviz.state.motion import Poses
from kneeviz.state.shown import Markers, Shown
from kneeviz.views import theme
from kneeviz.views.charts import series
from kneeviz.views.html.marks import marks_line
from kneeviz.views.html.readout import error_line, readout

FloatArray = NDArray[np.float64]

_SEND_SECONDS = 0.004  # s: about what it takes to pack and send the curves
_REST_SECONDS = 0.1  # s: so much later what stands behind other tabs follows
_SLOW_FRAMES = 3  # hidden tabs, numbers and the position slider follow at a third of the rate


class Drawing:
    """Draws a page, frame by frame, and later what stands behind other tabs."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self.frame = 0
        """Frames drawn so far."""
        self.rest_at: float | None = None
        """When to draw what stands behind other tabs, s of `time.monotonic`."""

    def draw_load_free(self) -> None:
        """Draw the load-free knee, for which no kernel is needed."""
        page, x = self._page, self._page.state.x
        pose = Pose(
            flexion=THETA_0,
            moment=0.0,
            tibia_position=tibia_at_contact(x, THETA_0, STATION, 0.0),
            tension=np.zeros(4),
            contact_force=0.0,
        )
        page.view.scene.draw(x, pose)
        self._write_readout(pose)

    def draw(self) -> None:
        """Bring scene, charts and numbers up to date and send them off."""
        page = self._page
        current, poses = page.state.current, page.poses
        if current is None or poses[0] is None:
            page.target.flush()
            return
        touched, page.touched = page.touched, False
        self.frame += 1
        slow = touched or not page.playback.playing or self.frame % _SLOW_FRAMES == 0
        shown = shown_on(page)
        if slow:  # sixty curves cost a browser without a graphics card more than the knee
            page.view.curve.update(held_back(page, shown), Markers(poses=poses))
        if touched:  # the answer to a slider goes first
            page.target.flush()
            # The thread that sends it would have to wait for this one's next pause.
            time.sleep(_SEND_SECONDS)
        if not page.landscape.shown:
            self._draw_scene(current.x, poses)
        draw_handles(page, poses[0])
        page.target.flush()
        if slow:
            self._draw_slow(shown, poses, other_charts=not touched and self.rest_at is None)
        if touched and self.rest_at is None:
            self.rest_at = time.monotonic() + _REST_SECONDS

    def _draw_scene(self, x: FloatArray, poses: Poses) -> None:
        """Put the visitor's knee and the worst cases into their poses."""
        page = self._page
        assert poses[0] is not None
        with page.target.atomic():
            page.view.scene.draw(x, poses[0])
            page.view.scene.stand(page.apart)
            for i, knee in enumerate(page.knees[1:]):
                page.view.scene.draw_overlay(i, None if knee is None else knee.x, poses[i + 1])
            page.view.scene.ghosts.draw(ghosts_at(page, poses[0].moment))

    def _draw_slow(self, shown: Shown, poses: Poses, *, other_charts: bool) -> None:
        """Draw what need not follow every frame."""
        page = self._page
        assert poses[0] is not None
        self._write_readout(poses[0])
        self._mirror_position()
        page.view.transport.show_playing(page.playback.playing)
        if other_charts:
            page.view.show_other_charts(held_back(page, shown), Markers(poses=poses))
        page.target.flush()

    def draw_rest(self) -> bool:
        """Draw what stands behind other tabs, if there is a knee; return whether there is.

        A browser that draws it has no time for the knee.
        """
        page = self._page
        self.rest_at = None
        shown, poses = shown_on(page), page.poses
        if poses[0] is None:
            return False
        with page.target.atomic():
            page.view.show_other_charts(held_back(page, shown), Markers(poses=poses))
            self._show_numbers(shown)
        page.target.flush()
        return True

    def _write_readout(self, pose: Pose) -> None:
        page = self._page
        words = readout(pose, theme.palette(page.view.dark))
        belonging.write(page, "transport.readout", words)

    def _mirror_position(self) -> None:
        handle = self._page.view.transport.position
        value = round(100.0 * self._page.playback.share, 1)
        if handle.value != value:
            handle.value = value
            self._page.mirrored_at = time.monotonic()

    def _show_numbers(self, shown: Shown) -> None:
        page, state, error = self._page, self._page.state, None
        if shown.predicted is not None and shown.flexion is not None:
            error = series.prediction_error(shown.predicted, shown.flexion)
        loo = None if state.surrogate is None else state.surrogate.loo_rms
        told = "" if hides(page, ERROR) else error_line(error, loo)
        belonging.write(page, "error", told)
        mine = None if state.current is None else state.current.response
        belonging.write(page, "marks", marks_line(mine))
        _, *worst = (None if knee is None else knee.x for knee in page.knees)
        current = state.x if state.current is None else state.current.x
        page.view.show_comparison(state.space, (state.space.baseline, current, *worst))


def ghosts_at(page: Page, moment: float) -> list[tuple[FloatArray, Pose]]:
    """Return the earlier knees at rest under a moment; none beside a motion in time."""
    if page.playback.mode != "sweep":
        return []
    ghosts = belonging.ghosts(page)
    return [(g.x, g.sweep.at_moment(moment)) for g in ghosts if g.sweep is not None]


def shown_on(page: Page) -> Shown:
    """Return what a page's charts show now."""
    state, knees = page.state, (page.state.baseline, *page.knees)
    asks_surrogate = belonging.fits(page, belonging.SURROGATE)
    return Shown(
        sweeps=tuple(None if knee is None else knee.sweep for knee in knees),
        flexion=None if state.current is None else state.current.response.flexion,
        predicted=state.predicted if asks_surrogate else None,
        training=state.training_curves if asks_surrogate else None,
        strain_free=state.strain_free,
        band=belonging.band(page),
        ghosts=tuple(g.sweep for g in belonging.ghosts(page) if g.sweep is not None),
    )

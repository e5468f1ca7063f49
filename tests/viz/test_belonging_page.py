"""What belongs to something else on the running page: greyed, faded or gone, all together."""

from dataclasses import replace

import numpy as np
import pytest
from viz.conftest import eventually
from viz.visits import curve, press, wait_for_result, widget

import kneecore
from kneecore import NAMES, Knee, SamplingSettings
from kneeviz.actions import study
from kneeviz.page import belonging
from kneeviz.state.lesson_steps import STEPS
from kneeviz.state.shown import band_of
from kneeviz.views import theme

ACL_Y = NAMES.index("acl_femur_y")
GREY, CHANGED = "opacity:.45", "changed since"
TEXTS = ("found", "search.found", "search.table", "files.command")


def content(visitor, page, place):
    handle = page.view
    for name in place.split("."):
        handle = getattr(handle, name)
    return visitor.props[widget(handle)]["content"]


def colours_of_the_pair(visitor, page):
    """The two worst cases' colours in the chart."""
    return [
        line["stroke"] for line in visitor.props[widget(page.view.curve.handle)]["series"][-5:-3]
    ]


@pytest.fixture
def found(page, visitor):
    """The page with a search's pair and a sampling's band, all in their own colours."""
    page.post("start_over")
    eventually(lambda: page.snapshot().same_as(page.history.start))
    press(visitor, page.view.search.surrogate)
    wait_for_result(page)
    sampled = kneecore.monte_carlo(Knee(), SamplingSettings(n_samples=200))
    page.study.band, page.study.sampled = band_of(sampled, "200 samples"), sampled
    page.post("study_band", study.Asked(page.view.study.band, -1, True))
    visitor.wait(lambda c: np.isfinite(curve(c, page)[3]).any())
    visitor.wait(lambda c: "over-extends" in content(c, page, "found"))
    assert not any(GREY in content(visitor, page, place) for place in TEXTS)
    yield page
    page.study.sampled = page.study.band = None
    page.post("start_over")
    eventually(lambda: page.snapshot().same_as(page.history.start))


def test_other_bounds_grey_fade_and_take_away_all_at_once_and_undo_brings_all_back(found, visitor):
    page, hues = found, [theme.MODEL_1, theme.MODEL_2]
    visitor.wait(lambda c: colours_of_the_pair(c, page) == hues)
    visitor.set(widget(page.view.knee.bounds["geometry_mm"]), 0.8)
    for place in (*TEXTS, "study.sampled"):
        visitor.wait(
            lambda c, p=place: GREY in content(c, page, p) and CHANGED in content(c, page, p)
        )
    faded = theme.faded(theme.LIGHT, frozenset({"worst"}))
    visitor.wait(lambda c: colours_of_the_pair(c, page) == [faded.model_1, faded.model_2])
    visitor.wait(
        lambda c: tuple(c.scene["/worst_1/tibia/tibia"]["color"]) == theme.rgb(faded.model_1)
    )
    visitor.wait(lambda c: faded.model_1 in content(c, page, "comparison"))
    visitor.wait(lambda c: np.isnan(curve(c, page)[3]).all())
    assert "99.7" not in content(visitor, page, "curve_legend")
    press(visitor, page.view.transport.change, "Undo")
    for place in (*TEXTS, "study.sampled"):
        visitor.wait(lambda c, p=place: GREY not in content(c, page, p))
    visitor.wait(lambda c: colours_of_the_pair(c, page) == hues)
    visitor.wait(lambda c: np.isfinite(curve(c, page)[3]).any())
    visitor.wait(lambda c: "99.7" in content(c, page, "curve_legend"))


def test_the_last_good_knee_fades_where_the_model_fails(page, visitor, monkeypatch):
    solve = page.state.solve
    monkeypatch.setattr(page.state, "solve", lambda x: replace(solve(x), sweep=None))
    visitor.set(widget(page.view.knee.sliders[ACL_Y]), 0.2)
    visitor.wait(lambda c: "last good knee" in content(c, page, "transport.readout"))
    faded = theme.faded(theme.LIGHT, frozenset({"knee"}))
    visitor.wait(lambda c: tuple(c.scene["/knee/tibia/tibia"]["color"]) == faded.bone)
    monkeypatch.undo()
    visitor.set(widget(page.view.knee.sliders[ACL_Y]), 0.1)
    visitor.wait(lambda c: "last good knee" not in content(c, page, "transport.readout"))
    visitor.wait(lambda c: tuple(c.scene["/knee/tibia/tibia"]["color"]) == theme.LIGHT.bone)


class TestLandscape:
    @pytest.fixture
    def shown(self, found, visitor):
        press(visitor, found.view.study.landscape)
        eventually(lambda: found.landscape.origin is not None)
        eventually(lambda: belonging.fits(found, belonging.LANDSCAPE))
        yield found
        found.post("landscape")
        eventually(lambda: not found.landscape.shown)

    def test_rest_lengths_and_a_pair_of_32_values_do_not_break_it(self, shown, visitor):
        page, old = shown, shown.landscape.found
        visitor.set(widget(page.view.search.live), True)
        eventually(lambda: page.live.shown)
        visitor.set(widget(page.view.knee.bounds["rest_length_mm"]), 1.0)
        eventually(lambda: page.state.result is not None and len(page.state.result.x[0]) == 32)
        eventually(lambda: page.landscape.found is not old)
        eventually(lambda: page.landscape.found[0].knee.space is page.state.space)
        visitor.wait(lambda c: "simulated" in content(c, page, "study.key"))
        visitor.wait(lambda c: GREY not in content(c, page, "study.key"))
        status = content(visitor, page, "transport.status")
        assert "did not work" not in status
        visitor.set(widget(page.view.search.live), False)
        eventually(lambda: not page.live.on)

    def test_old_surfaces_are_greyed_while_new_ones_are_computed(self, shown, visitor, monkeypatch):
        page, ask = shown, shown.landscape.ask
        monkeypatch.setattr(page.landscape, "ask", lambda state: None)
        visitor.set(widget(page.view.knee.sliders[ACL_Y]), 0.4)
        visitor.wait(lambda c: "Knee changed since" in content(c, page, "study.key"))
        sheet = theme.rgb(theme.faded(theme.LIGHT, frozenset({"landscape"})).surrogate)
        visitor.wait(lambda c: tuple(c.scene["/landscape/surrogate"]["color"]) == sheet)
        ask(page.state)
        visitor.wait(lambda c: GREY not in content(c, page, "study.key"))


def test_nothing_says_live_once_it_is_off(page, visitor):
    visitor.set(widget(page.view.search.live), True)
    visitor.wait(lambda c: "Live" in content(c, page, "search.live_note"))
    visitor.set(widget(page.view.search.live), False)
    eventually(lambda: not page.live.on)
    visitor.wait(lambda c: content(c, page, "search.live_note") == "")
    visitor.wait(lambda c: "Live:" not in content(c, page, "transport.status"))
    assert "Live" not in content(visitor, page, "found")


def test_the_lesson_has_a_state_of_its_own_and_gives_the_visitors_back(found, visitor):
    page, learn = found, found.view.learn
    visitor.set(widget(page.view.knee.bounds["geometry_mm"]), 3.0)
    visitor.set(widget(page.view.knee.sliders[ACL_Y]), 0.5)
    eventually(lambda: page.state.x[ACL_Y] == pytest.approx(0.5e-3))
    eventually(lambda: page.history.present.same_as(page.snapshot()))
    visitor.set(widget(page.view.look.forces), True)
    visitor.set(widget(page.view.look.mode), "In time, flexing")
    eventually(lambda: page.view.scene.forces and page.playback.mode == "flexion")
    mine, history = page.snapshot(), page.history
    press(visitor, learn.press)
    for number, step in enumerate(STEPS[:7]):
        eventually(lambda n=number: page.lesson == n)
        eventually(lambda: page.state.bounds.geometry_mm is None and not page.overlay)
        visitor.wait(lambda c: content(c, page, "found") == "")
        if step.title != "Evolution finds the extremes":
            press(visitor, learn.turn, "Next")
    press(visitor, learn.turn, "Next")  # without a search
    wait_for_result(page)
    visitor.wait(lambda c: "over-extends" in content(c, page, "found"))
    press(visitor, learn.turn, "Back")
    visitor.wait(lambda c: content(c, page, "found") == "")
    press(visitor, learn.turn, "Next")
    eventually(lambda: page.lesson == 7)
    press(visitor, learn.turn, "Next")
    eventually(lambda: page.lesson is None and page.snapshot().same_as(mine))
    eventually(lambda: page.history is history and page.history.present.same_as(mine))
    eventually(lambda: page.view.scene.forces and page.playback.mode == "flexion")
    press(visitor, page.view.transport.change, "Undo")
    eventually(lambda: page.state.x[ACL_Y] != mine.x[ACL_Y])
    visitor.set(widget(page.view.look.mode), "Through the loads")
    eventually(lambda: page.playback.mode == "sweep")

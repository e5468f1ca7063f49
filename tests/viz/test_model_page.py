"""The page for a model of one's own, in the real server, spoken to without a browser."""

import threading

import models
import numpy as np
import pytest
from viz.conftest import eventually
from viz.visits import press, widget
from viz.websocket_client import WebSocketClient

import kneecore
from kneecore import ParameterError
from kneeviz.anymodel import pictures, state
from kneeviz.anymodel.actions.table import ACTIONS
from kneeviz.anymodel.pictures import OWN
from kneeviz.anymodel.views.commands import COMMANDS
from kneeviz.jobs.messages import Asked
from kneeviz.jobs.uploads import Uploaded, parse
from kneeviz.server.app import App

CRANK, ROD, OFFSET = range(3)


@pytest.fixture(scope="module")
def app():
    """A slider-crank: a curve, a number and a picture."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(state, "FAST_SECONDS", 5.0)  # fast also where the machine is busy
        running = App(port=0, model=models.slider_crank())
        try:
            eventually(lambda: running.page.state.surrogate is not None)
            yield running
        finally:
            running.stop()


@pytest.fixture
def page(app):
    """The page with all sliders at home, and nothing running."""
    page = app.page
    page.post("home", None)
    eventually(lambda: page.state.at_home and page.state.is_here and page.state.job is None)
    return page


@pytest.fixture
def visitor(app):
    with WebSocketClient(app.server.get_port()) as client:
        client.wait(lambda c: c.counts.get("ReplayDoneMessage"))
        eventually(app.server.get_clients)
        yield client


def text(visitor, handle):
    return visitor.props[widget(handle)]["content"]


def line(visitor, page, series):
    """One of a chart's lines: 1, 2 the band, 3 nominal, 4 own, 5 surrogate, 6, 7 the worst."""
    return visitor.props[widget(page.view.charts.charts[0].handle)]["data"][series]


def searched(page, visitor):
    """A search's result, found on the page."""
    if page.state.result is None:
        press(visitor, page.view.search.start)
        eventually(lambda: page.state.result is not None and page.state.job is None)
    return page.state.result


class TestSliders:
    def test_a_slider_has_the_inputs_name_unit_bounds_and_home(self, page, visitor):
        rod = visitor.props[widget(page.view.inputs.sliders[ROD])]
        assert (rod["label"], rod["min"], rod["max"]) == ("rod (mm)", 118.5, 121.5)
        assert "118.500 mm to 121.500 mm, at home 120.000 mm" in rod["hint"]
        assert visitor.values[widget(page.view.inputs.sliders[ROD])] == 120.0

    def test_curve_surrogate_picture_and_number_follow_it(self, page, visitor):
        before = visitor.scene["/model/own"]["points"].copy()
        visitor.set(widget(page.view.inputs.sliders[CRANK]), 51.0)
        x = np.array([51.0, 120.0, 0.0])
        y = np.array(models.slider_crank_y(x))
        visitor.wait(lambda c: np.allclose(line(c, page, 4), y[:5]))
        np.testing.assert_array_equal(page.state.x, [page.state.model.upper[0], 120.0, 0.0])
        np.testing.assert_allclose(line(visitor, page, 5), y[:5], atol=0.05)
        np.testing.assert_allclose(line(visitor, page, 3), models.slider_crank_y([50, 120, 0])[:5])
        visitor.wait(lambda c: not np.array_equal(c.scene["/model/own"]["points"], before))
        visitor.wait(lambda c: "stroke ratio" in text(c, page.view.numbers))

    def test_all_go_home(self, page, visitor):
        visitor.set(widget(page.view.inputs.sliders[OFFSET]), -4.0)
        eventually(lambda: page.state.x[OFFSET] == -4.0)
        press(visitor, page.view.inputs.home)
        eventually(lambda: page.view.inputs.sliders[OFFSET].value == 0.0)
        assert page.state.at_home

    def test_what_is_no_value_of_a_slider_is_not_taken(self, page, visitor):
        visitor.set(widget(page.view.inputs.sliders[CRANK]), 99.0)
        visitor.wait(lambda c: c.notifications)
        assert page.state.at_home


class TestSearch:
    def test_it_is_the_models_own_search_with_its_verdict(self, page, visitor):
        found = searched(page, visitor)
        expected = kneecore.worst_case(models.slider_crank())
        np.testing.assert_array_equal(found.x, expected.x)
        assert found.verdict == expected.verdict
        visitor.wait(lambda c: "Verdict: " in text(c, page.view.search.found))
        told = text(visitor, page.view.search.found)
        assert found.verdict.word in told
        assert found.verdict.outlook in told
        assert "gap" in told

    def test_both_are_drawn_over_the_own_one_and_can_be_hidden(self, page, visitor):
        found = searched(page, visitor)
        page.post("overlay", Asked(page.view.search.overlay, -1, True))
        visitor.wait(lambda c: np.allclose(line(c, page, 6), found.y[0, :5]))
        np.testing.assert_allclose(line(visitor, page, 7), found.y[1, :5])
        for name in ("/model/worst_1", "/model/worst_2"):
            visitor.wait(lambda c, n=name: len(c.scene[n].get("points", ())) > 6)
        one, two = (visitor.scene[f"/model/worst_{k}"]["points"] for k in (1, 2))
        assert not np.array_equal(one, two)
        visitor.set(widget(page.view.search.overlay), False)
        visitor.wait(lambda c: np.isnan(line(c, page, 6)).all())
        eventually(lambda: not page.view.scene.lines[1].visible)

    def test_make_one_mine(self, page, visitor):
        found = searched(page, visitor)
        press(visitor, page.view.search.adopt, "Model 2")
        eventually(lambda: np.array_equal(page.state.x, found.x[1]) and page.state.is_here)

    def test_the_surrogate_beside_the_model_is_then_the_repaired_one(self, page, visitor):
        found = searched(page, visitor)
        eventually(lambda: len(page.state.surrogate.training_x) == len(found.training_x))

    def test_one_thing_at_a_time(self, page, visitor):
        page.post(("study", "sampling"), None)
        page.post("search", Asked(None, next(iter(page.clients())), True))
        visitor.wait(lambda c: c.notifications)
        assert "running" in visitor.notifications[0]["props"]["body"]
        eventually(lambda: page.state.job is None)


class TestStudy:
    def test_the_band_is_drawn_behind_the_curves(self, page, visitor):
        press(visitor, page.view.study.runs["sampling"])
        eventually(lambda: page.state.sampled is not None and page.state.job is None)
        expected = page.state.sampled.y.percentile_lower[:5]
        visitor.wait(lambda c: np.allclose(line(c, page, 1), expected))
        assert "10,000 runs of the slider-crank" in text(visitor, page.view.study.sampled)
        visitor.set(widget(page.view.study.band), False)
        visitor.wait(lambda c: np.isnan(line(c, page, 1)).all())

    def test_influence_of_the_surrogate(self, page, visitor):
        visitor.set(widget(page.view.study.of), "Its surrogate")
        eventually(lambda: page.view.study.in_surrogate)
        press(visitor, page.view.study.runs["influence"])
        content = widget(page.view.influence.content)
        visitor.wait(lambda c: "surrogate of slider-crank" in c.props[content]["content"])
        assert "decide" in visitor.props[content]["content"]
        page.view.study.of.value = "The model"

    def test_a_landscape_takes_the_pictures_place_and_gives_it_back(self, page, visitor):
        press(visitor, page.view.study.runs["landscape"])
        eventually(lambda: page.state.landscape_shown)
        visitor.wait(lambda c: "441 runs" in text(c, page.view.study.key))
        np.testing.assert_array_equal(page.state.landscape.x, page.state.model.nominal)
        visitor.set(widget(page.view.inputs.sliders[ROD]), 121.0)  # neither of the two
        eventually(lambda: page.state.landscape.x[ROD] == 121.0)
        eventually(lambda: page.state.job is None)
        page.post(("study", "landscape"), None)
        eventually(lambda: not page.state.landscape_shown)

    def test_inputs_are_drawn_as_is_chosen(self, page):
        drawn = page.view.study.drawn
        kind, far = (drawn.by_name[f"study.{n}.rod"] for n in ("distribution", "deviations"))
        assert not far.visible
        for handle, value in ((kind, "normal"), (far, 2.0)):
            handle.value = value
            page.post(("setting", "study"), Asked(handle, -1, value))
        eventually(lambda: far.visible)
        assert drawn.chosen == {"rod": ("normal", 2.0)}
        before = page.state.sampled
        page.post(("study", "sampling"), None)
        eventually(lambda: page.state.sampled is not before and page.state.job is None)
        assert page.state.sampled.model.drawn_as == "2 uniform, 1 normal with bounds at 2 sd"
        assert "1 normal with bounds at 2 sd" in page.view.study.sampled.content
        kind.value = "uniform"
        page.post(("setting", "study"), Asked(kind, -1, "uniform"))
        eventually(lambda: not far.visible)
        assert drawn.chosen == {}


class TestFiles:
    def test_a_result_goes_out_and_comes_back_as_it_was(self, page, visitor):
        found = searched(page, visitor)
        press(visitor, page.view.files.result["result.json"])
        visitor.wait(lambda c: c.downloads.get("result.json", b"").endswith(b"}\n"))
        page.state.result = None
        content = visitor.downloads["result.json"]
        loaded = parse("result.json", content)  # in this process: another takes its time
        page.post(("uploaded", 0), Uploaded("result.json", 0, loaded, None))
        eventually(lambda: page.state.result is not None)
        np.testing.assert_array_equal(page.state.result.x, found.x)
        assert page.state.result.to_json().encode() == content

    def test_a_knee_is_none_of_this_models_and_told_once(self, page, visitor):
        content, before = kneecore.asset_path("baseline.toml").read_bytes(), page.state.result
        visitor.upload(widget(page.view.files.upload), "knee.toml", content)
        visitor.wait(lambda c: c.notifications)
        assert "this page's" in visitor.notifications[0]["props"]["body"]
        assert page.state.result is before


def test_a_model_that_is_fast_enough_follows_the_sliders(page):
    assert page.state.fast
    assert not page.view.running.run.visible


def test_from_the_keyboard(page, visitor):
    dark = page.view.dark
    page.post(("toggle", "dark"), Asked(None, -1, True))
    eventually(lambda: page.view.dark is not dark and page.view.dark_box.value is not dark)
    page.post(("toggle", "dark"), Asked(None, -1, True))
    eventually(lambda: page.view.dark is dark)
    page.post("cancel", Asked(None, next(iter(page.clients())), True))
    visitor.wait(lambda c: "Nothing is running." in str(c.notifications))
    assert {c.key if isinstance(c.key, str) else c.key[0] for c in COMMANDS} <= set(ACTIONS)


def test_a_picture_that_cannot_be_drawn_leaves_the_last_one(page, monkeypatch):
    crank = np.array([[0.0, 0.0], [0.0, 50.0]])
    eventually(lambda: np.allclose(page.state.shapes[OWN][0].points, crank))

    def draw(_):
        raise ValueError("no <place>")

    monkeypatch.setattr(page.pictures._model, "_draw", draw)
    page.post(("input", CRANK), Asked(None, -1, 50.5))
    eventually(lambda: "raised ValueError: no &lt;place&gt;" in page.view.running.status.content)
    np.testing.assert_allclose(page.state.shapes[OWN][0].points, crank, atol=1e-9)
    eventually(lambda: page.state.last.x[CRANK] == 50.5)


def test_a_picture_that_does_not_come_is_a_line_and_the_page_goes_on(page, monkeypatch):
    """It is not asked for again until it has come; then the latest is drawn, and the line goes."""
    returned, calls, usual = threading.Event(), [], page.pictures._model._draw

    def draw(x):
        calls.append(x[CRANK])
        assert returned.wait(60.0)
        return usual(x)

    monkeypatch.setattr(pictures, "PATIENCE", 0.1)
    monkeypatch.setattr(page.pictures._model, "_draw", draw)
    page.post(("input", CRANK), Asked(None, -1, 50.5))
    eventually(lambda: "`draw` has not returned for 0.1 s" in page.view.running.status.content)
    page.post(("input", CRANK), Asked(None, -1, 51.0))
    eventually(lambda: page.state.last.x[CRANK] == 51.0)
    assert calls == [50.5]
    returned.set()
    eventually(lambda: np.allclose(page.state.shapes[OWN][0].points[1], [0.0, 51.0]))
    eventually(lambda: "`draw`" not in page.view.running.status.content)


def test_what_a_page_cannot_open_with():
    other = kneecore.worst_case(
        models.two_units(), kneecore.SearchSettings(pop_size=20, n_generations=2)
    )
    with pytest.raises(kneecore.FileFormatError, match="this page's"):
        App(port=0, model=models.slider_crank(), result=other)
    with pytest.raises(ParameterError, match="only one"):
        App(port=0, model=models.slider_crank(), knee=kneecore.packaged_knee())

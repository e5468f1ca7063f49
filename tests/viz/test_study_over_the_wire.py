"""The study in the real server: sampling, influence, landscape, files, spoken to over the wire."""

import io
import json
import re
import time
import zipfile

import numpy as np
import pytest
from viz.conftest import eventually
from viz.wire_client import CAMERA, WireClient

import kneecore
from kneecore import NAMES
from kneeviz import viser_internals as wire
from kneeviz.geometry import surfaces as landscape
from kneeviz.views.html.study import HEIGHTS, LOADS, with_unit
from kneeviz.views.scene import landscape as landscape_scene
from kneeviz.views.tabs import controls
from kneeviz.views.tabs import study as study_tab

SHEETS = ("/landscape/model", "/landscape/surrogate")


def widget(handle):
    return wire.widget_id(handle)


def press(visitor, handle, value=True):
    visitor.set(widget(handle), value)


def text(visitor, handle):
    return visitor.props[widget(handle)]["content"]


def download(visitor, handle, name, size=500):
    """Press a file's button once it can be pressed; return when `size` bytes are there."""
    eventually(lambda: not handle.disabled)
    visitor.downloads.pop(name, None)
    press(visitor, handle)
    visitor.wait(lambda c: len(c.downloads.get(name, b"")) >= size)
    return visitor.downloads[name]


def asked(value):
    return controls.Asked(None, -1, value)


@pytest.fixture
def study(session, visitor):
    """The study's tab, with the landscape closed and nothing running or found."""
    desk, tab = session.study, session.view.study
    eventually(lambda: desk.job is None)
    desk.sampled = desk.influence = desk.paper = session.state.result = None
    desk.with_band = True
    if session.state.bounds.geometry_mm not in (None, 1.0):
        session.post(("bound", "geometry_mm"), asked(1.0))
        eventually(lambda: session.state.bounds.geometry_mm == 1.0)
    session.post("influence_chart", asked(study_tab.BARS))
    session.post(("landscape_look", "zoom"), asked(False))
    if session.landscape.shown:
        session.post("landscape")
    eventually(lambda: not session.landscape.shown and session.band is None)
    return tab


def sampled(session, visitor, tab, n_samples=500, seed=4):
    visitor.set(widget(tab.n_samples), n_samples)
    visitor.set(widget(tab.seed), seed)
    eventually(lambda: (tab.n_samples.value, tab.seed.value) == (n_samples, seed))
    press(visitor, tab.runs["sampling"])
    eventually(lambda: session.study.sampled is not None)
    eventually(lambda: session.study.job is None)
    return session.study.sampled


def bound(visitor, session, value):
    visitor.set(widget(session.view.knee.bounds["geometry_mm"]), value)
    eventually(lambda: session.state.bounds.geometry_mm == value)


class TestSampling:
    def test_the_band_is_that_of_the_library(self, session, visitor, study):
        found = sampled(session, visitor, study)
        same = kneecore.monte_carlo(n_samples=500, seed=4, threads=1)
        np.testing.assert_array_equal(found.flexion_deg.mean, same.flexion_deg.mean)
        eventually(lambda: session.band is not None)
        np.testing.assert_array_equal(session.band.lower_deg, same.flexion_deg.percentile_lower)
        np.testing.assert_array_equal(session.band.upper_deg, same.flexion_deg.percentile_upper)
        visitor.wait(lambda c: "500 knees" in text(c, study.sampled))
        shown = text(visitor, study.sampled)
        assert "0 failed" in shown
        assert f"{found.n_unsettled:,} not at rest" in shown
        assert f"{found.flexion_deg.sd[5]:.1f}" in shown
        legend = widget(session.view.curve_legend)
        visitor.wait(lambda c: "500 samples" in c.props[legend]["content"])

    def test_a_second_sampling_draws_its_own_band(self, session, visitor, study):
        sampled(session, visitor, study)
        eventually(lambda: session.band is not None)
        first = session.study.band
        visitor.set(widget(study.seed), 5)
        eventually(lambda: study.seed.value == 5)
        press(visitor, study.runs["sampling"])
        eventually(lambda: session.study.band is not first and session.study.job is None)
        eventually(lambda: session.band is session.study.band)
        assert not np.array_equal(session.band.lower_deg, first.lower_deg)

    def test_the_box_takes_the_band_away_and_brings_it_back(self, session, visitor, study):
        sampled(session, visitor, study)
        eventually(lambda: session.band is session.study.band)
        visitor.set(widget(study.band), False)
        eventually(lambda: session.band is None)
        visitor.set(widget(study.band), True)
        eventually(lambda: session.band is session.study.band)

    def test_other_bounds_make_it_stale_until_they_come_back(self, session, visitor, study):
        sampled(session, visitor, study)
        eventually(lambda: session.band is not None)
        bound(visitor, session, 0.8)
        visitor.wait(lambda c: "Bounds changed" in text(c, study.sampled))
        eventually(lambda: session.band is None)
        bound(visitor, session, 1.0)
        visitor.wait(lambda c: "Bounds changed" not in text(c, study.sampled))
        eventually(lambda: session.band is session.study.band)

    def test_a_cancelled_one_leaves_what_there_was(self, session, visitor, study):
        before = sampled(session, visitor, study)
        visitor.set(widget(study.n_samples), 1_000_000)
        eventually(lambda: study.n_samples.value == 1_000_000)
        press(visitor, study.runs["sampling"])
        eventually(lambda: session.study.job is not None and study.progress.visible)
        visitor.wait(lambda c: 0 < (c.values.get(widget(study.progress)) or 0) < 100)
        assert study.runs["influence"].disabled
        press(visitor, study.cancel)
        eventually(lambda: session.study.job is None)
        assert session.study.sampled is before
        eventually(lambda: not study.runs["influence"].disabled)
        status = session.view.transport.status
        visitor.wait(lambda c: "study was cancelled" in text(c, status))

    def test_a_second_one_at_once_is_refused_and_told(self, session, visitor, study):
        study.n_samples.value = 1_000_000
        session.post(("study", "sampling"))
        eventually(lambda: session.study.job is not None)
        job, client = session.study.job, next(iter(session.clients()))
        session.post(("study", "influence"), controls.Asked(None, client, True))
        visitor.wait(lambda c: c.notifications)
        assert session.study.job is job
        session.post("study_cancel")
        eventually(lambda: session.study.job is None)

    def test_sliders_answer_while_it_runs(self, session, visitor, study):
        study.n_samples.value = 1_000_000
        session.post(("study", "sampling"))
        eventually(lambda: session.study.job is not None)
        visitor.set(widget(session.view.knee.sliders[0]), -13.5)
        eventually(lambda: session.state.current.x[0] == pytest.approx(-13.5e-3), 10.0)
        assert session.study.job is not None
        session.post("study_cancel")
        eventually(lambda: session.study.job is None)


class TestInfluence:
    @pytest.fixture
    def found(self, session, visitor, study):
        visitor.set(widget(study.n_base), "256")
        eventually(lambda: study.n_base.value == "256")
        press(visitor, study.runs["influence"])
        eventually(lambda: session.study.influence is not None)
        return session.study.influence

    def test_bars_for_the_chosen_load(self, session, visitor, study, found):
        tab = session.view.influence
        first, second = (
            found.deciding(moment, 1)[0].replace("_", " ").capitalize() for moment in (5.0, -0.1)
        )
        bar = re.compile(r"<title>([^:]+): total")
        visitor.wait(lambda c: bar.search(text(c, tab.content)))
        assert bar.search(text(visitor, tab.content)).group(1).lower() == first.lower()
        label = next(name for name, moment in LOADS.items() if moment == -0.1)
        visitor.set(widget(tab.load), label)
        visitor.wait(lambda c: "At -0.1 N·m" in text(c, tab.content))
        assert bar.search(text(visitor, tab.content)).group(1).lower() == second.lower()
        visitor.set(widget(tab.load), next(iter(LOADS)))
        eventually(lambda: session.study.load == 5)

    def test_the_other_charts(self, session, visitor, study, found):
        tab = session.view.influence
        press(visitor, tab.chart, study_tab.MAP)
        visitor.wait(lambda c: "at -5 N·m:" in text(c, tab.content))
        press(visitor, tab.chart, study_tab.SLOPES)
        visitor.wait(lambda c: "Search for them first" in text(c, tab.content))
        session.post(("search", "surrogate"))
        visitor.wait(lambda c: "half-range more" in text(c, tab.content))

    def test_before_and_stale(self, session, visitor, study):
        tab = session.view.influence
        session.touch()
        press(visitor, tab.chart, study_tab.MAP)
        visitor.wait(lambda c: "Press <b>Influence</b>" in text(c, tab.content))

    def test_files_are_those_of_the_command_line(self, session, visitor, study, found):
        sampled(session, visitor, study)
        names = ("uncertainty.json", "influence.json", "influence.csv")
        files = {name: download(visitor, study.files[name], name) for name in names}
        document = json.loads(files["uncertainty.json"])
        assert document["n_samples"] == 500
        assert document["influence"]["n_base"] == 256
        assert document["comparison"] is None
        assert json.loads(files["influence.json"]) == found.to_dict()
        assert files["influence.csv"].decode() == found.to_csv()

    def test_a_worst_case_found_later_has_no_place_among_the_samples(self, session, visitor, study):
        """Its shares were counted for no worst case; nothing may be made up."""
        sampled(session, visitor, study)
        session.post(("search", "surrogate"))
        eventually(lambda: session.job is None and session.state.result is not None)
        name = "uncertainty.json"
        document = json.loads(download(visitor, study.files[name], name))
        assert document["comparison"]["share_of_samples_below"] is None
        session.study.sampled = None
        sampled(session, visitor, study)
        again = json.loads(download(visitor, study.files[name], name))
        assert np.shape(again["comparison"]["share_of_samples_below"]) == (2, 12)
        counted_for = session.state.result
        session.post(("search", "surrogate"))
        eventually(lambda: session.job is None and session.state.result is not counted_for)
        third = json.loads(download(visitor, study.files[name], name))
        assert third["comparison"]["share_of_samples_below"] is None


class TestLandscape:
    def show(self, session, visitor, tab):
        press(visitor, tab.landscape)
        eventually(lambda: session.landscape.shown)
        visitor.wait(lambda c: "vertices" in c.scene.get(SHEETS[0], {}))
        visitor.wait(lambda c: "knees simulated" in text(c, tab.key))

    def sheet(self, visitor, name=SHEETS[0]):
        return visitor.scene[name]["vertices"].reshape(33, 33, 3)

    def heights(self, session, visitor, name=SHEETS[0]):
        shown = landscape.box_around(self.picture(session), zoom=session.landscape.zoom)
        up = self.sheet(visitor, name)[..., 1]
        share = (up - landscape.CENTRE[1]) / landscape.HEIGHT + 0.5
        return shown.low + share * (shown.high - shown.low)

    def picture(self, session):
        from kneeviz.actions.landscape import _picture

        return _picture(session)

    def test_both_sheets_are_the_librarys(self, session, visitor, study):
        self.show(session, visitor, study)
        state = session.state
        same = kneecore.landscape(
            state.space.baseline, session.landscape.names, surrogate=state.surrogate, threads=1
        )
        for name, angles in zip(SHEETS, (same.model_deg, same.surrogate_deg), strict=True):
            visitor.wait(
                lambda c, n=name, a=angles: np.allclose(
                    self.heights(session, c, n), a[..., 5], atol=1e-3
                )
            )
        error = np.abs(same.error("+5 N m"))
        assert f"{error.mean():.2f}°" in text(visitor, study.key)
        assert f"{error.max():.2f}°" in text(visitor, study.key)

    def test_the_knee_gives_way_and_comes_back(self, session, visitor, study):
        shown = {}

        def watch(message):
            if message["type"] == "SetSceneNodeVisibilityMessage":
                shown[message["name"]] = message["visible"]

        with WireClient(visitor.port, on_message=watch) as other:
            other.wait(lambda c: c.counts.get("ReplayDoneMessage"))
            self.show(session, visitor, study)
            other.wait(lambda _: shown.get("/landscape") is True)
            assert not any(shown[f"/{name}"] for name in ("knee", "worst_1", "worst_2"))
            press(visitor, study.landscape)
            other.wait(lambda _: shown["/landscape"] is False and shown["/knee"])
        assert study.landscape.label == study_tab.SHOW

    def test_the_camera_comes_back_to_where_it_was(self, session, visitor, study):
        seen = []

        def watch(message):
            if message["type"] == "SetCameraPositionMessage":
                seen.append(tuple(message["position"]))

        with WireClient(visitor.port, on_message=watch) as other:
            other.wait(lambda c: c.counts.get("ReplayDoneMessage"))
            # It is placed when it joins: its camera freed, moved and locked, its charts watched.
            other.wait(lambda c: c.counts.get("RunJavascriptMessage", 0) >= 3)
            mine = (0.1, 0.2, 1.5)
            other.send(CAMERA | {"position": mine})
            eventually(
                lambda: any(
                    np.allclose(c.camera.position, mine) for c in session.clients().values()
                )
            )
            self.show(session, visitor, study)
            other.wait(lambda _: np.allclose(seen[-1], landscape_scene.camera_position()))
            press(visitor, study.landscape)
            other.wait(lambda _: np.allclose(seen[-1], mine))

    def test_it_follows_a_slider_and_rests_while_hidden(self, session, visitor, study):
        self.show(session, visitor, study)
        first = session.landscape.found
        slider = session.view.knee.sliders[NAMES.index("lcl_femur_y")]
        visitor.set(widget(slider), slider.max)
        eventually(lambda: session.landscape.found is not first)
        eventually(lambda: np.array_equal(session.landscape.found[0].x, session.state.current.x))
        knee = np.array(session.state.current.x)
        axis = session.landscape.found[1].axes
        knee[[NAMES.index(n) for n in session.landscape.names]] = axis[0][7], axis[1][30]
        want = np.degrees(kneecore.simulate(knee).flexion[5])
        visitor.wait(lambda c: abs(self.heights(session, c)[7, 30] - want) < 1e-3)
        eventually(lambda: session.landscape.found[0] is session.landscape._asked)
        press(visitor, study.landscape)
        eventually(lambda: not session.landscape.shown)
        before = session.landscape.found
        visitor.set(widget(slider), slider.min)
        eventually(lambda: not np.array_equal(session.state.current.x, before[0].x))
        time.sleep(0.5)
        assert session.landscape.found is before

    def test_what_stands_upright_and_on_the_axes(self, session, visitor, study):
        self.show(session, visitor, study)
        label = next(k for k, name in HEIGHTS.items() if name == "-2 N m")
        visitor.set(widget(study.height), label)
        eventually(lambda: session.landscape.height == "-2 N m")
        found = session.landscape.found[1]
        visitor.wait(
            lambda c: np.allclose(self.heights(session, c), found.reading("-2 N m"), atol=1e-3)
        )
        one, two = session.landscape.names
        visitor.set(widget(study.axes[0]), with_unit(two))
        eventually(lambda: session.landscape.names == (two, one))
        visitor.wait(lambda c: c.values[widget(study.axes[1])] == with_unit(one))
        session.post(("landscape_axis", 0), asked(with_unit(one)))
        session.post(("landscape_look", "height"), asked(tuple(HEIGHTS)[1]))

    def test_the_worst_cases_are_marked(self, session, visitor, study):
        self.show(session, visitor, study)
        assert self.picture(session).worst == (None, None)
        session.post(("search", "surrogate"))
        eventually(lambda: session.state.result is not None)
        visitor.wait(lambda c: "model 2" in text(c, study.key))
        one, two = self.picture(session).worst
        result = session.state.result
        assert one.value == pytest.approx(np.degrees(result.model_1.flexion[5]))
        assert two.value == pytest.approx(np.degrees(result.model_2.flexion[5]))

    def test_held_parameters_leave_its_axes(self, session, visitor, study):
        self.show(session, visitor, study)
        visitor.set(widget(session.view.knee.case), "material")
        visitor.wait(lambda c: len(c.props[widget(study.axes[0])].get("options", ())) == 6)
        eventually(lambda: session.landscape.found[1].space is session.state.space)
        visitor.set(widget(session.view.knee.case), "both")
        visitor.wait(lambda c: len(c.props[widget(study.axes[0])].get("options", ())) == 28)

    def test_the_flat_view_closes_it(self, session, visitor, study):
        self.show(session, visitor, study)
        press(visitor, session.view.transport.view, "2D")
        eventually(lambda: not session.landscape.shown)


def test_the_paper_claim_by_claim(session, visitor, study):
    press(visitor, study.runs["report"])
    eventually(lambda: session.study.paper is not None, 120.0)
    words = [" claims: ", "agree, ", "cannot be compared"]
    visitor.wait(lambda c: all(w in text(c, study.judged) for w in words))
    made = session.study.paper
    page = download(visitor, study.files["paper.html"], "paper.html", len(made.page))
    assert page == made.page
    assert page.rstrip().endswith(b"</html>")
    packed = download(visitor, study.files["paper.zip"], "paper.zip", len(made.everything))
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        assert {"paper.md", "paper.json", "uncertainty.json"} <= set(archive.namelist())
        assert json.loads(archive.read("paper.json"))["quick"] is True

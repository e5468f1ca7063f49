"""The study in the real server, spoken to over a WebSocket: sampling, influence, landscape."""

import io
import json
import re
import time
import zipfile

import numpy as np
import pytest
from viz.conftest import eventually
from viz.visits import press, widget
from viz.websocket_client import CAMERA, WebSocketClient

import kneecore
from kneecore import NAMES
from kneecore.files.influence import to_csv
from kneeviz.actions.landscape import picture_of
from kneeviz.geometry import surfaces
from kneeviz.jobs.messages import Asked
from kneeviz.state.study import BARS, HEAT_MAP, SLOPES
from kneeviz.views.html.labels import HEIGHTS, LOADS, with_unit
from kneeviz.views.html.pieces import plain
from kneeviz.views.tabs.study import SHOW

SHEETS = ("/landscape/model", "/landscape/surrogate")


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
    return Asked(None, -1, value)


@pytest.fixture
def study(page, visitor):
    """The study's tab, with the landscape closed and nothing running or found."""
    found, tab = page.study, page.view.study
    eventually(lambda: found.job is None)
    found.sampled = found.influence = found.paper = found.accuracy = None
    page.state.result = None
    found.with_band = True
    if page.state.bounds.geometry_mm not in (None, 1.0):
        page.post(("bound", "geometry_mm"), asked(1.0))
        eventually(lambda: page.state.bounds.geometry_mm == 1.0)
    page.post("influence_chart", asked(BARS))
    page.post(("landscape_look", "zoom"), asked(False))
    if page.landscape.shown:
        page.post("landscape")
    eventually(lambda: not page.landscape.shown and page.band is None)
    return tab


def sampled(page, visitor, tab, n_samples=500, seed=4):
    visitor.set(widget(tab.n_samples), n_samples)
    visitor.set(widget(tab.seed), seed)
    eventually(lambda: (tab.n_samples.value, tab.seed.value) == (n_samples, seed))
    press(visitor, tab.runs["sampling"])
    eventually(lambda: page.study.sampled is not None)
    eventually(lambda: page.study.job is None)
    return page.study.sampled


def bound(visitor, page, value):
    visitor.set(widget(page.view.knee.bounds["geometry_mm"]), value)
    eventually(lambda: page.state.bounds.geometry_mm == value)


class TestSampling:
    def test_the_band_is_that_of_the_library(self, page, visitor, study):
        found = sampled(page, visitor, study)
        same = kneecore.monte_carlo(
            kneecore.Knee(threads=1), kneecore.SamplingSettings(n_samples=500, seed=4)
        )
        np.testing.assert_array_equal(found.y.mean, same.y.mean)
        eventually(lambda: page.band is not None)
        np.testing.assert_array_equal(page.band.lower_deg, same.y.percentile_lower)
        np.testing.assert_array_equal(page.band.upper_deg, same.y.percentile_upper)
        visitor.wait(lambda c: "500 knees" in text(c, study.sampled))
        shown = text(visitor, study.sampled)
        assert "0 failed" in shown
        assert f"{found.counts['unsettled']:,} unsettled" in shown
        assert f"{found.y.sd[5]:.1f}" in shown
        legend = widget(page.view.curve_legend)
        visitor.wait(lambda c: "500 samples" in c.props[legend]["content"])

    def test_a_second_sampling_draws_its_own_band(self, page, visitor, study):
        sampled(page, visitor, study)
        eventually(lambda: page.band is not None)
        first = page.study.band
        visitor.set(widget(study.seed), 5)
        eventually(lambda: study.seed.value == 5)
        press(visitor, study.runs["sampling"])
        eventually(lambda: page.study.band is not first and page.study.job is None)
        eventually(lambda: page.band is page.study.band)
        assert not np.array_equal(page.band.lower_deg, first.lower_deg)

    def test_the_box_takes_the_band_away_and_brings_it_back(self, page, visitor, study):
        sampled(page, visitor, study)
        eventually(lambda: page.band is page.study.band)
        visitor.set(widget(study.band), False)
        eventually(lambda: page.band is None)
        visitor.set(widget(study.band), True)
        eventually(lambda: page.band is page.study.band)

    def test_other_bounds_make_it_stale_until_they_come_back(self, page, visitor, study):
        sampled(page, visitor, study)
        eventually(lambda: page.band is not None)
        bound(visitor, page, 0.8)
        visitor.wait(lambda c: "Bounds changed" in text(c, study.sampled))
        eventually(lambda: page.band is None)
        bound(visitor, page, 1.0)
        visitor.wait(lambda c: "Bounds changed" not in text(c, study.sampled))
        eventually(lambda: page.band is page.study.band)

    def test_a_cancelled_one_leaves_what_there_was(self, page, visitor, study):
        before = sampled(page, visitor, study)
        visitor.set(widget(study.n_samples), 1_000_000)
        eventually(lambda: study.n_samples.value == 1_000_000)
        press(visitor, study.runs["sampling"])
        eventually(lambda: page.study.job is not None and study.progress.visible)
        visitor.wait(lambda c: 0 < (c.values.get(widget(study.progress)) or 0) < 100)
        assert study.runs["influence"].disabled
        press(visitor, study.cancel)
        eventually(lambda: page.study.job is None)
        assert page.study.sampled is before
        eventually(lambda: not study.runs["influence"].disabled)
        status = page.view.transport.status
        visitor.wait(lambda c: "study was cancelled" in text(c, status))

    def test_a_second_one_at_once_is_refused_and_told(self, page, visitor, study):
        study.n_samples.value = 1_000_000
        page.post(("study", "sampling"))
        eventually(lambda: page.study.job is not None)
        job, client = page.study.job, next(iter(page.clients()))
        page.post(("study", "influence"), Asked(None, client, True))
        visitor.wait(lambda c: c.notifications)
        assert page.study.job is job
        page.post("study_cancel")
        eventually(lambda: page.study.job is None)

    def test_sliders_answer_while_it_runs(self, page, visitor, study):
        study.n_samples.value = 1_000_000
        page.post(("study", "sampling"))
        eventually(lambda: page.study.job is not None)
        visitor.set(widget(page.view.knee.sliders[0]), -13.5)
        eventually(lambda: page.state.current.x[0] == pytest.approx(-13.5e-3), 10.0)
        assert page.study.job is not None
        page.post("study_cancel")
        eventually(lambda: page.study.job is None)


class TestInfluence:
    @pytest.fixture
    def found(self, page, visitor, study):
        visitor.set(widget(study.n_base), "256")
        eventually(lambda: study.n_base.value == "256")
        press(visitor, study.runs["influence"])
        eventually(lambda: page.study.influence is not None)
        return page.study.influence

    def test_bars_for_the_chosen_load(self, page, visitor, study, found):
        tab = page.view.influence
        first, second = (
            found.deciding(column, 1)[0].replace("_", " ").capitalize() for column in (5, 6)
        )
        bar = re.compile(r"<title>([^:]+): total")
        visitor.wait(lambda c: bar.search(text(c, tab.content)))
        assert bar.search(text(visitor, tab.content)).group(1).lower() == first.lower()
        label = next(name for name, moment in LOADS.items() if moment == -0.1)
        visitor.set(widget(tab.load), label)
        visitor.wait(lambda c: "At -0.1 N·m" in text(c, tab.content))
        assert bar.search(text(visitor, tab.content)).group(1).lower() == second.lower()
        visitor.set(widget(tab.load), next(iter(LOADS)))
        eventually(lambda: page.study.load == 5)

    def test_the_other_charts(self, page, visitor, study, found):
        tab = page.view.influence
        press(visitor, tab.chart, HEAT_MAP)
        visitor.wait(lambda c: "at -5 N·m:" in text(c, tab.content))
        press(visitor, tab.chart, SLOPES)
        visitor.wait(lambda c: "Search for them first" in text(c, tab.content))
        page.post(("search", "surrogate"))
        visitor.wait(lambda c: "half-range more" in text(c, tab.content))

    def test_before_and_stale(self, page, visitor, study):
        tab = page.view.influence
        page.touched = True
        press(visitor, tab.chart, HEAT_MAP)
        visitor.wait(lambda c: "Press <b>Influence</b>" in text(c, tab.content))

    def test_files_are_those_of_the_command_line(self, page, visitor, study, found):
        sampled(page, visitor, study)
        names = ("uncertainty.json", "influence.json", "influence.csv")
        files = {name: download(visitor, study.files[name], name) for name in names}
        document = json.loads(files["uncertainty.json"])
        assert document["n_samples"] == 500
        assert document["influence"]["n_base"] == 256
        assert document["comparison"] is None
        assert json.loads(files["influence.json"]) == found.to_dict()
        assert files["influence.csv"].decode() == to_csv(found)

    def test_a_worst_case_found_later_has_no_place_among_the_samples(self, page, visitor, study):
        """Its shares were counted for no worst case; nothing may be made up."""
        sampled(page, visitor, study)
        page.post(("search", "surrogate"))
        eventually(lambda: page.search.job is None and page.state.result is not None)
        name = "uncertainty.json"
        document = json.loads(download(visitor, study.files[name], name))
        assert document["comparison"]["share_of_samples_below"] is None
        page.study.sampled = None
        sampled(page, visitor, study)
        again = json.loads(download(visitor, study.files[name], name))
        assert np.shape(again["comparison"]["share_of_samples_below"]) == (2, 12)
        counted_for = page.state.result
        page.post(("search", "surrogate"))
        eventually(lambda: page.search.job is None and page.state.result is not counted_for)
        third = json.loads(download(visitor, study.files[name], name))
        assert third["comparison"]["share_of_samples_below"] is None


class TestAccuracy:
    def test_bars_and_file_are_those_of_the_library(self, page, visitor, study):
        visitor.set(widget(study.within), 4.0)
        eventually(lambda: study.within.value == 4.0)
        bound(visitor, page, 0.4)
        press(visitor, study.runs["accuracy"])
        eventually(lambda: page.study.accuracy is not None, 90.0)
        found = page.study.accuracy
        assert found.settings.within == 4.0
        assert found.stated[0] == pytest.approx(0.4)
        visitor.wait(lambda c: "Every knee extends to within 4°" in text(c, study.accuracy))
        shown = text(visitor, study.accuracy)
        assert shown.count("<title>") == len(found.names)
        assert "10 % wider alone" in shown
        name = "accuracy_allocation.json"
        assert json.loads(download(visitor, study.files[name], name)) == found.to_dict()
        bound(visitor, page, 0.8)
        visitor.wait(lambda c: "Bounds changed" in text(c, study.accuracy))
        visitor.set(widget(study.within), 5.0)
        eventually(lambda: study.within.value == 5.0)


class TestLandscape:
    def show(self, page, visitor, tab):
        press(visitor, tab.landscape)
        eventually(lambda: page.landscape.shown)
        visitor.wait(lambda c: "vertices" in c.scene.get(SHEETS[0], {}))
        visitor.wait(lambda c: "knees simulated" in text(c, tab.key))

    def sheet(self, visitor, name=SHEETS[0]):
        return visitor.scene[name]["vertices"].reshape(33, 33, 3)

    def heights(self, page, visitor, name=SHEETS[0]):
        shown = surfaces.box_around(self.picture(page), zoom=page.landscape.zoom)
        up = self.sheet(visitor, name)[..., 1]
        share = (up - surfaces.CENTRE[1]) / surfaces.HEIGHT + 0.5
        return shown.low + share * (shown.high - shown.low)

    def picture(self, page):
        return picture_of(page)

    def test_both_sheets_are_the_librarys(self, page, visitor, study):
        self.show(page, visitor, study)
        state = page.state
        same = kneecore.landscape(
            kneecore.Knee(state.space), page.landscape.names, surrogate=state.surrogate
        )
        for name, angles in zip(SHEETS, (same.y, same.y_surrogate), strict=True):
            visitor.wait(
                lambda c, n=name, a=angles: np.allclose(
                    self.heights(page, c, n), a[..., 5], atol=1e-3
                )
            )
        error = np.abs(same.error[..., 5])
        assert f"{error.mean():.2f}°" in text(visitor, study.key)
        assert f"{error.max():.2f}°" in text(visitor, study.key)

    def test_the_knee_gives_way_and_comes_back(self, page, visitor, study):
        shown = {}

        def watch(message):
            if message["type"] == "SetSceneNodeVisibilityMessage":
                shown[message["name"]] = message["visible"]

        with WebSocketClient(visitor.port, on_message=watch) as other:
            other.wait(lambda c: c.counts.get("ReplayDoneMessage"))
            self.show(page, visitor, study)
            other.wait(lambda _: shown.get("/landscape") is True)
            assert not any(shown[f"/{name}"] for name in ("knee", "worst_1", "worst_2"))
            press(visitor, study.landscape)
            other.wait(lambda _: shown["/landscape"] is False and shown["/knee"])
        assert study.landscape.label == SHOW

    def test_the_camera_comes_back_to_where_it_was(self, page, visitor, study, monkeypatch):
        monkeypatch.setattr("kneeviz.page.framing._ECHO_SECONDS", 0.0)
        seen = []

        def watch(message):
            if message["type"] == "SetCameraPositionMessage":
                seen.append(tuple(message["position"]))

        with WebSocketClient(visitor.port, on_message=watch) as other:
            other.wait(lambda c: c.counts.get("ReplayDoneMessage"))
            # It is placed when it joins: its camera freed, moved and locked, its charts watched.
            other.wait(lambda c: c.counts.get("RunJavascriptMessage", 0) >= 3)
            mine = (0.1, 0.2, 1.5)
            other.send(CAMERA | {"position": mine})
            eventually(
                lambda: any(np.allclose(c.camera.position, mine) for c in page.clients().values())
            )
            self.show(page, visitor, study)
            other.wait(lambda _: not np.allclose(seen[-1], mine) and len(seen) > 1)
            press(visitor, study.landscape)
            other.wait(lambda _: np.allclose(seen[-1], mine))

    def test_it_follows_a_slider_and_rests_while_hidden(self, page, visitor, study):
        self.show(page, visitor, study)
        first = page.landscape.found
        slider = page.view.knee.sliders[NAMES.index("lcl_femur_y")]
        visitor.set(widget(slider), slider.max)
        eventually(lambda: page.landscape.found is not first)
        eventually(lambda: np.array_equal(page.landscape.found[0].x, page.state.current.x))
        knee = np.array(page.state.current.x)
        axis = page.landscape.found[1].axes
        knee[[NAMES.index(n) for n in page.landscape.names]] = axis[0][7], axis[1][30]
        want = np.degrees(kneecore.simulate(knee).flexion[5])
        visitor.wait(lambda c: abs(self.heights(page, c)[7, 30] - want) < 1e-3)
        eventually(lambda: page.landscape.found[0] is page.landscape._asked)
        press(visitor, study.landscape)
        eventually(lambda: not page.landscape.shown)
        before = page.landscape.found
        visitor.set(widget(slider), slider.min)
        eventually(lambda: not np.array_equal(page.state.current.x, before[0].x))
        time.sleep(0.5)
        assert page.landscape.found is before

    def test_what_stands_upright_and_on_the_axes(self, page, visitor, study):
        self.show(page, visitor, study)
        label = next(k for k, name in HEIGHTS.items() if name == "-2 N m")
        visitor.set(widget(study.height), label)
        eventually(lambda: page.landscape.height == "-2 N m")
        found = page.landscape.found[1]
        visitor.wait(
            lambda c: np.allclose(
                self.heights(page, c), kneecore.reading(found.y, "-2 N m"), atol=1e-3
            )
        )
        one, two = page.landscape.names
        visitor.set(widget(study.axes[0]), with_unit(two))
        eventually(lambda: page.landscape.names == (two, one))
        visitor.wait(lambda c: c.values[widget(study.axes[1])] == with_unit(one))
        page.post(("landscape_axis", 0), asked(with_unit(one)))
        page.post(("landscape_look", "height"), asked(tuple(HEIGHTS)[1]))

    def test_the_worst_cases_are_marked(self, page, visitor, study):
        self.show(page, visitor, study)
        assert self.picture(page).worst == (None, None)
        page.post(("search", "surrogate"))
        eventually(lambda: page.state.result is not None)
        visitor.wait(lambda c: "model 2" in text(c, study.key))
        one, two = self.picture(page).worst
        result = page.state.result
        assert one.value == pytest.approx(np.degrees(result.responses["model_1"].flexion[5]))
        assert two.value == pytest.approx(np.degrees(result.responses["model_2"].flexion[5]))

    def test_held_parameters_leave_its_axes(self, page, visitor, study):
        self.show(page, visitor, study)
        visitor.set(widget(page.view.knee.case), "material")
        visitor.wait(lambda c: len(c.props[widget(study.axes[0])].get("options", ())) == 6)
        eventually(lambda: page.landscape.found[1].model.space is page.state.space)
        visitor.set(widget(page.view.knee.case), "both")
        visitor.wait(lambda c: len(c.props[widget(study.axes[0])].get("options", ())) == 28)

    def test_the_flat_view_closes_it(self, page, visitor, study):
        self.show(page, visitor, study)
        press(visitor, page.view.transport.view, "2D")
        eventually(lambda: not page.landscape.shown)


def test_the_paper_claim_by_claim(page, visitor, study):
    press(visitor, study.runs["report"])
    eventually(lambda: page.study.paper is not None, 120.0)
    words = ["statements that were not fitted hold", "agree, ", "cannot be compared"]
    visitor.wait(lambda c: all(w in text(c, study.judged) for w in words))
    made = page.study.paper
    told = text(visitor, study.judged)
    assert len(made.claims) == told.count('scope="rowgroup"') > 10
    for claim in made.claims:
        assert plain(claim.place) in told
        fit = "" if claim.fit == "not fitted" else f", {claim.fit}"
        assert f"<b>{claim.outcome}</b>{fit}</td>" in told
    page = download(visitor, study.files["paper.html"], "paper.html", len(made.page))
    assert page == made.page
    assert page.rstrip().endswith(b"</html>")
    assert page.count(b"<img ") == 8
    packed = download(visitor, study.files["paper.zip"], "paper.zip", len(made.everything))
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        assert {"paper.md", "paper.json", "uncertainty.json"} <= set(archive.namelist())
        assert json.loads(archive.read("paper.json"))["quick"] is True
        pictures = {name for name in archive.namelist() if name.endswith(".png")}
        assert len(pictures) == 8
        markdown = archive.read("paper.md").decode()
        assert all(f"]({name})" in markdown for name in pictures)

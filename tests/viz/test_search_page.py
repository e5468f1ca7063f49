"""Searches and files in the real server, spoken to by visitors without a browser."""

import json
import math
import time

import numpy as np
import pytest
from searches import searched
from viz.conftest import eventually
from viz.visits import pause, press, search_anew, wait_for_result, widget
from viz.websocket_client import WebSocketClient

import kneecore
from kneecore import NAMES, asset_path
from kneecore.files.search import curves_csv
from kneeviz import viser_internals
from kneeviz.jobs.messages import Asked
from kneeviz.state.presets import WORST

ACL_Y = NAMES.index("acl_femur_y")
KNEE = asset_path("baseline.toml").read_bytes()


class TestSearch:
    def test_a_surrogate_search_to_its_end(self, page, visitor):
        search_anew(page, visitor)
        result = page.state.result
        np.testing.assert_array_equal(result.x, searched(threads=1).x)
        found = widget(page.view.search.found)
        visitor.wait(lambda c: "true model" in c.props[found]["content"])
        assert "surrogate" in visitor.props[found]["content"]
        visitor.wait(lambda c: c.props[widget(page.view.search.overlay)]["visible"])
        assert (
            "python -m kneecore.search" in visitor.props[widget(page.view.search.table)]["content"]
        )

    def test_both_knees_stand_at_the_same_moment(self, page, visitor):
        if page.state.result is None:
            press(visitor, page.view.search.surrogate)
            wait_for_result(page)
        pause(visitor, page)
        visitor.set(widget(page.view.search.overlay), True)
        for position in (0.0, 30.0, 80.0):
            visitor.set(widget(page.view.transport.position), position)
            eventually(lambda p=position: page.playback.share == pytest.approx(p / 100, abs=1e-3))
            own, one, two = page.poses
            assert one.moment == two.moment == own.moment
        turns = []
        for name in ("/worst_1/tibia", "/worst_2/tibia"):
            visitor.wait(lambda c, n=name: "wxyz" in c.scene.get(n, {}))
            turns.append(-2 * math.atan2(*(visitor.scene[name]["wxyz"][i] for i in (3, 0))))
        visitor.wait(
            lambda c: (
                -2 * math.atan2(*(c.scene["/worst_1/tibia"]["wxyz"][i] for i in (3, 0)))
                == pytest.approx(one.flexion)
            )
        )

    def test_the_overlay_can_be_hidden(self, page, visitor):
        if page.state.result is None:
            press(visitor, page.view.search.surrogate)
            wait_for_result(page)
        visitor.set(widget(page.view.search.overlay), False)
        eventually(lambda: not page.overlay)
        eventually(lambda: not page.view.scene.overlays[0].visible)
        visitor.set(widget(page.view.search.overlay), True)
        eventually(lambda: page.view.scene.overlays[0].visible)

    def test_make_a_model_mine(self, page, visitor):
        if page.state.result is None:
            press(visitor, page.view.search.surrogate)
            wait_for_result(page)
        press(visitor, page.view.search.adopt, "Model 2")
        eventually(lambda: np.array_equal(page.state.x[:28], page.state.result.x[1]))
        eventually(lambda: page.view.knee.preset.value == WORST[1])

    def test_a_true_model_search_is_cancelled_and_the_old_result_stands(self, page, visitor):
        search_anew(page, visitor)
        before = page.state.result
        press(visitor, page.view.search.model)
        eventually(lambda: page.search.job is not None)
        progress = widget(page.view.search.progress)
        visitor.wait(lambda c: (c.values.get(progress) or 0) > 0)
        start = time.monotonic()
        press(visitor, page.view.search.cancel)
        eventually(lambda: page.search.job is None)
        assert time.monotonic() - start < 20.0
        assert page.state.result is before
        eventually(lambda: not page.view.search.model.disabled)  # a line after the job is gone
        visitor.wait(
            lambda c: "cancelled" in c.props[widget(page.view.transport.status)]["content"]
        )

    def test_a_second_search_at_once_is_refused_and_told(self, page, visitor):
        page.post(("search", "model"), None)
        eventually(lambda: page.search.job is not None)
        job = page.search.job
        page.post(("search", "surrogate"), Asked(None, next(iter(page.clients())), True))
        visitor.wait(lambda c: c.notifications)
        assert page.search.job is job
        page.post("cancel", None)
        eventually(lambda: page.search.job is None)

    def test_a_visitor_who_leaves_during_a_search_stops_nothing(self, app, page):
        with WebSocketClient(app.server.get_port()) as leaving:
            leaving.wait(lambda c: c.counts.get("ReplayDoneMessage"))
            eventually(lambda: app.server.get_clients())
            page.state.result = None
            press(leaving, page.view.search.surrogate)
            eventually(lambda: page.search.job is not None or page.state.result is not None)
        wait_for_result(page)

    def test_a_result_of_older_bounds_is_greyed(self, page, visitor):
        search_anew(page, visitor)
        geometry = page.view.knee.bounds["geometry_mm"]
        visitor.set(widget(geometry), 0.8)
        found = widget(page.view.search.found)
        visitor.wait(lambda c: "Bounds changed" in c.props[found]["content"])
        visitor.set(widget(geometry), 1.0)
        visitor.wait(lambda c: "Bounds changed" not in c.props[found]["content"])


class TestFiles:
    def upload(self, visitor, page, name, content, **options):
        visitor.upload(widget(page.view.files.upload), name, content, **options)

    def test_a_knee_goes_out_and_comes_back_without_moving(self, page, visitor):
        visitor.set(widget(page.view.knee.sliders[ACL_Y]), 0.25)
        eventually(lambda: page.state.x[ACL_Y] == pytest.approx(0.25e-3))
        x = page.state.x.copy()
        press(visitor, page.view.files.knee)
        visitor.wait(lambda c: b"[current]" in c.downloads.get("knee.toml", b""))
        press(visitor, page.view.knee.reset_all)
        eventually(lambda: page.state.x[ACL_Y] != x[ACL_Y])
        self.upload(visitor, page, "knee.toml", visitor.downloads["knee.toml"])
        eventually(lambda: np.array_equal(page.state.x, x))
        np.testing.assert_array_equal(page.state.space.baseline, kneecore.packaged_knee().baseline)
        assert visitor.notifications == []

    def test_the_command_line_reads_what_the_app_downloads(self, page, visitor, tmp_path):
        search_anew(page, visitor)
        for name in ("result.json", "curves.csv"):
            press(visitor, page.view.files.result[name])
            visitor.wait(lambda c, n=name: len(c.downloads.get(n, b"")) > 500)
        path = tmp_path / "result.json"
        path.write_bytes(visitor.downloads["result.json"])
        from kneecore.search.result import SearchResult

        loaded = SearchResult.load(path)
        np.testing.assert_array_equal(loaded.x, page.state.result.x)
        assert visitor.downloads["curves.csv"].decode() == curves_csv(loaded)

    def test_the_app_reads_what_the_command_line_writes(self, page, visitor):
        result = searched(pop_size=20, n_generations=4, seed=5)
        self.upload(visitor, page, "result.json", result.to_json().encode())
        eventually(lambda: page.state.result is not None and page.state.result.settings.seed == 5)
        np.testing.assert_array_equal(page.state.result.x, result.x)

    @pytest.mark.parametrize(
        ("name", "content"),
        [
            ("bad.toml", b"\xff\xfe\xfa"),
            ("bad.json", b"{]"),
            ("empty", b""),
            ("old.json", json.dumps({"schema": "kneecore.result/77"}).encode()),
            ("old.toml", KNEE.replace(b"kneecore.knee/1", b"kneecore.knee/77")),
        ],
    )
    def test_a_corrupt_upload_is_told_once_and_changes_nothing(self, page, visitor, name, content):
        x, result = page.state.x.copy(), page.state.result
        self.upload(visitor, page, name, content)
        visitor.wait(lambda c: c.notifications)
        time.sleep(0.1)
        assert len(visitor.notifications) == 1
        assert name in visitor.notifications[0]["props"]["body"]
        np.testing.assert_array_equal(page.state.x, x)
        assert page.state.result is result

    def test_an_oversized_upload_is_refused_before_it_is_sent(self, page, visitor):
        self.upload(visitor, page, "big.json", b"x" * 100, size=viser_internals.MAX_UPLOAD + 1)
        visitor.wait(lambda c: c.notifications)
        assert "bytes" in visitor.notifications[0]["props"]["body"]
        assert not page.target.gui._current_file_upload_states

    def test_an_upload_larger_than_announced_is_dropped(self, page, visitor):
        self.upload(visitor, page, "liar.json", b"x" * 1000, size=10)
        visitor.wait(lambda c: c.notifications)
        assert not page.target.gui._current_file_upload_states

    def test_a_title_with_markup_is_shown_as_text(self, page, visitor):
        content = KNEE.replace(b'title = "Packaged baseline"', b'title = "<img src=x>"')
        self.upload(visitor, page, "evil.toml", content)
        status = widget(page.view.transport.status)
        visitor.wait(lambda c: "&lt;img" in c.props[status]["content"])
        assert "<img" not in visitor.props[status]["content"]
        self.upload(visitor, page, "baseline.toml", KNEE)
        visitor.wait(lambda c: "Packaged" in c.props[status]["content"])

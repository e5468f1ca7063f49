"""The real server, spoken to by visitors without a browser."""

import math
import threading
import time

import numpy as np
import pytest
from viz.conftest import eventually
from viz.visits import (
    current_curve,
    curve,
    height,
    pause,
    play,
    press,
    shows,
    widget,
)
from viz.websocket_client import WebSocketClient

import kneecore
from kneecore import NAMES
from kneeviz.jobs.messages import Asked
from kneeviz.server.app import App
from kneeviz.state.playback import SWEEP_SECONDS

ACL_Y = NAMES.index("acl_femur_y")


class TestSliders:
    def test_a_slider_bends_the_curve_and_moves_the_attachment(self, page, visitor):
        pause(visitor, page)
        before = current_curve(visitor, page)
        line = height(visitor)
        visitor.set(widget(page.view.knee.sliders[ACL_Y]), 0.5)
        x = np.array(page.state.space.baseline)
        x[ACL_Y] = 0.5e-3
        true = np.degrees(kneecore.simulate(x).flexion)
        assert np.abs(np.interp(kneecore.MOMENT, *before) - true).max() > 0.1
        visitor.wait(lambda c: shows(c, page, true))
        rise = pytest.approx(0.8e-3, abs=1e-7)
        visitor.wait(lambda c: height(c) - line == rise)

    def test_the_surrogate_bends_with_it_and_its_error_is_shown(self, page, visitor):
        visitor.set(widget(page.view.knee.sliders[ACL_Y]), 0.7)
        eventually(lambda: page.state.current.x[ACL_Y] == pytest.approx(0.7e-3))
        knee = page.state.current
        predicted = page.state.surrogate.predict(knee.x[:28])  # the worker may not be that far yet
        rms = np.sqrt(np.mean((predicted - np.degrees(knee.response.flexion)) ** 2))
        shown = f"{rms:.1f}°"
        visitor.wait(lambda c: shown in c.props[widget(page.view.error)]["content"])

    def test_a_fast_drag_leaves_everything_at_its_last_value(self, page, visitor):
        handle = page.view.knee.sliders[ACL_Y]
        for value in np.linspace(-1.3, 0.7, 200).round(2):
            visitor.set(widget(handle), float(value))
            time.sleep(0.005)
        eventually(lambda: page.state.x[ACL_Y] == pytest.approx(0.7e-3))
        eventually(lambda: page.state.current.x[ACL_Y] == pytest.approx(0.7e-3))
        assert handle.value == pytest.approx(0.7)
        true = np.degrees(kneecore.simulate(page.state.x).flexion)
        visitor.wait(lambda c: shows(c, page, true))

    def test_sliders_that_move_together_are_one_knee(self, page, app, monkeypatch):
        """Thirty who drag would otherwise wait for a knee for each of them."""
        solved, held, go_on = [], threading.Event(), threading.Event()
        update = page.state.update
        monkeypatch.setattr(page.state, "update", lambda x: solved.append(x) or update(x))

        def hold(*_):
            held.set()
            go_on.wait(20)

        monkeypatch.setattr(page.notices, "deliver", hold)
        page.post(("setting", "search.seed"))
        assert held.wait(20)
        for index in (0, 4, 8, ACL_Y):
            handle = page.view.knee.sliders[index]
            value = 0.5 * (handle.min + handle.max) + 0.1
            page.post(("param", index), Asked(handle, -1, value))
        go_on.set()
        eventually(lambda: not page.unsolved and page.state.x[8] != page.state.space.baseline[8])
        eventually(lambda: solved)
        time.sleep(0.1)
        assert len(solved) == 1
        assert np.array_equal(page.state.current.x, page.state.x)

    def test_resets(self, page, visitor):
        tab = page.view.knee
        visitor.set(widget(tab.sliders[ACL_Y]), 0.5)
        visitor.set(widget(tab.sliders[4]), -9.0)
        eventually(lambda: page.state.x[4] == pytest.approx(-9e-3))
        press(visitor, tab.resets["acl"])
        eventually(lambda: page.state.x[ACL_Y] == page.state.space.baseline[ACL_Y])
        assert page.state.x[4] == pytest.approx(-9e-3)
        press(visitor, tab.reset_all)
        eventually(lambda: page.state.at_baseline)
        visitor.wait(lambda c: c.values[widget(tab.sliders[4])] == pytest.approx(-9.7))

    def test_reset_repairs_a_browser_that_missed_something(self, page, visitor):
        uuid = widget(page.view.knee.sliders[0])
        visitor.values[uuid] = 99.0
        press(visitor, page.view.knee.reset_all)
        visitor.wait(lambda c: c.values[uuid] == pytest.approx(-14.0))

    def test_a_preset_and_a_second_visitor_sees_it(self, app, page, visitor):
        with WebSocketClient(app.server.get_port()) as other:
            other.wait(lambda c: c.counts.get("ReplayDoneMessage"))
            press(visitor, page.view.knee.preset, "Larger condyle")
            uuid = widget(page.view.knee.sliders[NAMES.index("condyle_radius")])
            other.wait(lambda c: c.values[uuid] == pytest.approx(33.1))


class TestBadValues:
    @pytest.mark.parametrize("bad", [math.nan, 1e9, -1e9, "five", None, True, [1.0], {}])
    def test_a_bad_slider_value_is_refused_and_told_once(self, page, visitor, bad):
        handle = page.view.knee.sliders[ACL_Y]
        before = page.state.x.copy()
        for _ in range(3):
            visitor.set(widget(handle), bad)
        visitor.wait(lambda c: c.notifications)
        time.sleep(0.2)
        assert len(visitor.notifications) == 1
        assert "ACL femur y" in visitor.notifications[0]["props"]["body"]
        np.testing.assert_array_equal(page.state.x, before)
        assert visitor.values[widget(handle)] == pytest.approx(handle.value)

    def test_only_the_one_who_sent_it_is_told(self, app, page, visitor):
        with WebSocketClient(app.server.get_port()) as other:
            other.wait(lambda c: c.counts.get("ReplayDoneMessage"))
            visitor.set(widget(page.view.knee.sliders[0]), 1e6)
            visitor.wait(lambda c: c.notifications)
            assert other.notifications == []

    def test_a_number_being_typed_is_not_complained_about(self, page, visitor):
        uuid = widget(page.view.knee.sliders[NAMES.index("condyle_radius")])
        for typed in (3, 32, 32.5):
            visitor.set(uuid, typed)
            time.sleep(0.05)
        eventually(lambda: page.state.x[NAMES.index("condyle_radius")] == pytest.approx(32.5e-3))
        time.sleep(1.0)
        assert visitor.notifications == []

    def test_attributes_of_widgets_cannot_be_set(self, page, visitor):
        handle = page.view.knee.sliders[0]
        uuid = widget(handle)
        visitor.update(uuid, {"uuid": "taken"})
        visitor.update(uuid, {"value": -14.2, "max": 99.0})
        visitor.wait(lambda c: c.notifications)
        assert widget(handle) == uuid
        assert handle.max == pytest.approx(-13.0)

    def test_a_disabled_button_does_nothing(self, app, visitor):
        page = app.page
        button = page.view.files.result["result.json"]
        disabled, button.disabled = button.disabled, True
        press(visitor, button)
        visitor.wait(lambda c: c.notifications)
        assert visitor.downloads == {}
        button.disabled = disabled

    def test_garbage_ends_that_connection_only(self, app, page, visitor):
        with WebSocketClient(app.server.get_port()) as broken:
            broken.send_raw(b"\xc1\xc1 garbage")
        visitor.set(widget(page.view.knee.sliders[0]), -14.4)
        eventually(lambda: page.state.x[0] == pytest.approx(-14.4e-3))


class TestBounds:
    @pytest.fixture(autouse=True)
    def restore(self, page, visitor):
        yield
        tab = page.view.knee
        visitor.set(widget(tab.case), "both")
        visitor.set(widget(tab.bounds["geometry_mm"]), 1.0)
        visitor.set(widget(tab.bounds["material_percent"]), 10.0)
        eventually(lambda: page.state.space.n_free == 28)
        eventually(lambda: tab.sliders[0].max == pytest.approx(-13.0))

    def test_ranges_follow_the_bounds_and_the_surrogate_is_fitted_anew(self, page, visitor):
        old = page.state.surrogate
        visitor.set(widget(page.view.knee.bounds["geometry_mm"]), 0.5)
        uuid = widget(page.view.knee.sliders[0])
        visitor.wait(lambda c: c.props[uuid]["max"] == pytest.approx(-13.5))
        eventually(lambda: page.state.surrogate not in (None, old))
        assert page.state.surrogate.model.space is page.state.space

    def test_held_parameters_are_shut(self, page, visitor):
        visitor.set(widget(page.view.knee.case), "material")
        stiff, place = NAMES.index("acl_stiffness"), 0
        uuid = widget(page.view.knee.sliders[place])
        visitor.wait(lambda c: c.props[uuid]["disabled"])
        assert not page.view.knee.sliders[stiff].disabled
        visitor.set(uuid, -14.0)
        visitor.wait(lambda c: c.notifications)

    def test_rest_lengths_are_shut_until_a_bound_lets_them_vary(self, visitor, page):
        tab = page.view.knee
        assert all(slider.disabled for slider in tab.sliders[28:])
        visitor.set(widget(tab.bounds["rest_length_mm"]), 1.0)
        eventually(lambda: not tab.sliders[28].disabled)
        visitor.set(widget(tab.sliders[28]), -0.8)
        eventually(lambda: page.state.current.x[28] == pytest.approx(-0.8e-3))
        true = np.degrees(kneecore.simulate(page.state.x).flexion)
        eventually(lambda: np.allclose(np.degrees(page.state.current.response.flexion), true))
        assert page.state.space.n_free == 32
        visitor.set(widget(tab.bounds["rest_length_mm"]), 0.0)
        eventually(lambda: tab.sliders[28].disabled and page.state.at_baseline)

    def test_impossible_bounds_are_told_and_put_back(self, page, visitor):
        tab = page.view.knee
        visitor.set(widget(tab.case), "material")
        eventually(lambda: page.state.bounds.case == "material")
        visitor.set(widget(tab.bounds["material_percent"]), 0.0)
        visitor.wait(lambda c: c.notifications)
        assert page.state.bounds.material_percent != 0.0
        visitor.wait(
            lambda c: c.values[widget(tab.bounds["material_percent"])] == pytest.approx(10.0)
        )


class TestMotion:
    def test_it_moves_at_thirty_frames_a_second(self, page, visitor):
        play(visitor, page)
        time.sleep(0.2)
        before = visitor.counts["SetOrientationMessage"]
        time.sleep(2.0)
        frames = visitor.counts["SetOrientationMessage"] - before
        assert 45 <= frames <= 66
        pause(visitor, page)

    def test_its_pace_is_that_of_the_clock(self, page, visitor):
        pause(visitor, page)
        page.playback.set_share(0.5)
        play(visitor, page)
        start, phase = time.monotonic(), page.playback.phase
        time.sleep(1.0)
        passed = (page.playback.phase - phase) * SWEEP_SECONDS
        assert passed == pytest.approx(time.monotonic() - start, abs=0.15)
        pause(visitor, page)

    def test_dragging_the_position_pauses_and_goes_there(self, page, visitor):
        play(visitor, page)
        visitor.set(widget(page.view.transport.position), 100.0)
        eventually(lambda: not page.playback.playing)
        visitor.wait(lambda c: "119.0°" in c.props[widget(page.view.transport.readout)]["content"])

    def test_the_marker_on_the_curve_is_the_pose_on_screen(self, page, visitor):
        pause(visitor, page)
        visitor.set(widget(page.view.transport.position), 40.0)
        eventually(lambda: page.playback.share == pytest.approx(0.4))
        pose = page.poses[0]

        def marked(client):
            data = curve(client, page)
            dot = np.flatnonzero(np.isfinite(data[-3]))
            return len(dot) == 1 and (data[0][dot[0]], data[-3][dot[0]])

        def there(client):
            spot = marked(client)
            return spot and abs(spot[0] - pose.moment) < 1e-9

        visitor.wait(there)
        assert marked(visitor)[1] == pytest.approx(np.degrees(pose.flexion))

        def turned(client):  # the scene follows the chart
            turn = client.scene["/knee/tibia"]["wxyz"]
            return -2.0 * math.atan2(turn[3], turn[0]) == pytest.approx(pose.flexion)

        visitor.wait(turned)

    def test_the_true_dynamics(self, page, visitor):
        look = page.view.look
        visitor.set(widget(look.mode), "In time, flexing")
        eventually(lambda: page.playback.mode == "flexion")
        pause(visitor, page)
        visitor.set(widget(page.view.transport.position), 100.0)
        eventually(lambda: page.playback.share == pytest.approx(1.0))
        run = kneecore.trajectory(page.state.x)
        eventually(lambda: page.poses[0].flexion == pytest.approx(float(run.flexion[1, -1])))
        visitor.wait(lambda c: "23.0 s" in c.props[widget(page.view.transport.readout)]["content"])
        visitor.set(widget(look.mode), "Through the loads")
        eventually(lambda: page.playback.mode == "sweep")

    def test_nobody_looking_costs_no_frames(self, app, page):
        eventually(lambda: not app.server.get_clients())
        page.playback.play(True)
        page.post("loop", Asked(page.view.look.loop, -1, True))
        time.sleep(0.7)
        frame = app.session.drawing.frame
        time.sleep(1.0)
        assert app.session.drawing.frame - frame < 8
        page.playback.play(False)


def test_per_visitor_each_has_a_knee_of_his_own():
    def workers():
        return {t for t in threading.enumerate() if t.name == "view"}

    before = workers()
    app = App(port=0, shared=False)
    try:
        port = app.server.get_port()
        with WebSocketClient(port) as one, WebSocketClient(port) as two:
            eventually(lambda: len(app.sessions) == 2)
            first, second = (app.sessions[k].page for k in sorted(app.sessions))
            eventually(lambda: first.model_ready and second.model_ready, 60)
            one.wait(lambda c: widget(first.view.knee.sliders[ACL_Y]) in c.values)
            one.set(widget(first.view.knee.sliders[ACL_Y]), 0.5)
            eventually(lambda: first.state.x[ACL_Y] == pytest.approx(0.5e-3))
            assert second.state.x[ACL_Y] == pytest.approx(-0.3e-3)
            two.set(widget(second.view.knee.sliders[ACL_Y]), 1e9)
            two.wait(lambda c: c.notifications)
            assert one.notifications == []
        eventually(lambda: app.sessions == {})
        eventually(lambda: workers() == before)
    finally:
        app.stop()

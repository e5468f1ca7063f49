"""Looking closer: a pointer that poses the knee, ghosts, knees side by side, two answers as one."""

import numpy as np
import pytest
from viz.conftest import eventually
from viz.visits import curve, pause, press, search_anew, widget

from kneecore import MOMENT, NAMES
from kneeviz.geometry.framing import knee_points
from kneeviz.page.framing import room_between
from kneeviz.state import history, results
from kneeviz.state.ghosts import MOST

ACL_Y = NAMES.index("acl_femur_y")


@pytest.fixture
def still(app, visitor):
    """The page as it is, paused, with the motion a quarter of its way."""
    pause(visitor, app.page)
    app.page.playback.set_share(0.25)
    return app.page


class TestPointer:
    @pytest.fixture(autouse=True)
    def _leave(self, still, visitor):
        yield
        press(visitor, still.view.pointer.left)
        eventually(lambda: still.pointing is None)

    def point(self, page, visitor, moment):
        press(visitor, page.view.pointer.moment, moment)
        eventually(
            lambda: page.pointing is not None and page.poses[0].moment == pytest.approx(moment)
        )

    def leave(self, page, visitor):
        press(visitor, page.view.pointer.left)
        eventually(lambda: page.pointing is None)

    def test_over_the_curve_it_poses_the_knee_until_it_leaves(self, still, visitor):
        self.point(still, visitor, 2.0)
        self.point(still, visitor, -1.5)
        angle = np.degrees(still.poses[0].flexion)
        visitor.wait(lambda c: np.nanmax(curve(c, still)[-3]) == pytest.approx(angle))  # its dot
        self.leave(still, visitor)
        assert still.playback.share == pytest.approx(0.25)

    def test_over_a_chart_of_angles_the_knee_is_bent_so_far(self, still, visitor):
        press(visitor, still.view.pointer.angle, 31.0)
        eventually(lambda: np.degrees(still.poses[0].flexion) == pytest.approx(31.0))

    def test_a_click_leaves_the_knee_there(self, still, visitor):
        self.point(still, visitor, 2.0)
        press(visitor, still.view.pointer.keep)
        eventually(lambda: still.pointing is None)
        self.leave(still, visitor)
        assert still.poses[0].moment == pytest.approx(2.0)

    def test_what_somebody_has_moved_since_stays(self, still, visitor):
        self.point(still, visitor, 2.0)
        visitor.set(widget(still.view.transport.position), 80.0)
        eventually(lambda: still.playback.share == pytest.approx(0.8))
        self.leave(still, visitor)
        assert still.playback.share == pytest.approx(0.8)

    def test_a_moving_knee_is_left_alone(self, still, visitor):
        press(visitor, still.view.transport.play)
        eventually(lambda: still.playback.playing)
        press(visitor, still.view.pointer.moment, 3.0)
        press(visitor, still.view.look.forces, True)  # comes after it
        eventually(lambda: still.view.scene.forces)
        assert still.pointing is None
        pause(visitor, still)

    def test_one_visitor_points_at_a_time(self, still, visitor, app):
        self.point(still, visitor, 2.0)
        with type(visitor)(app.server.get_port()) as second:
            second.wait(lambda c: c.counts.get("ReplayDoneMessage"))
            press(second, still.view.pointer.moment, -4.0)
            press(second, still.view.look.forces, False)
            eventually(lambda: not still.view.scene.forces)
            assert still.poses[0].moment == pytest.approx(2.0)


class TestGhosts:
    @pytest.fixture(autouse=True)
    def _none(self, page, still, visitor):
        yield
        press(visitor, still.view.look.clear_ghosts)
        visitor.set(widget(still.view.look.ghosts), False)
        eventually(lambda: not still.keeps_ghosts and not still.ghosts)

    def keep(self, page, visitor):
        visitor.set(widget(page.view.look.ghosts), True)
        eventually(lambda: page.keeps_ghosts)

    def move(self, page, visitor, mm):
        """Move a slider as one drag of its own."""
        page.history.rest()
        visitor.set(widget(page.view.knee.sliders[ACL_Y]), mm)
        eventually(lambda: page.state.current.x[ACL_Y] == pytest.approx(1e-3 * mm))

    def drawn(self, visitor, page):
        """How many ghosts there are in the chart and in the picture."""
        keys = [s.get("key") for s in page.view.curve.handle.series]
        lines = [curve(visitor, page)[i] for i, key in enumerate(keys) if key == "ghosts"]
        roots = [visitor.scene[f"/ghost_{i + 1}"] for i in range(MOST)]
        return (
            sum(bool(np.isfinite(line).any()) for line in lines),
            sum(bool(root.get("visible")) for root in roots),
        )

    def test_there_are_none_unless_they_are_wanted(self, still, visitor):
        self.move(still, visitor, 0.4)
        assert still.ghosts == ()

    def test_the_last_three_are_kept_and_undo_takes_them_back(self, still, visitor):
        self.keep(still, visitor)
        for mm in (0.1, 0.2, 0.3, 0.4):
            self.move(still, visitor, mm)
        assert [1e3 * g.x[ACL_Y] for g in still.ghosts] == pytest.approx([0.3, 0.2, 0.1])
        visitor.wait(lambda c: self.drawn(c, still) == (3, 3))
        press(visitor, still.view.transport.change, "Undo")
        eventually(
            lambda: [1e3 * g.x[ACL_Y] for g in still.ghosts][:2] == pytest.approx([0.2, 0.1])
        )
        press(visitor, still.view.look.clear_ghosts)
        visitor.wait(lambda c: self.drawn(c, still) == (0, 0))

    def test_one_drag_leaves_one(self, still, visitor, monkeypatch):
        monkeypatch.setattr(history, "PAUSE", 60.0)  # it goes on, however busy the machine is
        self.keep(still, visitor)
        home = still.state.x[ACL_Y]
        still.history.rest()
        for mm in (0.1, 0.2, 0.3):
            visitor.set(widget(still.view.knee.sliders[ACL_Y]), mm)
            eventually(lambda at=1e-3 * mm: still.state.current.x[ACL_Y] == pytest.approx(at))
        assert [g.x[ACL_Y] for g in still.ghosts] == [home]

    def test_those_of_another_rule_are_gone(self, still, visitor):
        self.keep(still, visitor)
        self.move(still, visitor, 0.4)
        visitor.wait(lambda c: self.drawn(c, still) == (1, 1))
        visitor.set(widget(still.view.knee.rest_length), "fixed")
        try:
            visitor.wait(lambda c: self.drawn(c, still) == (0, 0))
        finally:
            visitor.set(widget(still.view.knee.rest_length), "recomputed")
            eventually(lambda: still.state.bounds.rest_length == "recomputed")


class TestSideBySide:
    def test_the_worst_cases_stand_beside_the_knee_and_in_the_picture(self, still, visitor):
        search_anew(still, visitor)
        eventually(lambda: still.overlay)
        over = still.subject.points()
        visitor.set(widget(still.view.search.beside), True)
        try:
            eventually(lambda: still.apart > 0.0)
            apart = still.apart
            places = ("/worst_1", -apart), ("/worst_2", apart)
            for name, x in places:
                visitor.wait(
                    lambda c, n=name, x=x: c.scene[n].get("position", [0.0])[0] == pytest.approx(x)
                )
                visitor.wait(lambda c, n=name: c.scene[f"{n}/femur"].get("visible"))
            beside = still.subject.points()
            assert beside[:, 0].min() < over[:, 0].min() - 0.6 * apart
            assert beside[:, 0].max() > over[:, 0].max() + 0.6 * apart
        finally:
            visitor.set(widget(still.view.search.beside), False)
        eventually(lambda: still.apart == 0.0)
        visitor.wait(lambda c: c.scene["/worst_1"]["position"][0] == 0.0)
        assert not visitor.scene["/worst_1/femur"]["visible"]

    def test_their_bones_do_not_touch_at_any_moment(self, still):
        knees = (still.state.current, *still.state.worst)
        own, one, two = (knee.sweep for knee in knees)
        apart = room_between(knees)
        for moment in MOMENT:
            left, middle, right = (
                knee_points([s.at_moment(float(moment))])[:, 0] for s in (one, own, two)
            )
            assert left.max() - apart < middle.min()
            assert middle.max() < right.min() + apart
        assert apart < 0.25


def test_answers_at_rest_and_in_motion_are_told_in_one_line(page, still, visitor):
    search_anew(still, visitor)
    eventually(lambda: still.exact_ready)
    moving = still.state.result.objective_model
    assert "Two answers" not in still.view.search.found.content
    press(visitor, still.view.search.live)
    eventually(lambda: still.live.shown and "Two answers" in still.view.search.found.content)
    told, rest = still.view.search.found.content, still.state.result.objective_model
    assert f"at rest {rest:.1f}°" in told
    assert f"{moving:.1f}°" in told
    visitor.set(widget(still.view.search.live), False)
    visitor.set(widget(still.view.knee.bounds["geometry_mm"]), 0.8)
    eventually(lambda: still.state.bounds.geometry_mm == 0.8)
    press(visitor, still.view.search.surrogate)
    eventually(lambda: results.solver(still.state.result) == "dynamics")
    assert results.solver(still.other) == "equilibrium"
    eventually(lambda: "surrogate" in still.view.search.found.content)
    assert "Two answers" not in still.view.search.found.content
    visitor.set(widget(still.view.knee.bounds["geometry_mm"]), 1.0)

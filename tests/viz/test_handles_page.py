"""Handles over the wire: drags as a browser tells of them, and as none would."""

import html
import json
import math
import time

import numpy as np
import pytest
from viz.conftest import eventually
from viz.visits import pause, play, press, shows, widget
from viz.websocket_client import WebSocketClient

import kneecore
from kneecore import NAMES
from kneeviz.geometry.handles import BY_NAME, HANDLES, RADIUS, SLOPE
from kneeviz.page import animation
from kneeviz.page.handles import loupe_of
from kneeviz.state import history
from kneeviz.state.handles import bound_now, box_of, values_of
from kneeviz.views.scene.handles import depth_of
from kneeviz.views.theme import CLASS_SIZE

MM = 1e-3


class Hand:
    """A visitor's hand at one handle, or at an edge of its box."""

    def __init__(self, page, visitor, name, edge=None):
        self.page, self.visitor, self.handle = page, visitor, BY_NAME[name]
        self.node = f"/handles/{name}" if edge is None else f"/handles/edge_{edge}"

    def place(self, *value):
        """Return where a value stands in the handle's loupe, m."""
        page = self.page
        at = loupe_of(page, self.handle, page.poses[0]).at(np.array(value))
        return (*at, depth_of(self.handle, page.view.scene.spatial))

    def choose(self):
        """Open the handle's loupe, and wait until it is seen."""
        self.visitor.click(f"/handles/{self.handle.name}")
        eventually(lambda: self.page.handles.chosen is self.handle)
        self.visitor.wait(
            lambda c: (
                c.scene.get("/handles/label", {}).get("text", "").startswith(self.handle.label)
            )
        )

    def take(self, *value):
        """Choose the handle and take hold of it where it, or `value`, stands."""
        self.choose()
        self.taken = self.place(*(value or values_of(self.page.state, self.handle)))
        self.tell("start", self.taken)
        eventually(lambda: self.handle.name in self.page.handles.grabs)

    def tell(self, phase, place):
        self.visitor.drag(self.node, phase, self.taken, place)

    def to(self, *value):
        self.tell("update", self.place(*value))

    def let_go(self, *value):
        self.tell("end", self.place(*value) if value else self.taken)
        eventually(lambda: self.handle.name not in self.page.handles.grabs)

    @property
    def values(self):
        return values_of(self.page.state, self.handle).tolist()


@pytest.fixture(autouse=True)
def at_once(monkeypatch):
    """Let a knee turn into another without the time that looks good."""
    monkeypatch.setattr(animation, "_MORPH_SECONDS", 1e-3)


@pytest.fixture
def hand(page, visitor):
    """The ACL's femoral end in a hand, the motion paused; afterwards all as it was."""
    pause(visitor, page)
    position = widget(page.view.transport.position)
    visitor.set(position, 30.0)
    eventually(lambda: abs(page.playback.share - 0.3) < 1e-6)
    yield Hand(page, visitor, "acl_femur")
    for name in ("geometry_mm", "slope_deg"):
        if bound_now(page.state, name) != 1.0:
            visitor.set(widget(page.view.knee.bounds[name]), 1.0)
            eventually(lambda n=name: bound_now(page.state, n) == 1.0)


def give(visitor, page, label):
    """Give a command by its key or from the palette."""
    command = next(c for c in page.view.commands if c.label == label)
    visitor.send({"type": "CommandTriggerMessage", "uuid": widget(command)})


def escape(visitor, page):
    give(visitor, page, "Handle: as it was")


def is_told(visitor, words):
    visitor.wait(lambda c: any(words in n["props"]["body"] for n in c.notifications))


def test_a_drag_moves_the_pair_the_sliders_the_curve_and_the_knee(page, visitor, hand):
    hand.take()
    hand.to(-13.6 * MM, -0.8 * MM)
    hand.let_go(-13.57 * MM, -0.75 * MM)
    assert hand.values == [-13.57 * 1e-3, -0.75 * 1e-3]
    for slider, shown in zip(page.view.knee.sliders, (-13.57, -0.75), strict=False):
        visitor.wait(lambda c, s=slider, v=shown: c.values[widget(s)] == pytest.approx(v))
    angles = np.degrees(kneecore.simulate(page.state.x).flexion)
    visitor.wait(lambda c: shows(c, page, angles))
    visitor.wait(
        lambda c: np.allclose(
            c.scene["/knee/ligament_ACL"]["points"][:2], [-13.57e-3, -0.75e-3], atol=1e-7
        )
    )
    told = "ACL femur\nx \u221213.57 mm\ny \u22120.75 mm\nbound \u00b11.00 mm\n20\u00d7 magnified"
    visitor.wait(lambda c: c.scene["/handles/label"].get("text") == told)


def test_a_slider_moves_the_handle(page, visitor, hand):
    hand.choose()
    before = page.view.handles.hits[0].position.copy()
    visitor.set(widget(page.view.knee.sliders[0]), -13.5)
    eventually(lambda: page.view.handles.hits[0].position[0] > before[0] + 9 * MM)
    shown = page.view.handles.hits[0].position - before
    assert shown[0] == pytest.approx(20 * 0.5 * MM), "twenty times magnified"
    assert shown[1] == pytest.approx(0.0)


def test_every_handle_stops_at_its_bound_and_is_drawn_home(page, visitor, hand):
    for handle in HANDLES:
        own, box = Hand(page, visitor, handle.name), box_of(page.state, handle)
        own.take()
        own.to(*(box.high + 5.0 * (box.high - box.low)))
        eventually(lambda own=own, box=box: own.values == box.high.tolist())
        own.let_go(*(box.home + 0.02 * (box.high - box.home)))
        assert own.values == box.home.tolist()
    assert page.state.at_baseline


def test_a_tibial_handle_is_read_at_the_pose_when_it_was_taken(page, visitor, hand):
    own = Hand(page, visitor, "lcl_tibia")
    own.take()
    loupe = page.handles.grabs["lcl_tibia"].loupe
    home = box_of(page.state, own.handle).home
    own.to(*(home + [0.6 * MM, -0.4 * MM]))
    eventually(lambda: own.values != home.tolist())
    np.testing.assert_allclose(own.values, home + [0.6 * MM, -0.4 * MM], atol=1e-12)
    turn = math.acos(loupe.directions[0, 0])
    eventually(lambda: abs(page.poses[0].flexion - turn) > 1e-3)
    stands = page.view.handles.hits[HANDLES.index(own.handle)]
    under_the_hand = loupe.at(np.array(own.values))
    eventually(lambda: np.allclose(stands.position[:2], under_the_hand, atol=1e-7))
    own.let_go(*(home + [0.6 * MM, -0.4 * MM]))
    np.testing.assert_allclose(own.values, home + [0.6 * MM, -0.4 * MM], atol=1e-12)


def test_the_motion_waits_while_a_handle_is_held(page, visitor, hand):
    play(visitor, page)
    eventually(lambda: not page.view.handles.root.visible)
    hand.taken = hand.place(*hand.values)
    hand.tell("start", hand.taken)
    eventually(lambda: not page.playback.playing)
    eventually(lambda: page.view.handles.root.visible)
    hand.let_go()
    eventually(lambda: page.playback.playing)
    pause(visitor, page)


@pytest.mark.parametrize(
    ("name", "edge", "bound", "unit"),
    [
        ("acl_femur", 1, "geometry_mm", MM),
        (RADIUS, 0, "geometry_mm", MM),
        (SLOPE, 1, "slope_deg", math.radians(1.0)),
    ],
)
def test_an_edge_of_the_box_is_the_bound_of_its_group(page, visitor, hand, name, edge, bound, unit):
    own = Hand(page, visitor, name, edge)
    side, box = (-1, 1)[edge % 2], box_of(page.state, own.handle)

    def at(half):
        away = np.zeros(len(box.home))
        away[0] = side * half * unit
        return box.home + away

    own.take(*at(1.0))
    for asked, taken in ((1.5, 1.5), (-3.0, 0.1), (99.0, 10.0)):
        own.to(*at(asked))
        eventually(lambda t=taken: bound_now(page.state, bound) == t)
        visitor.wait(lambda c, t=taken: c.values[widget(page.view.knee.bounds[bound])] == t)
    own.let_go(*at(1.2))
    assert bound_now(page.state, bound) == 1.2
    slider, home = page.view.knee.sliders[own.handle.indices[0]], box.home[0] / unit
    eventually(lambda: slider.max == pytest.approx(home + 1.2))
    eventually(lambda: page.state.surrogate is not None)


def test_a_drag_is_one_step_however_long_the_hand_rests(page, visitor, hand, monkeypatch):
    monkeypatch.setattr(history, "PAUSE", 0.0)
    hand.take()
    for mm in (-13.8, -13.6, -13.4):
        hand.to(mm * MM, -0.3 * MM)
        eventually(lambda mm=mm: hand.values[0] == mm * 1e-3)
    hand.let_go(-13.2 * MM, -0.3 * MM)
    hand.taken = hand.place(*hand.values)
    hand.tell("start", hand.taken)  # no click, which would be the second of two
    eventually(lambda: page.handles.grabs)
    hand.let_go(-13.1 * MM, -0.3 * MM)
    assert hand.values[0] == -13.1 * 1e-3
    for before in (-13.2, -14.0):
        give(visitor, page, "Undo")
        eventually(lambda before=before: hand.values[0] == before * 1e-3)


def test_two_clicks_put_a_handle_home(page, visitor, hand):
    visitor.set(widget(page.view.knee.sliders[0]), -13.5)
    eventually(lambda: page.state.x[0] == -13.5e-3)
    visitor.click(hand.node)
    time.sleep(0.05)
    assert page.state.x[0] == -13.5e-3
    visitor.click(hand.node)
    eventually(lambda: page.state.at_baseline)
    visitor.wait(lambda c: c.values[widget(page.view.knee.sliders[0])] == -14.0)


def test_escape_puts_back_what_a_drag_has_changed(page, visitor, hand):
    visitor.set(widget(page.view.knee.sliders[0]), -13.5)
    eventually(lambda: page.state.x[0] == -13.5e-3)
    hand.take()
    hand.to(-13.1 * MM, 0.2 * MM)
    eventually(lambda: hand.values == [-13.1 * 1e-3, 0.2 * 1e-3])
    escape(visitor, page)
    eventually(lambda: hand.values == [-13.5 * 1e-3, -0.3 * 1e-3])
    hand.to(-13.0 * MM, 0.0)
    hand.let_go(-13.0 * MM, 0.0)
    assert hand.values == [-13.5 * 1e-3, -0.3 * 1e-3], "the hand is still down, and moves nothing"
    escape(visitor, page)
    eventually(lambda: page.handles.chosen is None)
    give(visitor, page, "Undo")
    eventually(lambda: page.state.at_baseline)  # a drag that came to nothing is no step


def test_escape_at_an_edge_gives_the_bound_and_the_knee_back(page, visitor, hand):
    visitor.set(widget(page.view.knee.sliders[0]), -13.1)
    eventually(lambda: page.state.x[0] == -13.1 * 1e-3)
    own = Hand(page, visitor, "condyle", 1)
    own.take(1.0 * MM, 0.0)
    own.to(0.5 * MM, 0.0)
    eventually(lambda: page.state.x[0] == -13.5 * 1e-3)
    escape(visitor, page)
    eventually(lambda: bound_now(page.state, "geometry_mm") == 1.0)
    eventually(lambda: page.state.x[0] == -13.1 * 1e-3)
    own.let_go()


def test_what_is_held_fixed_says_why_and_stays(page, visitor, hand):
    visitor.set(widget(page.view.knee.case), "material")
    eventually(lambda: page.state.bounds.case == "material")
    try:
        hand.take()
        hand.to(-13.0 * MM, 0.0)
        is_told(visitor, "ACL femur is held fixed: the bounds let only material vary.")
        hand.let_go(-13.0 * MM, 0.0)
        assert page.state.at_baseline
    finally:
        visitor.set(widget(page.view.knee.case), "both")
        eventually(lambda: page.state.bounds.case == "both")


def test_the_second_visitor_at_a_handle_is_told_and_moves_nothing(app, page, visitor, hand):
    with WebSocketClient(app.server.get_port()) as other:
        other.wait(lambda c: c.counts.get("ReplayDoneMessage"))
        hand.take()
        second = Hand(page, other, "acl_femur")
        second.taken = hand.taken
        second.tell("start", hand.taken)
        is_told(other, "ACL femur is in another visitor's hand.")
        second.to(-13.0 * MM, 0.0)
        second.tell("end", hand.taken)
        elsewhere = Hand(page, other, "pcl_femur")
        elsewhere.take()
        elsewhere.let_go(-9.0 * MM, -9.0 * MM)
        assert elsewhere.values == [-9.0 * 1e-3, -9.0 * 1e-3]
        hand.let_go(-13.8 * MM, -0.3 * MM)
        assert hand.values == [-13.8 * 1e-3, -0.3 * 1e-3]
        other.wait(lambda c: c.values[widget(page.view.knee.sliders[0])] == pytest.approx(-13.8))


def test_who_leaves_lets_go(app, page, visitor, hand):
    with WebSocketClient(app.server.get_port()) as other:
        other.wait(lambda c: c.counts.get("ReplayDoneMessage"))
        leaving = Hand(page, other, "acl_femur")
        leaving.take()
        leaving.to(-13.8 * MM, -0.3 * MM)
        eventually(lambda: leaving.values == [-13.8 * 1e-3, -0.3 * 1e-3])
    eventually(lambda: not page.handles.grabs)
    hand.take()
    hand.let_go(-13.7 * MM, -0.3 * MM)
    assert hand.values == [-13.7 * 1e-3, -0.3 * 1e-3]


def test_no_place_moves_nothing_and_is_told_once(page, visitor, hand):
    hand.take()
    hand.to(-13.8 * MM, -0.3 * MM)
    eventually(lambda: hand.values == [-13.8 * 1e-3, -0.3 * 1e-3])
    nowhere = ((math.nan, 0.0, 0.0), (0.0, math.inf, 0.02), (1e300, 0.0, 0.0))
    for place in nowhere:
        hand.tell("update", place)
    is_told(visitor, "ACL femur: no place on screen. The last value stands.")
    hand.tell("end", nowhere[0])
    eventually(lambda: not page.handles.grabs)
    assert hand.values == [-13.8 * 1e-3, -0.3 * 1e-3]
    assert sum("no place" in n["props"]["body"] for n in visitor.notifications) == 1


def test_a_drag_that_never_began_moves_nothing(page, visitor, hand):
    hand.taken = (0.0, 0.0, 0.02)
    hand.tell("update", hand.place(-13.0 * MM, 0.0))
    hand.tell("end", hand.place(-13.0 * MM, 0.0))
    for name in ("/handles/nobody", "/knee/femur", "/handles/edge_1"):
        visitor.drag(name, "start", hand.taken, hand.taken)
    hand.take()
    hand.let_go()
    assert page.state.at_baseline


def test_a_drag_from_the_side_is_read_in_the_sagittal_plane(app, page, visitor, hand):
    press(visitor, page.view.transport.view, "3D")
    eventually(lambda: page.view.scene.spatial)
    try:
        own = Hand(page, visitor, "mcl_tibia")
        own.take()
        eye = np.array(next(iter(app.server.get_clients().values())).camera.position)
        home = box_of(page.state, own.handle).home
        wanted = np.array(own.place(*(home + [0.5 * MM, 0.5 * MM])))
        assert wanted[2] == pytest.approx(-0.034)
        own.tell("end", tuple(eye + 0.9 * (wanted - eye)))
        eventually(lambda: not page.handles.grabs)
        np.testing.assert_allclose(own.values, home + [0.5 * MM, 0.5 * MM], atol=1e-9)
    finally:
        press(visitor, page.view.transport.view, "2D")
        eventually(lambda: not page.view.scene.spatial)


def test_the_switch_hides_them(page, visitor, hand):
    eventually(lambda: page.view.handles.root.visible)
    visitor.set(widget(page.view.look.handles), False)
    eventually(lambda: not page.view.handles.root.visible)
    visitor.set(widget(page.view.look.handles), True)
    eventually(lambda: page.view.handles.root.visible)


def test_a_handle_has_words_for_a_pointer_and_grows_for_a_class(page, visitor, hand):
    def told():
        content = visitor.props[widget(page.view.hints)]["content"]
        return json.loads(html.unescape(content.split('"')[3]))

    visitor.set(widget(page.view.knee.sliders[0]), -13.5)
    words = "ACL femur\nx \u221213.50 mm\ny \u22120.30 mm, home\nbound \u00b11.00 mm"
    visitor.wait(lambda _: told()["texts"].get("acl_femur") == words)
    hand.choose()
    visitor.set(widget(page.view.knee.sliders[0]), -13.4)
    visitor.wait(lambda _: "acl_femur" not in told()["texts"], 10)  # said beside its loupe
    desk = told()["reach"]
    visitor.set(widget(page.view.look.large), True)
    try:
        visitor.wait(lambda c: c.scene.get("/handles/acl_tibia", {}).get("scale", [0])[0] > 1.0)
        visitor.wait(lambda _: told()["reach"] == pytest.approx(CLASS_SIZE * desk))
        ring = page.view.handles._rings[HANDLES.index(BY_NAME["acl_tibia"])]
        eventually(lambda: np.abs(ring.points).max() == pytest.approx(CLASS_SIZE * 2.1e-3))
    finally:
        visitor.set(widget(page.view.look.large), False)
        eventually(lambda: not page.view.large)


def test_the_live_worst_case_follows_a_drag(page, visitor, hand):
    eventually(lambda: page.exact_ready)
    visitor.set(widget(page.view.search.live), True)
    eventually(lambda: page.live.shown)
    hand.take()
    hand.let_go(-13.6 * MM, -0.3 * MM)
    middle = NAMES.index("acl_femur_x")
    eventually(lambda: page.state.result.model.space.centre[middle] == -13.6 * 1e-3)
    visitor.set(widget(page.view.search.live), False)
    eventually(lambda: not page.live.on)

"""The geometry of handles: places, loupes, boxes, and what a hand's place means."""

import math

import numpy as np
import pytest

import kneecore
from kneecore import LIGAMENTS, NAMES
from kneecore.knee.physics.pose import STATION
from kneeviz.geometry.handles import (
    BY_NAME,
    HANDLES,
    RADIUS,
    REACH,
    SLOPE,
    Box,
    corners,
    gain_for,
    half_range_at,
    loupe_around,
    on_plane,
    place,
    settle,
)
from kneeviz.geometry.mechanism import Pose, ligament_segments, tibia_at_contact
from kneeviz.views.scene.clicks import Clicks

BASELINE = np.array(kneecore.packaged_knee().baseline)
SLIDER = np.array([1e-3, 1e-3])
UNIT_BOX = Box(
    low=np.array([9e-3, -1e-3]), high=np.array([11e-3, 1e-3]), home=np.array([10e-3, 0.0])
)
BENT = 0.9


def pose(x, flexion=BENT):
    at = tibia_at_contact(x, flexion, STATION, 0.0)
    return Pose(
        flexion=flexion, moment=0.0, tibia_position=at, tension=np.zeros(4), contact_force=0.0
    )


def loupe(handle, gain=20.0, flexion=BENT):
    values = BASELINE[handle.indices]
    return loupe_around(place(handle, BASELINE, pose(BASELINE, flexion)), values, values, gain)


def test_every_geometric_parameter_has_one_handle():
    named = [name for handle in HANDLES for name in handle.parameters]
    assert sorted(named) == sorted(NAMES[:22])
    assert BASELINE[BY_NAME[SLOPE].indices] == BASELINE[NAMES.index("plateau_slope")]


def test_attachments_stand_where_the_ligaments_end():
    segments = ligament_segments(BASELINE, pose(BASELINE))
    for i, ligament in enumerate(LIGAMENTS):
        for end, bone in enumerate(("femur", "tibia")):
            stands = place(BY_NAME[f"{ligament}_{bone}"], BASELINE, pose(BASELINE)).point
            np.testing.assert_allclose(stands, segments[i, end], atol=1e-15)


@pytest.mark.parametrize("handle", HANDLES, ids=lambda h: h.name)
def test_a_handle_goes_where_its_parameters_take_it(handle):
    step = 1e-5 if handle.name == SLOPE else 1e-3
    now = place(handle, BASELINE, pose(BASELINE))
    for k, index in enumerate(handle.indices):
        other = BASELINE.copy()
        other[index] += step
        # The same pose: what is dragged is read at the pose on screen.
        moved = place(handle, other, pose(BASELINE)).point - now.point
        np.testing.assert_allclose(moved, step * now.directions[:, k], atol=1e-9)


@pytest.mark.parametrize("handle", HANDLES, ids=lambda h: h.name)
@pytest.mark.parametrize("flexion", [-0.2, 0.0, 1.9])
def test_a_place_in_the_loupe_is_a_value_and_back(handle, flexion):
    opened = loupe(handle, flexion=flexion)
    value = BASELINE[handle.indices] + 1e-4 * np.arange(1, 1 + len(handle.indices))
    np.testing.assert_allclose(opened.value_at(opened.at(value)), value, rtol=1e-12)
    far = np.linalg.norm(opened.at(value) - opened.anchor)
    near = np.linalg.norm(loupe(handle, 1.0, flexion).at(value) - opened.anchor)
    assert far == pytest.approx(20.0 * near)


def test_a_loupe_opens_where_the_handle_stands():
    handle, x = BY_NAME["acl_tibia"], BASELINE.copy()
    opened_at = x[handle.indices]
    x[handle.indices] += 0.5e-3
    now = place(handle, x, pose(x))
    opened = loupe_around(now, x[handle.indices], opened_at, 20.0)
    away = now.directions @ np.array([0.5e-3, 0.5e-3])
    np.testing.assert_allclose(opened.anchor, now.point - away, atol=1e-15)
    np.testing.assert_allclose(opened.at(x[handle.indices]), now.point + 19.0 * away, atol=1e-15)


@pytest.mark.parametrize(("half_mm", "gain"), [(1.0, 20), (1.8, 10), (0.3, 50), (10, 2), (30, 1)])
def test_the_magnification_makes_a_box_easy_to_hit(half_mm, gain):
    half = 1e-3 * np.array([half_mm, 0.5 * half_mm])
    box = Box(low=-half, high=half, home=np.zeros(2))
    assert gain_for(box, np.eye(2)) == gain
    assert 0.4 * REACH <= gain * half.max() <= REACH * 1.001 or gain == 1


def test_a_box_that_lets_nothing_vary_is_not_magnified():
    box = Box(low=np.zeros(2), high=np.zeros(2), home=np.zeros(2))
    assert box.is_fixed
    assert gain_for(box, np.eye(2)) == 1.0


class TestSettle:
    def settled(self, *away_mm):
        return settle(UNIT_BOX.home + 1e-3 * np.array(away_mm), UNIT_BOX, SLIDER)

    def test_it_keeps_to_the_sliders_digits_bit_by_bit(self):
        found = self.settled(0.4321, -0.8765)
        assert found.value.tolist() == [10.43 * 1e-3, -0.88 * 1e-3]
        assert not found.at_home.any()
        assert not found.at_edge.any()

    def test_home_draws_each_parameter_by_itself(self):
        found = self.settled(0.05, 0.5)
        assert found.value[0] == UNIT_BOX.home[0]
        assert found.at_home.tolist() == [True, False]

    def test_home_lets_go_without_a_jump(self):
        ways = np.linspace(-1.0, 1.0, 4001)
        values = np.array([self.settled(way, 0.0).value[0] for way in ways])
        assert np.abs(np.diff(values)).max() < 0.011e-3
        assert (np.diff(values) >= 0.0).all()

    def test_the_box_holds_whatever_the_hand_does(self):
        found = self.settled(5.0, -1e300)
        assert found.value.tolist() == [UNIT_BOX.high[0], UNIT_BOX.low[1]]
        assert found.at_edge.all()

    def test_an_edge_that_is_no_slider_s_number_is_reached(self):
        box = Box(low=np.array([-1.2345e-3]), high=np.array([1.2345e-3]), home=np.zeros(1))
        assert settle(np.array([1.0]), box, SLIDER[:1]).value[0] == box.high[0]

    def test_what_is_held_stays(self):
        box = Box(
            low=np.array([9e-3, 2e-3]), high=np.array([11e-3, 2e-3]), home=np.array([10e-3, 2e-3])
        )
        found = settle(np.array([10.5e-3, 5e-3]), box, SLIDER)
        assert found.value.tolist() == [10.5 * 1e-3, 2e-3]


@pytest.mark.parametrize("name", ["lcl_tibia", RADIUS, SLOPE])
def test_an_edge_stands_where_its_half_range_is(name):
    handle = BY_NAME[name]
    opened, home = loupe(handle), BASELINE[handle.indices]
    half = 0.7e-3 * np.ones(len(home))
    box = Box(low=home - half, high=home + half, home=home)
    shown = corners(opened, box)
    sides = {(0, -1): (3, 0), (0, 1): (1, 2), (1, -1): (0, 1), (1, 1): (2, 3)}
    for edge, ends in sides.items():
        if edge[0] < len(home):
            middle = shown[list(ends)].mean(axis=0)
            assert half_range_at(middle, opened, box, edge) == pytest.approx(0.7e-3)
            outwards = middle + 20.0 * opened.directions[:, edge[0]] * edge[1] * 0.1e-3
            assert half_range_at(outwards, opened, box, edge) == pytest.approx(0.8e-3)


def test_a_hand_is_read_in_the_sagittal_plane_from_any_side():
    eye = (1.0, 0.5, 2.0)
    inside = np.array([0.02, -0.03, 0.004])
    through = np.array(eye) + 0.7 * (inside - np.array(eye))
    np.testing.assert_allclose(on_plane(eye, tuple(through), 0.004), inside[:2], atol=1e-12)


@pytest.mark.parametrize(
    "point",
    [
        (math.nan, 0.0, 0.0), (0.0, math.inf, 0.0), (0.0, 0.0, math.nan), (0.0, 0.0, 2.0),
        (0.0, 0.0, 3.0), (1e308, 0.0, 1.9999),
    ],
)  # fmt: skip
def test_what_is_no_place_is_none(point):
    met = on_plane((0.0, 0.0, 2.0), point, 0.0)
    assert met is None


def test_two_clicks_make_a_double_click_and_three_do_not_make_two():
    now = [0.0]
    clicks = Clicks(lambda: now[0])
    assert not clicks.is_second(1, "a")
    now[0] = 0.3
    assert clicks.is_second(1, "a")
    now[0] = 0.5
    assert not clicks.is_second(1, "a")
    assert not clicks.is_second(2, "a"), "another visitor's"
    assert not clicks.is_second(1, "b"), "another handle"
    now[0] = 1.0
    assert not clicks.is_second(1, "b"), "too late"

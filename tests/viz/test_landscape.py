"""The landscape's shapes: points in the box, sheets with holes, marks, the box around them."""

from dataclasses import replace

import numpy as np
import pytest

import kneecore
from kneecore import NAMES, ParameterSpace
from kneecore.knee.readings import DEFICIT
from kneeviz.geometry import surfaces
from kneeviz.geometry.picture import Mark, picture
from kneeviz.geometry.surfaces import CENTRE, HEIGHT, SIDE, Box
from kneeviz.state.knee import KneeState
from kneeviz.state.landscape import LandscapeState
from kneeviz.views import theme
from kneeviz.views.html.landscape import error_words, landscape_key

FIRST, SECOND = "condyle_x", "acl_femur_x"
AT = NAMES.index(FIRST), NAMES.index(SECOND)
LOAD = "+5 N m"


@pytest.fixture(scope="module")
def space():
    return ParameterSpace()


@pytest.fixture(scope="module")
def surrogate(space):
    return kneecore.fit_surrogate(kneecore.Knee(space))


@pytest.fixture(scope="module")
def found(space, surrogate):
    return kneecore.landscape(
        kneecore.Knee(space), (FIRST, SECOND), surrogate=surrogate, n_points=5
    )


@pytest.fixture(scope="module")
def shown(found, surrogate, space):
    own = np.degrees(kneecore.simulate(space.baseline).flexion)
    said = surrogate.predict(space.baseline)
    corner = np.array(space.upper)
    worst = [(corner, own + 30.0), (np.array(space.lower), own - 40.0)]
    return picture(found, LOAD, own_deg=own, predicted_deg=said, surrogate=surrogate, worst=worst)


def height_of(box, point):
    return box.low + (point[1] - CENTRE[1] + HEIGHT / 2) / HEIGHT * (box.high - box.low)


class TestBox:
    def test_corners_and_directions(self):
        box = Box(low=-10.0, high=30.0, step=10.0)
        half = np.array([SIDE / 2, HEIGHT / 2, SIDE / 2])
        np.testing.assert_allclose(box.place(0, 0, -10) - CENTRE, half * (-1, -1, 1), atol=1e-12)
        np.testing.assert_allclose(box.place(1, 1, 30) - CENTRE, half * (1, 1, -1), atol=1e-12)
        assert box.ticks == [-10.0, 0.0, 10.0, 20.0, 30.0]
        assert box.place(np.zeros(7), 0.5, np.zeros(7)).shape == (7, 3)

    @pytest.mark.parametrize(("span", "step"), [(10.0, 2.0), (25.0, 5.0), (1.0, 0.2), (53.0, 10.0)])
    def test_steps_are_round(self, span, step):
        assert surfaces.nice_step(span, 5) == pytest.approx(step)

    def test_it_holds_all_that_is_shown(self, shown):
        box = surfaces.box_around(shown, zoom=False)
        every = [shown.model, shown.surrogate, shown.training[:, 2], [m.value for m in shown.worst]]
        assert all(box.holds(values).all() for values in every)
        assert box.low / box.step == pytest.approx(round(box.low / box.step))

    def test_zoomed_it_holds_the_sheets_and_the_visitors_knee(self, shown):
        wide, close = (surfaces.box_around(shown, zoom=z) for z in (False, True))
        assert box_height(close) < box_height(wide)
        assert close.holds(shown.model).all()
        assert close.holds(shown.surrogate).all()
        assert close.holds(shown.own.value)
        assert not any(close.holds(mark.value) for mark in shown.worst)

    def test_a_flat_sheet_is_flat(self, shown):
        flat = replace(
            shown,
            model=np.full((5, 5), 3.0),
            surrogate=np.full((5, 5), 3.0 + 1e-9),
            own=Mark(place=(0.5, 0.5), value=3.0),
            predicted=None,
        )
        box = surfaces.box_around(flat, zoom=True)
        assert box_height(box) >= 1.0
        assert np.ptp(surfaces.sheet(box, flat.model)[0][:, 1]) < 1e-9


def box_height(box):
    return box.high - box.low


class TestSheets:
    def test_vertices_stand_at_the_grids_angles(self, shown, found):
        box = surfaces.box_around(shown, zoom=False)
        vertices, faces = surfaces.sheet(box, shown.model)
        assert faces.shape == (2 * 4 * 4, 3)
        for a, b in ((0, 0), (4, 0), (1, 3)):
            point = vertices.reshape(5, 5, 3)[a, b]
            assert height_of(box, point) == pytest.approx(found.y[a, b, 5])
            assert point[0] == pytest.approx(CENTRE[0] + SIDE * (a / 4 - 0.5))
            assert point[2] == pytest.approx(-SIDE * (b / 4 - 0.5))

    def test_the_triangles_cover_the_floor_once(self, shown):
        box = surfaces.box_around(shown, zoom=False)
        vertices, faces = surfaces.sheet(box, shown.model)
        a, b, c = (vertices[faces[:, k]][:, [0, 2]] for k in range(3))
        one, two = b - a, c - a
        area = 0.5 * np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
        assert area.sum() == pytest.approx(SIDE**2)

    def test_a_failed_model_leaves_a_hole(self, shown):
        holed = shown.model.copy()
        holed[2, 2] = np.nan
        box = surfaces.box_around(shown, zoom=False)
        vertices, faces = surfaces.sheet(box, holed)
        assert np.isfinite(vertices).all()
        assert 12 not in faces
        assert len(faces) == 32 - 6
        lines = surfaces.mesh_lines(box, holed)
        assert np.isfinite(lines).all()
        assert len(lines) == len(surfaces.mesh_lines(box, shown.model)) - 4

    def test_lines_lie_on_the_sheet(self, shown):
        box = surfaces.box_around(shown, zoom=False)
        corners = {tuple(v) for v in surfaces.sheet(box, shown.model)[0].round(9)}
        ends = surfaces.mesh_lines(box, shown.model).reshape(-1, 3).round(9)
        assert {tuple(v) for v in ends} <= corners


class TestMarks:
    def test_the_visitors_knee_lies_on_the_true_models_sheet(self, shown, found):
        assert shown.own.place == (0.5, 0.5)
        assert shown.own.value == pytest.approx(found.y[2, 2, 5])
        assert shown.predicted.value == pytest.approx(found.y_surrogate[2, 2, 5])

    def test_the_worst_cases_stand_at_their_own_values(self, shown):
        one, two = shown.worst
        assert (one.place, two.place) == ((1.0, 1.0), (0.0, 0.0))
        assert one.value == pytest.approx(shown.own.value + 30.0)
        box = surfaces.box_around(shown, zoom=False)
        assert height_of(box, surfaces.spot(box, one)) == pytest.approx(one.value)
        bottom, top = surfaces.stem(box, one)[0]
        np.testing.assert_allclose(top, surfaces.spot(box, one))
        assert height_of(box, bottom) == pytest.approx(box.low)

    def test_a_mark_beyond_the_bounds_is_not_in_the_box(self, shown):
        box = surfaces.box_around(shown, zoom=False)
        assert box.has(shown.own)
        assert not box.has(replace(shown.own, place=(1.2, 0.5)))
        assert not box.has(replace(shown.own, value=box.high + 1.0))

    def test_training_knees_stand_at_their_own_angles(self, shown, surrogate, space):
        places = space.to_unit(surrogate.training_x)[:, AT]
        np.testing.assert_allclose(shown.training[:, :2], places)
        np.testing.assert_allclose(shown.training[:, 2], surrogate.training_y[:, 5])

    def test_beads_are_balls_around_their_points(self):
        ball = (np.array([[0.0, 0, 1], [0, 1, 0], [1, 0, 0]]), np.array([[0, 1, 2]]))
        points = np.array([[0.0, 0, 0], [5.0, 6, 7]])
        vertices, faces = surfaces.beads(points, ball)
        np.testing.assert_array_equal(faces, [[0, 1, 2], [3, 4, 5]])
        np.testing.assert_array_equal(vertices[3:], ball[0] + points[1])

    def test_a_deficit_is_never_negative(self, found, surrogate, space):
        own = np.degrees(kneecore.simulate(space.baseline).flexion)
        shown = picture(found, DEFICIT, own_deg=own, predicted_deg=None, surrogate=surrogate)
        assert own[5] < 0.0
        assert shown.own.value == 0.0
        assert min(shown.model.min(), shown.training[:, 2].min()) >= 0.0
        assert shown.worst == (None, None)


class TestWords:
    def test_the_error_is_that_of_the_sheets(self, found):
        gap = np.abs(found.y_surrogate - found.y)[..., 5]
        words = error_words(found, LOAD)
        assert f"{gap.mean():.2f}°" in words
        assert f"{gap.max():.2f}°" in words

    def test_the_key_says_that_the_training_knees_lie_off_the_sheets(self, found, shown):
        key = landscape_key(found, shown, LOAD, theme.LIGHT, zoom=False)
        assert "25 knees simulated" in key
        assert f"{found.counts['unsettled']:,} unsettled at some load" in key
        assert "the 50 knees" in key
        assert "lie off the sheets" in key
        far = shown.training.copy()
        far[:3, 2] += 60.0
        close = landscape_key(found, replace(shown, training=far), LOAD, theme.LIGHT, zoom=True)
        assert "47 of the 50 knees" in close
        assert "beyond" in close

    def test_failures_are_counted_and_a_missing_surrogate_told(self, found, shown):
        broken = found.y.copy()
        broken[0, 0] = np.nan
        bare = replace(found, y=broken, y_surrogate=None)
        key = landscape_key(bare, shown, LOAD, theme.LIGHT, zoom=False)
        assert "1 failed" in key
        assert "no surrogate" in key


class TestAxes:
    def test_two_axes_never_have_the_same_parameter(self):
        show = LandscapeState(lambda *_: None)
        one, two = show.names
        show.choose(0, two)
        assert show.names == (two, one)
        show.choose(1, "mcl_femur_x")
        assert show.names == (two, "mcl_femur_x")

    def test_parameters_that_are_held_give_way(self):
        show = LandscapeState(lambda *_: None)
        assert show.fit_names(ParameterSpace(case="material"))
        assert len(set(show.names)) == 2
        assert all("stiffness" in n or "modulus" in n or "ratio" in n for n in show.names)
        held = dict.fromkeys(NAMES, 0.0)
        assert not show.fit_names(ParameterSpace(half_ranges=held | {"condyle_x": 1e-3}))

    def test_the_same_knee_is_computed_once(self):
        posted = []
        show = LandscapeState(lambda key, value: posted.append((key, value)))
        state = KneeState(kneecore.packaged_knee())
        show.ask(state)
        assert show._asked is None  # the model is not ready
        state.update(state.x)
        show.ask(state)
        first = show._asked
        show.ask(state)
        assert show._asked is first
        state.x[0] += 1e-4
        state.update(state.x)
        show.ask(state)
        assert show._asked is not first
        show.stop()

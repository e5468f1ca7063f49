from dataclasses import replace

import numpy as np
import pytest
from searches import searched

import kneecore
from kneecore import NAMES, ParameterError, packaged_knee, parameter_table
from kneecore.knee.file import parse_knee
from kneecore.knee.parameters import widened
from kneeviz.state.bounds import SCALE, Bounds, shown_bounds
from kneeviz.state.knee import KneeState
from kneeviz.state.presets import PRESETS, preset_knee, random_knee

ACL_X = NAMES.index("acl_femur_x")
NU = NAMES.index("poissons_ratio")


@pytest.fixture
def state():
    return KneeState(packaged_knee())


def own_knee(**changes):
    knee = packaged_knee()
    half = np.array(knee.half_ranges)
    half[ACL_X] = 2.5e-3
    return replace(knee, title="Mine", half_ranges=half, **changes)


class TestBounds:
    def test_the_packaged_space_needs_no_file(self):
        space = Bounds(geometry_mm=0.5).space(packaged_knee())
        assert space.half_ranges is None
        assert (space.upper - space.lower)[ACL_X] == pytest.approx(1e-3)

    def test_a_files_half_ranges_stand_until_a_bound_is_given(self):
        knee = own_knee()
        assert (Bounds().space(knee).upper - knee.baseline)[ACL_X] == pytest.approx(2.5e-3)
        given = Bounds(geometry_mm=0.5).space(knee)
        assert (given.upper - knee.baseline)[ACL_X] == pytest.approx(0.5e-3)
        material = NAMES.index("acl_stiffness")
        assert (given.upper - knee.baseline)[material] == pytest.approx(3.5e6)

    def test_the_widest_half_ranges_are_shown(self):
        assert shown_bounds(own_knee()) == pytest.approx((2.5, 1.0, 10.0, 0.0))

    def test_other_bounds_draw_the_knee_into_them(self, state):
        state.x = widened(state.space.upper, 32)
        state.set_bounds(Bounds(geometry_mm=0.2))
        assert (state.x[:28] <= state.space.upper).all()
        assert state.surrogate is None

    def test_impossible_bounds_change_nothing(self, state):
        before = state.space
        with pytest.raises(ParameterError):
            state.set_bounds(Bounds(geometry_mm=0.0, slope_deg=0.0, material_percent=0.0))
        assert state.space is before
        assert state.bounds == Bounds()


class TestKnees:
    def test_update_gives_kneecores_answer(self, state):
        x = preset_knee("Larger condyle", state.space)
        solved = state.update(x)
        np.testing.assert_array_equal(solved.response.flexion, kneecore.simulate(x).flexion)
        assert state.current is solved
        assert state.predicted is None

    def test_the_surrogate_predicts_the_same_knee(self, state):
        state.fit()
        x = random_knee(state.space, np.random.default_rng(0))
        state.update(x)
        np.testing.assert_array_equal(state.predicted, np.radians(state.surrogate.predict(x)))
        assert len(state.training_curves) == 50

    @pytest.mark.parametrize("name", PRESETS)
    def test_presets_lie_in_the_bounds_and_off_the_baseline(self, state, name):
        x = preset_knee(name, state.space)
        assert (x >= state.space.lower).all()
        assert (x <= state.space.upper).all()
        assert (x != state.space.baseline).any()

    def test_a_preview_is_not_kept(self, state):
        state.update(state.x)
        state.preview(state.space.upper)
        np.testing.assert_array_equal(state.x[:28], state.space.baseline)
        np.testing.assert_array_equal(state.current.x[:28], state.space.upper)


@pytest.fixture(scope="module")
def result():
    return searched(pop_size=20, n_generations=5)


class TestResult:
    def test_its_knees_are_prepared_in_order(self, state, result):
        state.take_result(result)
        one, two = state.worst
        np.testing.assert_array_equal(one.x[:28], result.x[0])
        assert one.sweep.at_moment(5.0).flexion < two.sweep.at_moment(5.0).flexion

    def test_it_is_stale_once_the_bounds_differ(self, state, result):
        assert not state.is_stale(result)
        state.set_bounds(Bounds(geometry_mm=0.9))
        assert state.is_stale(result)
        state.set_bounds(Bounds(rest_length="fixed"))
        assert state.is_stale(result)
        state.set_bounds(Bounds())
        assert not state.is_stale(result)


class TestSliderRange:
    def test_it_follows_the_bounds(self, state):
        assert state.slider_range(ACL_X) == pytest.approx((-15.0, -13.0))
        state.set_bounds(Bounds(geometry_mm=2.0))
        assert state.slider_range(ACL_X) == pytest.approx((-16.0, -12.0))

    def test_it_holds_a_value_beyond_the_bounds(self, state):
        state.x[ACL_X] = -17e-3
        assert state.slider_range(ACL_X) == pytest.approx((-17.0, -13.0))

    def test_a_held_parameter_still_has_a_range(self, state):
        state.set_bounds(Bounds(case="material"))
        low, high = state.slider_range(ACL_X)
        assert low < -14.0 < high


class TestKneeFile:
    def test_baseline_and_current_values_come_back_apart_and_exactly(self, state):
        state.x = widened(random_knee(state.space, np.random.default_rng(1)), 32)
        again = KneeState(parse_knee(state.knee_text()))
        np.testing.assert_array_equal(again.x, state.x)
        np.testing.assert_array_equal(again.space.baseline, state.space.baseline)
        np.testing.assert_allclose(again.space.lower, state.space.lower, rtol=1e-12)
        np.testing.assert_allclose(again.space.upper, state.space.upper, rtol=1e-12)

    def test_the_clipped_bound_of_poissons_ratio_comes_back(self, state):
        again = KneeState(parse_knee(state.knee_text()))
        assert again.space.upper[NU] == pytest.approx(0.499)
        assert again.space.lower[NU] == pytest.approx(0.414)

    def test_changed_bounds_are_written(self, state):
        state.set_bounds(Bounds(geometry_mm=0.4))
        again = KneeState(parse_knee(state.knee_text()))
        assert again.slider_range(ACL_X) == pytest.approx((-14.4, -13.6))

    def test_a_fixed_case_keeps_the_other_half_ranges(self, state):
        state.set_bounds(Bounds(case="geometry"))
        again = KneeState(parse_knee(state.knee_text()))
        stiffness = NAMES.index("acl_stiffness")
        assert (again.space.upper - again.space.lower)[stiffness] == pytest.approx(7e6)


def test_scales_are_the_tables():
    assert [row.scale for row in parameter_table(rest_lengths=True)] == SCALE.tolist()


class TestRestLengths:
    """The four that are uncertain only if they are asked for."""

    def test_held_at_first(self, state):
        assert state.strain_free
        assert not any(state.is_free(i) for i in range(28, 32))
        assert "rest_length_change" not in state.knee_text()

    def test_a_bound_sets_them_free_and_no_bound_brings_them_back(self, state):
        state.set_bounds(Bounds(rest_length_mm=1.0))
        assert all(state.is_free(i) for i in range(28, 32))
        assert state.slider_range(28) == pytest.approx((-1.0, 1.0))
        assert not state.strain_free
        state.update(random_knee(state.space, np.random.default_rng(2)))
        assert state.x[28:].all()
        again = KneeState(parse_knee(state.knee_text()))
        np.testing.assert_array_equal(again.x, state.x)
        np.testing.assert_allclose(again.space.upper, state.space.upper, rtol=1e-12)
        state.set_bounds(Bounds())
        assert not state.x[28:].any()
        assert state.strain_free

    def test_the_surrogate_knows_them_where_they_vary(self, state):
        state.set_bounds(Bounds(rest_length_mm=1.0))
        state.fit()
        x = np.array(state.x)
        before = state.predict(x)
        x[28] = 1e-3
        assert np.abs(state.predict(x) - before).max() > 1e-3

    def test_the_last_answer_is_not_moved_by_a_slider(self, state):
        solved = state.update(state.x)
        state.x[3] += 1e-3
        assert solved.x[3] == pytest.approx(state.x[3] - 1e-3)

    def test_a_knee_with_other_rest_lengths_has_no_prediction_where_they_are_held(self, state):
        state.fit()
        x = np.array(state.x)
        x[28] = 1e-3
        solved = state.update(x)
        assert state.predicted is None
        np.testing.assert_array_equal(solved.response.flexion, kneecore.simulate(x).flexion)
        assert len(solved.sweep.moment) == 12

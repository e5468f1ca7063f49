import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kneecore
from kneecore import MOMENT
from kneeviz.geometry.sweep import sweep_of
from kneeviz.views.charts import series

X = kneecore.packaged_knee().baseline


@pytest.fixture(scope="module")
def response():
    return kneecore.simulate(X)


@pytest.fixture(scope="module")
def sweep(response):
    return sweep_of(X, response)


def test_moments_rise_and_hold_the_load_free_angle(response):
    moments, angles = series.with_load_free(response.flexion, strain_free=True)
    assert (np.diff(moments) > 0).all()
    assert angles[6] == pytest.approx(54.79)
    assert angles[-1] == pytest.approx(-3.72, abs=0.01)
    assert angles[0] == pytest.approx(118.99, abs=0.01)


def test_without_a_common_load_free_pose_there_are_twelve(response):
    moments, angles = series.with_load_free(response.flexion, strain_free=False)
    assert len(moments) == len(angles) == 12
    assert 0.0 not in moments


def test_many_curves_at_once_are_the_curves_one_by_one(response):
    both = np.stack([response.flexion, response.flexion + 0.1])
    _, many = series.with_load_free(both, strain_free=True)
    moments, one = series.with_load_free(response.flexion, strain_free=True)
    np.testing.assert_array_equal(many[0], one)
    axis = series.moment_axis(moments, [0.3])
    np.testing.assert_array_equal(
        series.angles_at(axis, moments, many)[0], series.angles_at(axis, moments, one)
    )


@given(st.floats(-5.0, 5.0))
def test_a_marked_moment_leaves_the_curve_as_it_was(moment):
    moments = np.sort(np.append(MOMENT, 0.0))
    angles = np.linspace(119.0, -4.0, 13)
    axis = series.moment_axis(moments, [moment])
    curve = series.angles_at(axis, moments, angles)
    within = np.isfinite(curve)
    np.testing.assert_allclose(curve[within], np.interp(axis[within], moments, angles), atol=1e-9)
    assert np.isnan(curve[[0, -1]]).all()


def test_a_mark_is_one_point():
    axis = np.array([0.0, 1.0, 2.0])
    marked = series.mark(axis, 1.1, 42.0)
    assert marked[1] == 42.0
    assert np.isnan(marked[[0, 2]]).all()


@given(st.lists(st.floats(-80, 170), min_size=1, max_size=20))
def test_the_angle_range_holds_all_curves(angles):
    low, high = series.angle_range([np.array([*angles, np.nan])])
    assert low <= min(angles)
    assert high >= max(angles)
    assert low <= -30
    assert high >= 135


def test_an_angle_axis_has_every_corner_and_a_constant_length(sweep):
    axis = series.angle_axis([sweep, None], [0.0, 10.0], 40)
    assert len(axis) == 40
    assert (np.diff(axis) >= 0).all()
    assert set(np.degrees(sweep.flexion)) <= set(axis)
    drawn = series.over_angle(axis, sweep, sweep.tension[:, 0])
    at_corner = np.searchsorted(axis, np.degrees(sweep.flexion[0]))
    assert drawn[at_corner] == pytest.approx(sweep.tension[0, 0])


def test_over_angle_draws_nothing_beyond_the_knees_range(sweep):
    drawn = series.over_angle(np.array([-60.0, 50.0, 160.0]), sweep, sweep.tension[:, 1])
    assert np.isnan(drawn).tolist() == [True, False, True]
    assert np.isnan(series.over_angle(np.array([0.0]), None, None)).all()


@pytest.mark.parametrize(("top", "limit"), [(0.0, 100.0), (99.0, 100.0), (101.0, 200.0)])
def test_value_limits_are_whole_steps(top, limit):
    assert series.value_limit(np.array([np.nan, top]), 100.0) == limit


def test_prediction_error_is_in_degrees():
    true = np.zeros(12)
    predicted = np.zeros(12)
    predicted[3] = np.deg2rad(1.2)
    rms, largest = series.prediction_error(predicted, true)
    assert rms == pytest.approx(1.2 / np.sqrt(12))
    assert largest == pytest.approx(1.2)

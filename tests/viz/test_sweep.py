from dataclasses import replace

import numpy as np
import pytest

import kneecore
from kneecore import MOMENT, ParameterSpace
from kneecore.knee.physics.forces import THETA_0
from kneeviz.geometry import mechanism
from kneeviz.geometry.sweep import pose_in_time, sweep_of

X = ParameterSpace().from_unit(np.random.default_rng(3).random(28))


@pytest.fixture(scope="module")
def response():
    return kneecore.simulate(X)


@pytest.fixture(scope="module")
def sweep(response):
    return sweep_of(X, response)


@pytest.fixture(scope="module")
def run():
    return kneecore.trajectory(X)


@pytest.mark.parametrize("k", range(12))
def test_at_a_load_the_pose_is_kneecores(sweep, response, k):
    pose = sweep.at_moment(float(MOMENT[k]))
    assert pose.flexion == pytest.approx(response.flexion[k], abs=1e-12)
    np.testing.assert_allclose(pose.tibia_position, response.tibia_position[k], atol=1e-12)
    np.testing.assert_allclose(pose.tension, response.tension[k], atol=1e-9)
    assert pose.contact_force == pytest.approx(response.contact_force[k])


def test_without_load_it_hangs_strain_free(sweep, response):
    pose = sweep.at_moment(0.0)
    assert pose.flexion == pytest.approx(THETA_0)
    np.testing.assert_allclose(pose.tibia_position, response.load_free_position, atol=1e-12)
    assert not pose.tension.any()


def test_fixed_rest_lengths_have_no_rest_without_load():
    fixed = kneecore.simulate(X, rest_length="fixed")
    sweep = sweep_of(X, fixed, strain_free=False)
    assert len(sweep.moment) == 12
    between = sweep.at_moment(0.0).flexion
    assert between == pytest.approx(0.5 * (fixed.flexion[0] + fixed.flexion[6]))


def test_a_failed_model_has_no_sweep(response):
    from dataclasses import replace

    assert sweep_of(X, replace(response, refinements=-1)) is None


def test_between_loads_the_circle_stays_on_the_plateau(sweep):
    for moment in np.linspace(-5, 5, 41):
        pose = sweep.at_moment(float(moment))
        along, depth = mechanism.contact_coordinates(X, pose.flexion, pose.tibia_position)
        assert sweep.along.min() - 1e-12 <= along <= sweep.along.max() + 1e-12
        assert -1e-12 <= depth <= sweep.depth.max() + 1e-12


def test_share_and_moment_are_inverse_and_turn_evenly(sweep):
    shares = np.linspace(0, 1, 21)
    moments = np.array([sweep.moment_at(s) for s in shares])
    assert moments[0] == 5.0
    assert moments[-1] == -5.0
    np.testing.assert_allclose([sweep.share_at(m) for m in moments], shares, atol=1e-9)
    angles = np.array([sweep.at_moment(float(m)).flexion for m in moments])
    np.testing.assert_allclose(np.diff(angles), np.diff(angles).mean(), rtol=1e-3)
    np.testing.assert_allclose([sweep.share_bent(a) for a in angles], shares, atol=1e-9)


def test_the_share_of_an_angle_is_known_for_a_knee_that_bends_the_other_way(sweep):
    turned = replace(sweep, flexion=sweep.flexion[::-1].copy())
    for moment, flexion in zip(turned.moment, turned.flexion, strict=True):
        assert turned.share_bent(flexion) == pytest.approx(turned.share_at(moment))


def test_in_time_frames_are_kneecores(run):
    for frame in (0, 1, 100, 575):
        pose = pose_in_time(run, 1, float(run.time[frame]))
        assert pose.flexion == pytest.approx(run.flexion[1, frame])
        assert pose.time == pytest.approx(run.time[frame])
    assert pose_in_time(run, 0, 1e9).flexion == run.flexion[0, -1]
    assert pose_in_time(run, 0, -1.0).flexion == pytest.approx(THETA_0)


def test_in_time_between_frames_it_lies_between(run):
    middle = 0.5 * (run.time[10] + run.time[11])
    pose = pose_in_time(run, 0, float(middle))
    assert pose.flexion == pytest.approx(run.flexion[0, 10:12].mean())
    assert pose.moment == run.moment[0, 11]


def test_the_run_ends_where_the_sweep_ends(run, sweep):
    for direction, moment in ((0, 5.0), (1, -5.0)):
        assert pose_in_time(run, direction, 23.0).flexion == pytest.approx(
            sweep.at_moment(moment).flexion, abs=1e-9
        )

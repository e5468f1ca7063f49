"""The dynamic model: the reference response, the naive twin, and bits that must not move."""

import importlib
import math

import naive
import numpy as np
import pytest

import kneecore
from kneecore import (
    MOMENT,
    ModelError,
    ParameterError,
    ParameterSpace,
    simulate,
    simulate_batch,
    trajectory,
)
from kneecore.knee.physics import dynamics, forces
from kneecore.knee.physics.pose import constants
from kneecore.knee.response import prepare

# Reference response of the baseline: moment, ACL, PCL, MCL, LCL, contact (N), AP, indentation (mm).
# Two implementations made apart from each other agree on it; see "The model" in CONTRIBUTING.md.
TABLE = np.array([
    [0.1, 4.0, 0.1, 0.0, 13.6, 15.8, -5.27, 0.27],
    [0.2, 8.6, 0.8, 0.0, 26.0, 31.2, -4.25, 0.42],
    [0.4, 18.3, 3.8, 0.0, 47.0, 60.4, -3.03, 0.65],
    [0.8, 38.5, 14.3, 0.0, 79.7, 115.4, -1.64, 1.00],
    [2.0, 98.4, 65.5, 0.0, 140.6, 266.6, 0.27, 1.75],
    [5.0, 224.0, 238.0, 0.0, 196.9, 588.1, 1.80, 2.97],
    [-0.1, 0.0, 0.6, 15.5, 0.0, 15.8, -10.77, 0.27],
    [-0.2, 0.0, 2.2, 30.6, 0.0, 32.7, -12.04, 0.43],
    [-0.4, 0.0, 7.2, 57.4, 0.0, 64.0, -13.83, 0.68],
    [-0.8, 0.0, 21.8, 101.6, 0.0, 121.7, -16.24, 1.04],
    [-2.0, 0.0, 84.9, 192.8, 0.0, 272.7, -20.35, 1.78],
    [-5.0, 0.0, 286.9, 298.5, 0.0, 575.9, -24.82, 2.93],
])  # fmt: skip
ANGLES_DEG = np.array(
    [42.84912, 38.22785, 32.31455, 24.87589, 12.27515, -3.72408]
    + [67.40873, 72.82855, 79.81318, 88.54478, 102.66324, 118.98642]
)
FIELDS = ("flexion", "tension", "contact_force", "indentation", "ap_position", "tibia_position")


def knees(n, seed=0, bound=1.0, percent=10.0):
    space = ParameterSpace(geometry_bound_mm=bound, material_bound_percent=percent)
    return space.from_unit(np.random.default_rng(seed).random((n, 28)))


def assert_same_bytes(a, b):
    for field in (*FIELDS, "settled", "refinements"):
        left, right = np.asarray(getattr(a, field)), np.asarray(getattr(b, field))
        assert left.tobytes() == right.tobytes(), field


def test_reference_response():
    response = simulate(ParameterSpace().baseline)
    assert response.status == "ok"
    assert response.settled.all()
    np.testing.assert_array_equal(response.moment, TABLE[:, 0])
    np.testing.assert_allclose(np.degrees(response.flexion), ANGLES_DEG, atol=1.1e-5)
    computed = np.column_stack([response.tension, response.contact_force])
    allowed = np.maximum(0.01 * TABLE[:, 1:6], 0.06)
    assert (np.abs(computed - TABLE[:, 1:6]) <= allowed).all()
    np.testing.assert_allclose(1e3 * response.ap_position, TABLE[:, 6], atol=0.006)
    np.testing.assert_allclose(1e3 * response.indentation, TABLE[:, 7], atol=0.006)
    np.testing.assert_allclose(
        1e3 * response.rest_length, [33.947, 25.973, 94.705, 46.178], atol=6e-4
    )


@pytest.mark.parametrize("rest_length", ["recomputed", "fixed"])
@pytest.mark.parametrize(("bound", "percent"), [(1.0, 10.0), (2.5, 30.0)])
def test_kernel_against_the_naive_twin(rest_length, bound, percent):
    x = knees(5, seed=3, bound=bound, percent=percent)
    batch = simulate_batch(x, rest_length=rest_length)
    for model, response in zip(x, batch, strict=True):
        slow = naive.simulate(model, rest_length=rest_length)
        assert response.status == slow["status"]
        if response.status == "failed":
            assert np.isnan(response.flexion).all()
            continue
        assert response.refinements == slow["n_refinements"]
        np.testing.assert_array_equal(response.settled, slow["settled"])
        np.testing.assert_allclose(response.flexion, slow["flexion"], atol=1e-9)
        np.testing.assert_allclose(response.tension, slow["tension"], atol=1e-6)
        np.testing.assert_allclose(response.contact_force, slow["contact_force"], atol=1e-6)
        np.testing.assert_allclose(response.indentation, slow["indentation"], atol=1e-12)
        np.testing.assert_allclose(response.ap_position, slow["ap_position"], atol=1e-11)
        np.testing.assert_allclose(response.tibia_position, slow["tibia_position"], atol=1e-11)


def test_another_baseline_fixes_another_pose():
    baseline, model = knees(2, seed=8)
    response = simulate(model, baseline=baseline)
    slow = naive.simulate(model, baseline=baseline)
    np.testing.assert_allclose(response.flexion, slow["flexion"], atol=1e-9)
    assert np.abs(response.flexion - simulate(model).flexion).max() > 1e-4


def test_load_free_pose_and_rest_lengths_against_the_naive_twin():
    x = knees(200, seed=1, bound=3.0)
    rows = prepare(x, None, "recomputed")
    batch = simulate_batch(x)
    for k in range(len(x)):
        origin, phi = naive.load_free_pose(x[k], naive.BASELINE)
        assert phi == pytest.approx(-forces.THETA_0)
        np.testing.assert_allclose(batch.load_free_position[k], origin, atol=1e-15)
        rest = naive.rest_lengths(x[k], naive.BASELINE, "recomputed")
        np.testing.assert_allclose(batch.rest_length[k], rest, atol=1e-15)
    fixed = constants(x, np.array(naive.BASELINE), True)
    assert np.ptp(fixed[:, 5::6][:, :4], axis=0).max() == 0.0
    assert np.ptp(rows[:, 5::6][:, :4], axis=0).min() > 1e-3


def test_every_sample_is_free_of_load_in_its_load_free_pose():
    motion = trajectory(knees(1, seed=5)[0])
    np.testing.assert_allclose(motion.tension[:, 0], 0.0, atol=1e-15)
    np.testing.assert_allclose(motion.contact_force[:, 0], 0.0, atol=1e-9)
    assert np.degrees(motion.flexion[0, 0]) == pytest.approx(54.79)


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_change_no_bit(threads):
    x = knees(150, seed=2)
    assert_same_bytes(simulate_batch(x, threads=threads), simulate_batch(x, threads=1))


@pytest.mark.parametrize("split", [1, 7, 16, 33])
def test_batch_size_and_lane_change_no_bit(split):
    x = knees(40, seed=4)
    whole = simulate_batch(x)
    parts = [simulate_batch(x[k : k + split]) for k in range(0, len(x), split)]
    for field in (*FIELDS, "settled", "refinements"):
        joined = np.concatenate([getattr(p, field) for p in parts])
        assert joined.tobytes() == np.ascontiguousarray(getattr(whole, field)).tobytes(), field


def test_a_neighbour_that_blows_up_changes_no_bit():
    x = knees(8, seed=6)
    alone = simulate_batch(x)
    wild = x.copy()
    wild[3, 22:26] *= 1e4
    beside = simulate_batch(wild)
    assert beside.status[3] == "failed"
    keep = [0, 1, 2, 4, 5, 6, 7]
    assert beside.flexion[keep].tobytes() == alone.flexion[keep].tobytes()


def test_a_stiff_model_is_refined_and_says_so():
    x = ParameterSpace().baseline.copy()
    x[22:26] *= 1.6
    x[26] *= 1.6
    response = simulate(x)
    slow = naive.simulate(x)
    assert response.status == slow["status"] == "refined"
    assert response.refinements == slow["n_refinements"] >= 1
    np.testing.assert_allclose(response.flexion, slow["flexion"], atol=1e-9)


def test_a_model_that_fails_is_marked_and_holds_no_numbers():
    x = ParameterSpace().baseline.copy()
    x[22:26] *= 1e5
    batch = simulate_batch([x, ParameterSpace().baseline])
    assert batch.status == ("failed", "ok")
    assert batch.n_failed == 1
    for field in FIELDS:
        assert np.isnan(getattr(batch, field)[0]).all(), field
        assert np.isfinite(getattr(batch, field)[1]).all(), field
    assert not batch.settled[0].any()
    with pytest.raises(ModelError, match="fails"):
        trajectory(x)


def test_unsettled_models_are_kept_and_counted():
    batch = simulate_batch(knees(60, seed=0))
    assert batch.n_failed == 0
    assert 0 < batch.n_unsettled < 60
    unsettled = np.flatnonzero(~batch.settled.all(axis=1))
    assert np.isfinite(batch.flexion[unsettled]).all()
    # Only small moments are too weak to bring a lax knee to rest in time.
    assert np.abs(MOMENT[np.flatnonzero(~batch.settled.all(axis=0))]).max() < 2.0


def test_trajectory_ends_where_the_response_is_read():
    x = knees(1, seed=9)[0]
    response, motion = simulate(x), trajectory(x)
    assert motion.time[-1] == pytest.approx(23.0)
    ends = np.searchsorted(motion.time, np.array([7.0, 11, 14, 17, 20, 23]) - 1e-9)
    for direction in (0, 1):
        part = slice(6 * direction, 6 * direction + 6)
        np.testing.assert_array_equal(motion.flexion[direction, ends], response.flexion[part])
        np.testing.assert_array_equal(motion.tension[direction, ends], response.tension[part])
        np.testing.assert_array_equal(motion.moment[direction, ends], response.moment[part])


def test_trajectory_frames_may_be_finer_or_coarser():
    x = ParameterSpace().baseline
    fine, coarse = trajectory(x, frame_steps=5), trajectory(x, frame_steps=50)
    np.testing.assert_array_equal(fine.flexion[:, ::10], coarse.flexion)
    with pytest.raises(ParameterError, match="`frame_steps` is 3"):
        trajectory(x, frame_steps=3)


def test_sine_and_cosine():
    psi = np.linspace(-dynamics.TURN_LIMIT, dynamics.TURN_LIMIT, 20001)
    s, c = np.array([forces.sin_cos(p) for p in psi]).T
    error = np.maximum(np.abs(s - np.sin(psi)), np.abs(c - np.cos(psi)))
    assert error.max() < 6e-15
    assert error[np.abs(psi) < math.radians(120.0)].max() < 1e-15


def test_nan_is_not_optimised_away():
    rows = prepare(knees(1), None, "recomputed")
    rows[0, 4] = np.nan
    poses, _, refinements = dynamics.respond(rows)
    assert refinements[0] == -1
    assert np.isnan(poses).all()


@pytest.mark.parametrize(
    ("x", "said"),
    [
        (np.zeros(27), r"`x` has shape \(27,\)"),
        (np.zeros((2, 2, 28)), "has shape"),
        (np.full(28, np.nan), "`acl_femur_x` is nan mm"),
        (["a"] * 28, "not an array of numbers"),
        (np.zeros(28), "`condyle_radius` is 0 mm; a value above 0"),
    ],
)
def test_what_is_not_allowed_is_named(x, said):
    with pytest.raises(ParameterError, match=said):
        simulate(x)


def test_a_wrong_row_of_a_batch_is_named():
    x = knees(3)
    x[2, 27] = 0.5
    with pytest.raises(ParameterError, match=r"`X`\[2\]: `poissons_ratio` is 0.5"):
        simulate_batch(x)


@pytest.mark.parametrize("name", ["rest_length", "threads", "baseline"])
def test_wrong_options_are_named(name):
    wrong = {"rest_length": "short", "threads": 0, "baseline": np.zeros((2, 28))}
    with pytest.raises(ParameterError, match=name):
        simulate_batch(knees(1), **{name: wrong[name]})


def test_the_function_survives_an_import_of_its_command():
    with pytest.raises(ImportError, match="`from kneecore import simulate` works"):
        importlib.import_module("kneecore.simulate")
    assert kneecore.simulate(ParameterSpace().baseline).status == "ok"


def test_a_response_prints_as_a_table():
    text = str(simulate(ParameterSpace().baseline))
    assert "-3.72" in text
    assert "118.99" in text
    assert "238.0" in text  # nothing is cut to fit
    assert "…" not in text


def test_a_forked_child_can_simulate():
    import multiprocessing

    x = knees(40)
    simulate_batch(x, threads=2)
    context = multiprocessing.get_context("fork")
    queue = context.SimpleQueue()
    child = context.Process(target=lambda: queue.put(simulate_batch(x, threads=2).flexion.sum()))
    child.start()
    child.join(20)
    alive = child.is_alive()
    child.kill()
    assert not alive
    assert queue.get() == simulate_batch(x).flexion.sum()

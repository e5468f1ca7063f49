"""The two marks beside `settled`, on knees whose answer is known both ways."""

import json

import naive
import numpy as np
import pytest
from scipy.optimize import minimize

from kneecore import Knee, ParameterSpace, simulate, simulate_batch
from kneecore.files.response import read_response, response_table
from kneecore.knee.physics.equilibrium import equilibria
from kneecore.knee.physics.marks import AT_REST_ANGLE, at_rest, implausible
from kneecore.knee.response import MOMENT, prepare
from kneecore.report.marks import counted, legend, mark

BASELINE = ParameterSpace().baseline


def wide(times):
    return ParameterSpace(
        geometry_bound_mm=times, slope_bound_deg=times, material_bound_percent=min(10 * times, 90)
    )


def drawn(times, n, seed=0):
    space = wide(times)
    return space.from_unit(np.random.default_rng(seed).random((n, len(space.lower))))


def test_the_baseline_is_settled_everywhere_but_not_at_rest_under_the_smallest_loads():
    knee = simulate(BASELINE)
    assert knee.settled.all()
    # MODEL.md: 0.18 and 0.35 deg at +-0.1 N m, 0.11 at -0.2, under 0.1 elsewhere.
    assert MOMENT[~knee.at_rest].tolist() == [0.1, -0.1, -0.2]
    rest = simulate(BASELINE, solver="equilibrium")
    away = np.degrees(np.abs(knee.flexion - rest.flexion))
    assert away[[0, 6]].round(2).tolist() == [0.18, 0.35]
    assert rest.at_rest.all()
    assert not knee.implausible.any()
    assert (knee.n_not_at_rest, knee.n_implausible) == (3, 0)


@pytest.mark.parametrize("seed", [None, 0, 1])
def test_the_mark_agrees_with_the_minimum_of_the_naive_potential(seed):
    """The naive energy knows no kernel: it is followed downhill from where the motion ends."""
    x = BASELINE if seed is None else drawn(1.0, 1, seed)[0]
    knee, rest = simulate(x), naive.rest_lengths(x)
    scale = np.array([1e-4, 1e-4, 1e-3])
    for k in (0, 1, 5, 6, 7, 11):
        start = np.array([*knee.tibia_position[k], -knee.flexion[k]])

        def energy(step, start=start, k=k):
            return 1e3 * naive.potential(x, start + scale * step, float(MOMENT[k]), rest)

        found = minimize(
            energy, np.zeros(3), method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-10}
        )
        away = abs(scale[2] * found.x[2])
        assert abs(away / AT_REST_ANGLE - 1.0) > 0.02  # not a knee that could be judged either way
        assert knee.at_rest[k] == (away <= AT_REST_ANGLE)


@pytest.mark.parametrize(("share", "expected"), [(0.99, True), (1.01, False), (-1.01, False)])
def test_the_mark_turns_at_a_tenth_of_a_degree(share, expected):
    rows = prepare(BASELINE, None, "recomputed")
    poses, _ = equilibria(rows)
    poses[:, 3, 2] += share * AT_REST_ANGLE
    marks = at_rest(rows, poses)[0]
    assert marks[3] == expected
    assert np.delete(marks, 3).all()


def test_the_equilibrium_below_the_motions_end_is_the_one_that_is_followed():
    """Two solvers: one goes downhill from the end, the other follows the loads from the start."""
    x = drawn(1.0, 500)
    rows = prepare(x, None, "recomputed")
    moved = simulate_batch(x)
    poses, _ = equilibria(rows)
    away = np.abs(naive.THETA_0 - poses[..., 2] - moved.flexion)
    assert (np.abs(away / AT_REST_ANGLE - 1.0) > 1e-5).all()  # none could be judged either way
    assert (moved.at_rest == (away <= AT_REST_ANGLE)).all()
    assert 0.05 < np.mean(~moved.at_rest) < 0.2


def test_a_knee_that_has_lost_its_equilibrium_may_be_at_rest_in_another():
    x = drawn(6.0, 300)
    batch = simulate_batch(x, solver="equilibrium")
    lost = ~np.isnan(batch.lost_at)
    assert batch.at_rest[~lost].all()
    assert batch.at_rest[lost].any()
    assert not batch.at_rest[lost].all()


@pytest.mark.parametrize(
    ("theta", "share", "expected"),
    [
        (-59.9, 0.0, False),
        (-60.1, 0.0, True),
        (169.9, 0.49, False),
        (170.1, 0.0, True),
        (20.0, 0.49, False),
        (20.0, 0.51, True),
        (np.nan, np.nan, False),
    ],
)
def test_what_no_knee_does_is_implausible(theta, share, expected):
    rows = prepare(BASELINE, None, "recomputed")
    poses = np.zeros((1, 12, 3))
    depth = np.zeros((1, 12))
    poses[0, 7, 2] = naive.THETA_0 - np.radians(theta)
    depth[0, 7] = share * BASELINE[18]
    marks = implausible(rows, poses, depth)[0]
    assert marks[7] == expected
    assert not np.delete(marks, 7).any()


def test_the_marks_say_what_the_numbers_say_at_ten_times_the_bounds():
    x = drawn(10.0, 200)
    batch = simulate_batch(x)
    theta = np.degrees(batch.flexion)
    odd = (theta < -60) | (theta > 170) | (batch.indentation > 0.5 * x[:, 18, None])
    assert (batch.implausible == odd).all()
    assert 0 < batch.n_implausible < 200
    assert not batch.at_rest[batch.failed].any()
    assert not simulate_batch(drawn(1.0, 200)).implausible.any()


def test_samples_are_counted_by_the_marks():
    x = drawn(10.0, 200)
    knee = Knee(wide(10.0))
    counts = knee.examine(x, observe=True).counts
    batch = simulate_batch(x)
    lost = batch.failed
    assert counts["implausible"] == batch.implausible[~lost].any(axis=1).sum() > 0
    assert counts["not_at_rest"] == (~batch.at_rest[~lost]).any(axis=1).sum() > 0
    assert "implausible" in counted(counts)[-1]


def test_files_keep_the_marks_and_older_files_have_none():
    knee = simulate(BASELINE)
    table = json.loads(json.dumps(response_table(knee)))
    back = read_response(table)
    assert (back.at_rest == knee.at_rest).all()
    assert (back.implausible == knee.implausible).all()
    for key in ("at_rest", "implausible"):
        del table[key]
    old = read_response(table)
    assert old.at_rest is old.implausible is None
    assert (old.n_not_at_rest, old.n_implausible) == (0, 0)
    assert legend([old]) == []
    assert "at_rest" not in response_table(old)


def test_signs_stand_behind_the_angles_and_are_explained():
    knee = simulate(BASELINE)
    assert [mark(knee, k) for k in (0, 5, 6, 11)] == ["~", "", "~", ""]
    assert [line[:2] for line in legend([knee])] == ["~ "]
    assert "~ not at rest" in str(knee)

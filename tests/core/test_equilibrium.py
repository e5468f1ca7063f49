"""Direct equilibria: as settled dynamics, as SciPy's minima, on the load path, or marked."""

import math

import naive
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from kneecore import MOMENT, NAMES, ParameterError, ParameterSpace, simulate, simulate_batch
from kneecore.knee.physics import dynamics
from kneecore.knee.physics.equilibrium import equilibria
from kneecore.knee.physics.load_path import rises, trace
from kneecore.knee.physics.newton_walk import walk
from kneecore.knee.physics.potential import about_origin
from kneecore.knee.response import prepare

MOMENTS = np.array(dynamics.MOMENTS)
BASELINE = ParameterSpace().baseline


def knees(n, seed=0, bound=1.0, percent=10.0):
    space = ParameterSpace(
        geometry_bound_mm=bound, slope_bound_deg=bound, material_bound_percent=percent
    )
    return space.from_unit(np.random.default_rng(seed).random((n, 28)))


def rows_of(n, seed=0, bound=1.0, percent=10.0, rest_length="recomputed"):
    return prepare(knees(n, seed, bound, percent), None, rest_length)


def cut(ligament):
    x = BASELINE.copy()
    x[NAMES.index(f"{ligament}_stiffness")] = 0.0
    return x


def settled_turns(rows, longer=40):
    """Turns (n, 12) after plateaus `longer` times as long, NaN where the dynamics fails."""
    steps = np.array(dynamics.PLATEAU_STEPS) * longer
    runs = np.arange(2 * len(rows))
    turns = np.full((len(runs), 6), np.nan)
    for refinements in range(4):
        states, farthest = dynamics.integrate(rows, runs, steps, MOMENTS, refinements=refinements)
        with np.errstate(invalid="ignore", over="ignore"):
            calm = (dynamics.kinetic_energy(states) < dynamics.KINETIC_LIMIT).all(axis=1)
            good = np.isfinite(states).all(axis=(1, 2)) & calm & (farthest < dynamics.TURN_LIMIT)
        turns[runs[good]] = states[good, :, 2]
        runs = runs[~good]
        if len(runs) == 0:
            break
    return turns.reshape(-1, 12)


@pytest.mark.parametrize("rest_length", ["recomputed", "fixed"])
def test_within_a_thousandth_of_a_degree_of_settled_dynamics(rest_length):
    rows = rows_of(128, 1, rest_length=rest_length)
    poses, lost_at = equilibria(rows)
    assert np.isnan(lost_at).all()
    off = np.degrees(np.abs(poses[:, :, 2] - settled_turns(rows)))
    assert off.max() < 1e-3


def test_no_unmarked_failure_in_wide_bounds():
    rows = rows_of(300, 2, bound=3.0, percent=30.0)
    poses, lost_at = equilibria(rows)
    kept = np.isnan(lost_at)
    assert 0 < np.count_nonzero(~kept) < 15
    assert np.isnan(poses[~kept]).all()
    assert np.isfinite(poses[kept]).all()
    # A knee that creeps past a fold may need longer than any dynamics is run for: all loads of
    # most knees, and most loads of all, agree to a thousandth of a degree.
    off = np.degrees(np.abs(poses[kept, :, 2] - settled_turns(rows[kept])))
    assert (off.max(axis=1) < 1e-3).mean() > 0.98
    assert np.median(off, axis=1).max() < 1e-3


def test_marked_knees_are_those_that_a_trace_shows_to_be_lost():
    """Both solvers of the load path, the fast one and the slow one, on knees that snap."""
    rows = rows_of(120, 3, bound=10.0, percent=90.0)
    lost_at = equilibria(rows)[1]
    moved, pose = about_origin(rows), np.empty((6, 3))
    for i, row in enumerate(moved):
        places = [trace(row, sign, MOMENTS, 0, pose) for sign in (1.0, -1.0)]
        sizes = [MOMENTS[k] for k in places if k >= 0]
        if sizes:
            assert abs(lost_at[i]) == min(sizes)
        else:
            assert math.isnan(lost_at[i])
    assert 10 < np.count_nonzero(~np.isnan(lost_at)) < 100


def test_a_snap_that_only_the_iterations_betray_is_marked():
    rows = rows_of(1500, 5, bound=10.0, percent=90.0)[528:529]
    assert trace(about_origin(rows)[0], -1.0, MOMENTS, 0, np.empty((6, 3))) == 5
    assert equilibria(rows)[1][0] == -5.0


@pytest.mark.parametrize("knee", [1071, 1414, 1446])
def test_strained_knees_come_to_the_nearest_equilibrium(knee):
    """Far out of equilibrium at the start, with other equilibria beyond the nearest."""
    rows = rows_of(1500, 22, bound=5.0, percent=50.0, rest_length="fixed")[knee : knee + 1]
    poses, lost_at = equilibria(rows)
    traced = np.empty((6, 3))
    place = trace(about_origin(rows)[0], -1.0, MOMENTS, 0, traced)
    if place < 0:
        np.testing.assert_allclose(poses[0, 6:, 2], traced[:, 2], rtol=0, atol=1e-8)
    else:
        assert lost_at[0] == -MOMENTS[place]
    newton, doubt = np.empty((1, 6, 3)), np.empty((1, 6), dtype=bool)
    walk(about_origin(rows), np.array([1]), MOMENTS, newton, doubt)
    assert doubt[0, 0]
    assert abs(newton[0, 0, 2] - traced[0, 2]) > 0.1


def test_walk_and_trace_find_the_same_equilibria():
    rows = about_origin(rows_of(40, 4, bound=2.0))
    poses, doubt = np.empty((80, 6, 3)), np.empty((80, 6), dtype=bool)
    walk(rows, np.arange(80), MOMENTS, poses, doubt)
    traced = np.empty((6, 3))
    for run in range(80):
        assert trace(rows[run // 2], 1.0 - 2.0 * (run % 2), MOMENTS, 0, traced) == -1
        np.testing.assert_allclose(poses[run], traced, rtol=0, atol=1e-9)


def test_a_snap_is_seen_between_two_equilibria():
    """Two equilibria with a dip of the moment between them are not one branch."""
    rows = rows_of(3000, 2, bound=3.0, percent=30.0)[349:350]  # turns from 32 to 80 deg at 0.4 N m
    moved = about_origin(rows)
    poses, doubt = np.empty((1, 6, 3)), np.empty((1, 6), dtype=bool)
    walk(moved, np.array([0]), MOMENTS, poses, doubt)
    jump = int(np.argmax(np.diff(poses[0, :, 2])))
    assert doubt[0, jump + 1]
    seen = [rises(moved[0], 1.0, poses[0, k], poses[0, k + 1]) for k in range(5)]
    assert seen == [k != jump for k in range(5)]
    assert equilibria(rows)[1][0] == MOMENTS[jump + 1]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("rest_length", ["recomputed", "fixed"])
def test_equilibria_are_minima_of_the_naive_potential(seed, rest_length):
    x = knees(1, 10 + seed)[0]
    response = simulate(x, rest_length=rest_length, solver="equilibrium")
    assert math.isnan(response.lost_at)
    rest = naive.rest_lengths(x, mode=rest_length)
    scale = np.array([1e-3, 1e-3, 1e-2])
    for k in range(0, 12, 2):
        pose = np.array([*response.tibia_position[k], -response.flexion[k]])

        def energy(step, pose=pose, k=k):
            return naive.potential(x, pose + scale * step, MOMENT[k], rest)

        best = minimize(energy, np.full(3, 0.3), method="Nelder-Mead",
                        options={"xatol": 1e-6, "fatol": 1e-16, "maxiter": 2000})  # fmt: skip
        np.testing.assert_allclose(best.x * scale, 0.0, atol=2e-6)
        assert energy(np.zeros(3)) <= best.fun + 1e-13


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.lists(st.floats(0.0, 1.0), min_size=28, max_size=28), st.floats(0.1, 3.0))
def test_energy_less_work_never_rises_over_a_load(unit, bound):
    space = ParameterSpace(geometry_bound_mm=bound, material_bound_percent=10.0 * bound)
    x = space.from_unit(unit)
    response = simulate(x, solver="equilibrium")
    if not math.isnan(response.lost_at):
        return
    rest = naive.rest_lengths(x)
    origin, phi = naive.load_free_pose(x)
    for direction in (slice(0, 6), slice(6, 12)):
        pose = np.array([*origin, phi])
        for k in range(12)[direction]:
            before = naive.potential(x, pose, MOMENT[k], rest)
            pose = np.array([*response.tibia_position[k], -response.flexion[k]])
            assert naive.potential(x, pose, MOMENT[k], rest) < before


def test_bits_do_not_depend_on_threads_batches_or_neighbours():
    rows = rows_of(300, 5, bound=3.0, percent=30.0)
    poses, lost_at = equilibria(rows, threads=1)
    again = equilibria(rows, threads=2)
    assert poses.tobytes() == again[0].tobytes()
    assert lost_at.tobytes() == again[1].tobytes()
    for part in (slice(0, 1), slice(7, 40), slice(41, 300)):
        assert equilibria(rows[part])[0].tobytes() == poses[part].tobytes()
    shuffled = np.random.default_rng(0).permutation(300)
    assert equilibria(rows[shuffled])[0].tobytes() == poses[shuffled].tobytes()


def test_the_response_is_the_same_object_as_the_dynamics():
    dynamic, static = simulate(BASELINE), simulate(BASELINE, solver="equilibrium")
    assert static.status == "ok"
    assert static.settled.all()
    # What the transient has left at the baseline, by load (deg).
    off = np.degrees(np.abs(dynamic.flexion - static.flexion))
    assert off[[0, 6]] == pytest.approx([0.18, 0.35], abs=0.01)
    assert off[[2, 3, 4, 5, 8, 9, 10, 11]].max() < 0.025
    # The contact ripples in the dynamics by a few newtons, at rest not at all: forces balance.
    np.testing.assert_allclose(static.contact_force, dynamic.contact_force, atol=1.5)
    np.testing.assert_array_equal(static.rest_length, dynamic.rest_length)


def test_unsettled_knees_are_shown_at_rest():
    X = knees(64, 6)
    dynamic, static = simulate_batch(X), simulate_batch(X, solver="equilibrium")
    assert dynamic.n_unsettled > 0
    assert static.n_unsettled == static.n_failed == static.n_lost == 0
    off = np.degrees(np.abs(dynamic.flexion - static.flexion))
    assert off[~dynamic.settled].min() > off[:, 5].max()


@pytest.mark.parametrize("ligament", ["acl", "mcl", "lcl"])
def test_a_knee_may_live_without_one_ligament(ligament):
    response = simulate(cut(ligament), solver="equilibrium")
    assert response.status == "ok"
    assert math.isnan(response.lost_at)


def test_a_cut_ligament_that_lets_the_knee_go_is_reported_with_its_load():
    response = simulate(cut("pcl"), solver="equilibrium")
    assert response.lost_at == -2.0
    assert response.status == "failed"
    assert np.isnan(response.flexion).all()
    assert "No equilibrium could be followed to -2 N m" in str(response)


def test_a_lost_knee_that_lives_gets_the_dynamics_response():
    x = knees(3000, 2, bound=3.0, percent=30.0)[349]
    dynamic, static = simulate(x), simulate(x, solver="equilibrium")
    assert static.lost_at == 0.4
    assert static.status == "ok"
    assert static.flexion.tobytes() == dynamic.flexion.tobytes()
    assert static.settled.tobytes() == dynamic.settled.tobytes()


def test_a_knee_without_ligaments_is_lost_at_once():
    x = BASELINE.copy()
    x[22:26] = 0.0
    assert simulate(x, solver="equilibrium").lost_at == 0.1


def test_unknown_solver_is_refused():
    with pytest.raises(ParameterError, match="`solver` is 'newton'; 'dynamics' or 'equilibrium'"):
        simulate(BASELINE, solver="newton")

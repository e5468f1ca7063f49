"""Rest lengths as four more uncertain parameters."""

import naive
import numpy as np
import pytest
from results import check_comes_back
from searches import searched

from kneecore import (
    NAMES,
    InfluenceSettings,
    Knee,
    ParameterError,
    ParameterSpace,
    SamplingSettings,
    SearchResult,
    dump_knee,
    flexion_gradient,
    influence,
    monte_carlo,
    simulate,
    simulate_batch,
    trajectory,
)
from kneecore.errors import FileFormatError
from kneecore.figures.style import REST_DEG, through_rest
from kneecore.knee.file import parse_knee
from kneecore.knee.parameters import REST_LENGTH_NAMES
from kneecore.report.command import command_line

SPACE = ParameterSpace(rest_length_bound_mm=1.0)
MODES = ("recomputed", "fixed")


def knees(n, seed=0, space=SPACE):
    return space.from_unit(np.random.default_rng(seed).random((n, 32)))


@pytest.mark.parametrize("rest_length", MODES)
def test_equal_to_the_naive_model(rest_length):
    for x in knees(2, 1):
        ours = simulate(x, rest_length=rest_length)
        twin = naive.simulate(x, rest_length=rest_length)
        assert ours.status == twin["status"]
        np.testing.assert_allclose(ours.flexion, twin["flexion"], atol=1e-10)
        np.testing.assert_allclose(ours.tension, twin["tension"], atol=1e-4)
        np.testing.assert_allclose(
            ours.rest_length, naive.rest_lengths(x, mode=rest_length), rtol=1e-13
        )


@pytest.mark.parametrize("solver", ["dynamics", "equilibrium"])
def test_no_change_changes_no_bit(solver):
    X = knees(20, 2)
    X[:, 28:] = 0.0
    with_entries = simulate_batch(X, solver=solver)
    without = simulate_batch(X[:, :28], solver=solver)
    assert with_entries.flexion.tobytes() == without.flexion.tobytes()
    assert with_entries.rest_length.tobytes() == without.rest_length.tobytes()


def test_a_change_is_added_to_the_rest_length():
    x = np.append(SPACE.baseline[:28], [1e-3, -1e-3, 2e-3, 0.0])
    added = simulate(x).rest_length - simulate(x[:28]).rest_length
    np.testing.assert_allclose(added, x[28:], atol=1e-15)


def test_longer_cruciates_let_the_knee_extend_further_and_shorter_ones_less():
    at = [np.append(SPACE.baseline[:28], [c, c, 0.0, 0.0]) for c in (1e-3, 0.0, -1e-3)]
    longer, same, shorter = (simulate(x, solver="equilibrium").flexion[5] for x in at)
    assert longer < same < shorter


@pytest.mark.parametrize("rest_length", MODES)
def test_gradient_equals_central_differences(rest_length):
    width = SPACE.upper - SPACE.lower
    h = 1e-4 * width
    shifts = np.array([1.0, -1.0, 2.0, -2.0])
    for x in knees(4, 3):
        X = x + (shifts[:, None, None] * np.diag(h)).reshape(-1, 32)
        f = simulate_batch(X, rest_length=rest_length, solver="equilibrium").flexion
        f = f.reshape(4, 32, 12)
        differences = ((8.0 * (f[0] - f[1]) - (f[2] - f[3])) / (12.0 * h[:, None])).T
        exact = flexion_gradient(x, rest_length=rest_length)
        assert exact.shape == (12, 32)
        largest = (np.abs(exact) * width).max(axis=1, keepdims=True)
        assert (np.abs(exact - differences) * width / largest).max() < 1e-6


def test_off_by_default():
    assert ParameterSpace().names == NAMES
    assert ParameterSpace(rest_length_bound_mm=0.0).n_free == 28


@pytest.mark.parametrize(("case", "free"), [("both", 32), ("geometry", 26), ("material", 10)])
def test_they_vary_in_every_case(case, free):
    space = ParameterSpace(case=case, rest_length_bound_mm=0.5)
    assert space.n_free == free
    assert space.names == NAMES + REST_LENGTH_NAMES
    np.testing.assert_allclose(space.upper[28:], 0.5e-3)
    np.testing.assert_allclose(space.lower[28:], -0.5e-3)


def test_per_cent_of_the_baselines_rest_lengths():
    space = ParameterSpace(rest_length_bound_percent=2.0)
    lengths = simulate(space.baseline).rest_length
    np.testing.assert_allclose(space.upper[28:], 0.02 * lengths, rtol=1e-12)
    np.testing.assert_allclose(lengths, [33.947e-3, 25.973e-3, 94.705e-3, 46.178e-3], atol=1e-6)


def test_half_ranges_by_name():
    space = ParameterSpace(half_ranges={"acl_rest_length_change": 1e-3})
    assert space.n_free == 29
    assert space.free[28]
    assert not space.free[29:].any()


def test_a_knee_without_them_has_unchanged_ones():
    unit = SPACE.to_unit(SPACE.baseline[:28])
    np.testing.assert_allclose(unit[28:], 0.5)
    x = knees(1, 4)[0]
    with pytest.raises(ParameterError, match="no rest lengths"):
        ParameterSpace().to_unit(x)


def test_refused():
    with pytest.raises(ParameterError, match="one of the two is allowed"):
        ParameterSpace(rest_length_bound_mm=1.0, rest_length_bound_percent=1.0)
    with pytest.raises(ParameterError, match="`rest_length_bound_mm` is -1 mm"):
        ParameterSpace(rest_length_bound_mm=-1.0)
    x = np.append(SPACE.baseline[:28], [0.0, -0.03, 0.0, 0.0])
    with pytest.raises(
        ParameterError, match=r"`pcl_rest_length_change` is -30 mm; more than -25\."
    ):
        simulate(x)
    with pytest.raises(ParameterError, match=r"bounds are too wide.*pcl_rest_length_change"):
        ParameterSpace(rest_length_bound_mm=30.0)


def test_knee_files_hold_them():
    x = knees(1, 5)[0]
    text = dump_knee(baseline=SPACE.baseline, half_ranges=SPACE.upper - SPACE.baseline, current=x)
    knee = parse_knee(text)
    assert knee.current.tobytes() == x.tobytes()
    assert knee.baseline.shape == knee.half_ranges.shape == (32,)
    with_change = dump_knee(baseline=SPACE.baseline[:28], half_ranges=np.zeros(28), current=x)
    assert parse_knee(with_change).current.tobytes() == x.tobytes()
    with pytest.raises(FileFormatError, match="unknown key 'mcl_rest'"):
        parse_knee(text + "\n[parameters.mcl_rest]\nvalue = 0\nunit = 'mm'\n")


def test_a_knee_files_half_ranges_are_the_spaces(tmp_path):
    path = tmp_path / "knee.toml"
    path.write_text(SPACE.to_toml())
    space = ParameterSpace.from_file(path)
    np.testing.assert_allclose(space.upper, SPACE.upper, rtol=1e-12)
    wider = ParameterSpace.from_file(path, rest_length_bound_mm=2.0)
    np.testing.assert_allclose(wider.upper[28:], 2e-3)
    off = ParameterSpace.from_file(path, rest_length_bound_mm=0.0)
    assert off.n_free == 28


@pytest.mark.parametrize(
    "settings",
    [
        {"search_space": "model", "pop_size": 20, "n_generations": 10},
        {"pop_size": 20, "n_generations": 10},
        {"method": "exact"},
    ],
)
def test_a_search_uses_them_and_its_result_survives_a_file(settings):
    found = searched(SPACE, solver="equilibrium", **settings)
    assert found.x.shape == (2, 32)
    assert np.abs(found.x[:, 28:]).max() <= 1e-3
    check_comes_back(found)
    assert SearchResult.from_json(found.to_json()).model.n_free == 32
    assert "--rest-length-bound-mm 1.0" in command_line(found)
    assert "acl_rest_length_change" in str(found)


def test_the_exact_worst_case_is_worse_with_them():
    without = searched(ParameterSpace(), method="exact", solver="equilibrium")
    with_them = searched(SPACE, method="exact", solver="equilibrium")
    assert with_them.objective_model > without.objective_model


def test_sampling_and_influence_use_them():
    few = SamplingSettings(n_samples=512)
    wide, narrow = (monte_carlo(knee, few).y.sd[5] for knee in (Knee(SPACE), Knee()))
    assert wide > narrow
    found = influence(Knee(SPACE), InfluenceSettings(n_base=64, intervals=False))
    assert found.names[28:] == REST_LENGTH_NAMES
    assert set(found.groups) == {"acl", "pcl", "mcl", "lcl", "condyle", "plateau", "material"}


def test_the_motion_starts_with_the_changed_ligament_taut():
    x = np.append(SPACE.baseline[:28], [-1e-3, 0.0, 0.0, 0.0])
    start = trajectory(x).tension[:, 0]
    np.testing.assert_allclose(start[:, 0], x[22] * 1e-6, rtol=1e-9)
    assert (start[:, 1:] == 0.0).all()


def test_figures_put_no_load_free_pose_where_knees_are_under_load():
    assert through_rest(Knee()) == REST_DEG
    assert through_rest(Knee(rest_length="fixed")) is None
    assert through_rest(Knee(SPACE)) is None
    for space, n in ((ParameterSpace(), 13), (SPACE, 12)):
        found = monte_carlo(Knee(space), SamplingSettings(n_samples=64))
        axes = found.figures()["figure_band"].axes[0]
        assert all(len(line.get_xdata()) in (n, 2) for line in axes.lines)
        assert any(len(line.get_xdata()) == n for line in axes.lines)

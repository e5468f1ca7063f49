"""Sweeps over training sizes and over the geometry's bound, and the needed accuracy."""

import json

import numpy as np
import pytest
from commands import called
from scipy.stats import spearmanr

import kneecore
from kneecore import (
    Cancelled,
    ParameterError,
    ParameterSpace,
    bound_sweep,
    needed_accuracy,
    simulate_batch,
    training_sweep,
    worst_case,
)
from kneecore.cli.sweep import main
from kneecore.numerics.sampling import uniform
from kneecore.numerics.surrogate import Surrogate
from kneecore.study.bound_sweep import with_geometry_bound
from kneecore.study.training_sweep import ranking

REST = {"solver": "equilibrium"}


@pytest.fixture(scope="module")
def bounds():
    return bound_sweep(bounds_mm=(0.25, 0.5, 1.0), **REST)


@pytest.fixture(scope="module")
def need():
    return needed_accuracy(**REST)


class TestBounds:
    def test_each_is_the_exact_worst_case_of_its_space(self, bounds):
        space = ParameterSpace(geometry_bound_mm=0.5, slope_bound_deg=0.5)
        worst = worst_case(space, method="exact", **REST)
        assert bounds.objective[1] == worst.objective_model
        one, two = (np.degrees(m.flexion[5]) for m in (worst.model_1, worst.model_2))
        assert bounds.over_extension_deg[1] == pytest.approx(-one, abs=1e-9)
        assert bounds.extension_deficit_deg[1] == pytest.approx(max(two, 0.0), abs=1e-9)

    def test_a_wider_box_holds_worse_knees(self, bounds):
        assert (np.diff(bounds.objective) > 0.0).all()
        assert (np.diff(bounds.extremes_deg[:, 0]) < 0.0).all()
        assert (np.diff(bounds.extremes_deg[:, 1]) > 0.0).all()

    def test_no_sampled_knee_lies_beyond_the_extremes(self, bounds):
        for k, bound in enumerate(bounds.bound_mm):
            space = ParameterSpace(geometry_bound_mm=bound, slope_bound_deg=bound)
            sample = simulate_batch(space.from_unit(uniform(3000, 28, 7)), **REST)
            angles = np.degrees(sample.flexion[:, 5])
            assert bounds.extremes_deg[k, 0] <= angles.min()
            assert angles.max() <= bounds.extremes_deg[k, 1]

    def test_both_ways_of_responding(self):
        moving = bound_sweep(bounds_mm=[0.5], solver="dynamics")
        resting = bound_sweep(bounds_mm=[0.5], **REST)
        # At 5 N m a knee has come to rest.
        np.testing.assert_allclose(moving.extremes_deg, resting.extremes_deg, atol=0.1)
        assert moving.objective[0] < resting.objective[0]

    def test_only_the_geometrys_bounds_change(self):
        half = {"acl_femur_x": 3e-3, "acl_stiffness": 1e6}
        space = ParameterSpace(slope_bound_deg=2.0, half_ranges=half)
        other = with_geometry_bound(space, 0.5)
        names = space.names
        at = {n: (other.upper - other.lower)[names.index(n)] / 2.0 for n in names}
        assert at["acl_femur_x"] == pytest.approx(0.5e-3)
        assert at["plateau_slope"] == pytest.approx(np.radians(1.0))
        assert at["acl_stiffness"] == pytest.approx(1e6)
        assert at["pcl_stiffness"] == pytest.approx(3e6)

    def test_cancelled(self):
        with pytest.raises(Cancelled):
            bound_sweep(bounds_mm=(0.5, 1.0), callback=lambda report: report.done == 1, **REST)


class TestNeededAccuracy:
    def test_the_answer_is_bracketed_from_both_sides(self, need):
        assert need.beyond_mm - need.bound_mm <= 0.005
        assert need.largest_angle_deg <= 5.0 < need.beyond_deg
        for bound, angle in (
            (need.bound_mm, need.largest_angle_deg),
            (need.beyond_mm, need.beyond_deg),
        ):
            (largest,) = bound_sweep(bounds_mm=[bound], **REST).extremes_deg[:, 1]
            assert largest == pytest.approx(angle, abs=1e-6)

    def test_no_random_knee_contradicts_it(self, need):
        assert need.sampled_deg <= need.largest_angle_deg

    def test_a_stricter_demand_needs_more_accuracy(self, need):
        strict = needed_accuracy(within_deg=2.0, **REST)
        assert strict.bound_mm < need.bound_mm

    def test_when_even_exact_geometry_is_not_enough(self):
        never = needed_accuracy(within_deg=-3.8, **REST)
        assert never.bound_mm is None
        assert never.answer().startswith("Not every knee extends to within -3.8 deg")
        assert never.largest_angle_deg > -3.8

    def test_when_the_widest_bound_is_enough(self):
        easy = needed_accuracy(within_deg=30.0, largest_mm=1.0, **REST)
        assert (easy.bound_mm, easy.reaches_largest) == (1.0, True)
        assert "the widest bound that was looked at" in easy.answer()
        assert easy.beyond_mm is None


class TestTraining:
    def test_ranking_is_spearmans(self):
        rng = np.random.default_rng(0)
        points, values = rng.random((40, 3)), rng.random((40, 12))
        surrogate = Surrogate.fit(points, values)
        u, y = rng.random((30, 3)), rng.random((30, 12))
        pairs, angles, rms = ranking(surrogate, u, y)
        guess = surrogate(u)
        f = [np.abs(v[:15] - v[15:]).sum(axis=1) for v in (guess, y)]
        assert pairs == pytest.approx(spearmanr(*f).statistic)
        assert angles == min(spearmanr(guess[:, k], y[:, k]).statistic for k in range(12))
        assert rms == pytest.approx(np.sqrt(((guess - y) ** 2).mean()))
        assert ranking(surrogate, points, values)[0] == pytest.approx(1.0)

    def test_each_is_the_search_of_its_size_and_seed(self):
        sweep = training_sweep(sizes=(40, 60), n_seeds=2, seed=3, method="exact", **REST)
        for k, size in enumerate((40, 60)):
            for s in range(2):
                same = worst_case(
                    method="exact",
                    search_space="surrogate",
                    training_samples=size,
                    seed=3 + s,
                    **REST,
                )
                assert sweep.objective_surrogate[k, s] == same.objective_surrogate
                assert sweep.objective_model[k, s] == pytest.approx(same.objective_model)
                assert sweep.gap_percent[k, s] == pytest.approx(same.gap_percent)

    def test_the_genetic_algorithm_searches_unless_told_otherwise(self):
        sweep = training_sweep(sizes=(35,), n_seeds=1, seed=1)
        same = worst_case(training_samples=35, seed=1)
        assert sweep.objective_surrogate[0, 0] == same.objective_surrogate
        assert sweep.objective_model[0, 0] == pytest.approx(same.objective_model)

    def test_more_runs_rank_better(self):
        sweep = training_sweep(sizes=(40, 150), n_seeds=2, method="exact", **REST)
        few, many = sweep.rank_correlation.mean(axis=1)
        assert few < many
        assert sweep.rms_error_deg[1].max() < sweep.rms_error_deg[0].min()

    def test_threads_change_nothing(self):
        one, two = (
            training_sweep(sizes=(40,), n_seeds=1, method="exact", threads=t, **REST)
            for t in (1, 2)
        )
        assert one.objective_model.tobytes() == two.objective_model.tobytes()
        assert one.rank_correlation.tobytes() == two.rank_correlation.tobytes()


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: bound_sweep(bounds_mm=[]), "`bounds_mm` is []"),
        (lambda: bound_sweep(bounds_mm=[1.0, -1.0]), "numbers above 0"),
        (lambda: bound_sweep(ParameterSpace(case="material")), "`case` is 'material'"),
        (lambda: needed_accuracy(within_deg=float("nan")), "`within_deg` is nan"),
        (lambda: needed_accuracy(tolerance_mm=0.0), "`tolerance_mm` is 0"),
        (lambda: needed_accuracy(largest_mm=float("inf")), "numbers above 0"),
        (lambda: training_sweep(sizes=(20,)), "`training_samples` is 20"),
        (lambda: training_sweep(sizes=()), "`sizes` is empty"),
        (lambda: training_sweep(n_seeds=0), "`n_seeds` is 0"),
        (lambda: training_sweep(solver="magic"), "`solver` is 'magic'"),
        (lambda: bound_sweep(bounds_mm=[0.5], solver="magic"), "`solver` is 'magic'"),
    ],
)
def test_refused_in_a_sentence(call, said):
    with pytest.raises(ParameterError) as refused:
        call()
    assert said in str(refused.value)


class TestCommand:
    def test_bound_prints_and_writes(self, capsys, tmp_path):
        arguments = ["bound", "--bounds-mm", "0.3", "0.6", "--solver", "equilibrium"]
        arguments += ["--out", str(tmp_path / "a"), "--quiet"]
        code, out, _ = called(capsys, main, *arguments)
        assert code == 0
        assert "if the geometry is known to within 0.2" in out
        names = sorted(p.name for p in (tmp_path / "a").iterdir())
        assert names == ["bound_sweep.json", "figure_bound.png", "figure_bound.svg"]
        document = json.loads((tmp_path / "a" / "bound_sweep.json").read_text())
        assert document["bound_mm"] == [0.3, 0.6]
        assert document["needed_accuracy"]["within_deg"] == 5.0
        code, _, err = called(capsys, main, *arguments)
        assert code == 2
        assert "--force" in err

    def test_training_prints_json(self, capsys):
        arguments = ["training", "--sizes", "32", "40", "--seeds", "2", "--method", "exact"]
        code, out, _ = called(capsys, main, *arguments, "--json", "--quiet")
        assert code == 0
        document = json.loads(out)
        assert np.shape(document["gap_percent"]) == (2, 2)
        assert document["training_samples"] == [32, 40]

    @pytest.mark.parametrize(
        ("arguments", "said"),
        [
            (["training", "--sizes", "20"], "`training_samples` is 20"),
            (["training", "--seeds", "0"], "`--seeds` is 0"),
            (["bound", "--bounds-mm", "0"], "`--bounds-mm` is [0.0]"),
            (["bound", "--case", "material"], "`--case` is 'material'"),
            (["bound", "--out", "/dev/null/x"], "a writable folder is allowed"),
            ([], "Expected one of {training, bound}. (see --help)"),
        ],
    )
    def test_a_users_mistake_gets_one_line_and_exit_code_2(self, capsys, arguments, said):
        quiet = ["--quiet"] if arguments else []
        code, out, err = called(capsys, main, *arguments, *quiet)
        assert (code, out) == (2, "")
        assert said in err
        assert err.count("\n") == 1


def test_tables_are_wide_enough_for_their_numbers(bounds):
    assert "…" not in str(bounds)
    assert "…" not in str(training_sweep(sizes=(35,), n_seeds=2, method="exact", **REST))


def test_where_the_models_range_ends_it_is_told():
    wide = bound_sweep(bounds_mm=[2.5], **REST)
    assert "the model's range ends" in str(wide)
    assert kneecore.bound_sweep is bound_sweep

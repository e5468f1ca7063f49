"""Sweeps over training sizes and over the geometry's bound, and the needed accuracy."""

import json

import numpy as np
import pytest
from commands import called
from scipy.stats import spearmanr

import kneecore
from kneecore import (
    BoundSweepSettings,
    Cancelled,
    Knee,
    NeededAccuracySettings,
    ParameterError,
    ParameterSpace,
    SearchSettings,
    TrainingSweepSettings,
    bound_sweep,
    needed_accuracy,
    simulate_batch,
    training_sweep,
    worst_case,
)
from kneecore.cli.sweep import main
from kneecore.files.digest import with_digest
from kneecore.knee.bounds import with_geometry_bound
from kneecore.knee.readings import deficit_deg, over_extension_deg
from kneecore.numerics.sampling import uniform
from kneecore.numerics.surrogate import Surrogate
from kneecore.study.surrogate_quality import judge

REST = Knee(solver="equilibrium")


def swept(model=REST, *, callback=None, **settings):
    """Sweep over bounds, of the packaged knees at rest unless told otherwise."""
    return bound_sweep(model, BoundSweepSettings(**settings), callback=callback)


def needed(model=REST, **settings):
    """Return the needed accuracy, of the packaged knees at rest unless told otherwise."""
    return needed_accuracy(model, NeededAccuracySettings(**settings))


def trained(model=REST, **settings):
    """Sweep over training sizes, of the packaged knees at rest unless told otherwise."""
    return training_sweep(model, TrainingSweepSettings(**settings))


@pytest.fixture(scope="module")
def bounds():
    return swept(sizes=(0.25, 0.5, 1.0))


@pytest.fixture(scope="module")
def need():
    return needed()


class TestBounds:
    def test_each_is_the_exact_worst_case_of_its_space(self, bounds):
        space = ParameterSpace(geometry_bound_mm=0.5, slope_bound_deg=0.5)
        worst = worst_case(REST.with_space(space), SearchSettings(method="exact"))
        assert bounds.objective[1] == worst.objective_model
        one, two = worst.y[:, 5]
        assert over_extension_deg(bounds.pair)[1] == pytest.approx(-one, abs=1e-9)
        assert deficit_deg(bounds.pair)[1] == pytest.approx(max(two, 0.0), abs=1e-9)

    def test_a_wider_box_holds_worse_knees(self, bounds):
        assert (np.diff(bounds.objective) > 0.0).all()
        assert (np.diff(bounds.extremes[:, 0]) < 0.0).all()
        assert (np.diff(bounds.extremes[:, 1]) > 0.0).all()

    def test_no_sampled_knee_lies_beyond_the_extremes(self, bounds):
        for k, bound in enumerate(bounds.size):
            space = ParameterSpace(geometry_bound_mm=bound, slope_bound_deg=bound)
            sample = simulate_batch(space.from_unit(uniform(3000, 28, 7)), solver="equilibrium")
            angles = np.degrees(sample.flexion[:, 5])
            assert bounds.extremes[k, 0] <= angles.min()
            assert angles.max() <= bounds.extremes[k, 1]

    def test_both_ways_of_responding(self):
        moving = swept(Knee(), sizes=[0.5])
        resting = swept(sizes=[0.5])
        # At 5 N m a knee has come to rest.
        np.testing.assert_allclose(moving.extremes, resting.extremes, atol=0.1)
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
            swept(sizes=(0.5, 1.0), callback=lambda report: report.done == 1)


class TestNeededAccuracy:
    def test_the_answer_is_bracketed_from_both_sides(self, need):
        assert need.beyond - need.size <= 0.005
        assert need.largest_value <= 5.0 < need.beyond_value
        for bound, angle in (
            (need.size, need.largest_value),
            (need.beyond, need.beyond_value),
        ):
            (largest,) = swept(sizes=[bound]).extremes[:, 1]
            assert largest == pytest.approx(angle, abs=1e-6)

    def test_no_random_knee_contradicts_it(self, need):
        assert need.sampled_value <= need.largest_value

    def test_a_stricter_demand_needs_more_accuracy(self, need):
        strict = needed(within=2.0)
        assert strict.size < need.size

    def test_when_even_exact_geometry_is_not_enough(self):
        never = needed(within=-3.8)
        assert never.size is None
        assert never.summary().startswith("Not every knee extends to within -3.8 deg")
        assert never.largest_value > -3.8

    def test_when_the_widest_bound_is_enough(self):
        easy = needed(within=30.0, largest=1.0)
        assert (easy.size, easy.reaches_largest) == (1.0, True)
        assert "the widest bound that was looked at" in easy.summary()
        assert easy.beyond is None


class TestTraining:
    def test_ranking_is_spearmans(self):
        rng = np.random.default_rng(0)
        points, values = rng.random((40, 3)), rng.random((40, 12))
        surrogate = Surrogate.fit(points, values)
        u, y = rng.random((30, 3)), rng.random((30, 12))
        weights = np.ones(12)
        found = judge(surrogate, u, y, weights)
        guess = surrogate(u)
        f = [np.abs(v[:15] - v[15:]).sum(axis=1) for v in (guess, y)]
        assert found.rank_f == pytest.approx(spearmanr(*f).statistic)
        each = [spearmanr(guess[:, k], y[:, k]).statistic for k in range(12)]
        np.testing.assert_allclose(found.rank, each, rtol=1e-12)
        assert found.worst_rank == min(found.rank)
        assert found.rms_all == pytest.approx(np.sqrt(((guess - y) ** 2).mean()))
        assert judge(surrogate, points, values, weights).rank_f == pytest.approx(1.0)
        shares = 1.0 - ((guess - y) ** 2).mean(axis=0) / y.var(axis=0)
        np.testing.assert_allclose(found.explained, shares)

    def test_each_is_the_search_of_its_size_and_seed(self):
        sweep = trained(sizes=(40, 60), n_seeds=2, seed=3, method="exact")
        for k, size in enumerate((40, 60)):
            for s in range(2):
                settings = SearchSettings(
                    method="exact",
                    search_space="surrogate",
                    training_samples=size,
                    seed=3 + s,
                )
                same = worst_case(REST, settings)
                assert sweep.objective_surrogate[k, s] == same.objective_surrogate
                assert sweep.objective_model[k, s] == pytest.approx(same.objective_model)
                assert sweep.gap_percent[k, s] == pytest.approx(same.gap_percent)

    def test_the_genetic_algorithm_searches_unless_told_otherwise(self):
        sweep = trained(Knee(), sizes=(35,), n_seeds=1, seed=1)
        same = worst_case(Knee(), SearchSettings(training_samples=35, seed=1))
        assert sweep.objective_surrogate[0, 0] == same.objective_surrogate
        assert sweep.objective_model[0, 0] == pytest.approx(same.objective_model)

    def test_more_runs_rank_better(self):
        sweep = trained(sizes=(40, 150), n_seeds=2, method="exact")
        few, many = sweep.rank_f.mean(axis=1)
        assert few < many
        assert sweep.rms_error[1].max() < sweep.rms_error[0].min()

    def test_threads_change_nothing(self):
        one, two = (
            trained(Knee(solver="equilibrium", threads=t), sizes=(40,), n_seeds=1, method="exact")
            for t in (1, 2)
        )
        assert one.objective_model.tobytes() == two.objective_model.tobytes()
        assert one.rank_f.tobytes() == two.rank_f.tobytes()


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: swept(sizes=[]), "`sizes` is empty"),
        (lambda: swept(sizes=[1.0, -1.0]), "`sizes` is -1; a number above 0 is allowed"),
        (lambda: swept(sizes=0.5), "`sizes` is 0.5; a row of numbers is allowed"),
        (lambda: swept(Knee(ParameterSpace(case="material"))), "`case` is 'material'"),
        (lambda: swept(seed=-1), "`seed` is -1"),
        (lambda: needed(within=float("nan")), "`within` is nan"),
        (lambda: needed(tolerance=0.0), "`tolerance` is 0"),
        (lambda: needed(largest=float("inf")), "`largest` is inf"),
        (lambda: trained(sizes=(20,)), "`training_samples` is 20"),
        (lambda: trained(sizes=()), "`sizes` is empty"),
        (lambda: trained(sizes=(40, 2.5)), "`sizes` is 2.5; a whole number"),
        (lambda: trained(n_seeds=0), "`n_seeds` is 0"),
        (lambda: trained(method="magic"), "`method` is 'magic'"),
        (lambda: bound_sweep(ParameterSpace()), "a kneecore.Model is allowed"),
        (lambda: training_sweep(REST, SearchSettings()), "TrainingSweepSettings are allowed"),
        (lambda: needed_accuracy(REST, callback=3), "`callback` is 3"),
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
        study = kneecore.load(tmp_path / "a")
        assert with_digest(study.to_dict()) == document
        assert str(study) == out.rstrip("\n")
        assert study.need.settings.within == 5.0
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
            (["bound", "--bounds-mm", "0"], "`--bounds-mm` is 0; a number above 0"),
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
    assert "…" not in str(trained(sizes=(35,), n_seeds=2, method="exact"))


def test_where_the_models_range_ends_it_is_told():
    wide = swept(sizes=[2.5])
    assert "the model's range ends" in str(wide)
    assert kneecore.bound_sweep is bound_sweep


@pytest.mark.parametrize("which", [0, 1, 2])
def test_sweeps_come_back_from_their_folders(bounds, need, tmp_path, which):
    sweep = trained(sizes=(35, 40), n_seeds=2, method="exact") if which == 2 else None
    result = (bounds, need, sweep)[which]
    written = result.save(tmp_path / "a")
    assert len(written) == 1 + 2 * len(result.figures())
    again = kneecore.load(tmp_path / "a")
    assert again.to_json() == result.to_json()
    assert str(again) == str(result)

"""A surrogate that repairs itself: what it finds, what it may use, and what it tells."""

import json

import jsonschema
import numpy as np
import pytest
from commands import called
from results import SCHEMA, check_comes_back, older
from searches import searched, sum_of
from study_models import ishigami

import kneecore.search.repair
from kneecore import (
    Input,
    Knee,
    Model,
    Output,
    ParameterError,
    ParameterSpace,
    SearchResult,
    SearchSettings,
    simulate_batch,
    worst_case,
)
from kneecore.cli.search import main
from kneecore.report.command import command_line
from kneecore.search.exact_model import exact_pair

SMALL = ParameterSpace(case="material")


@pytest.fixture(scope="module")
def result():
    return searched(SMALL, method="exact", repair=True, seed=2)


@pytest.mark.parametrize("solver", ["dynamics", "equilibrium"])
@pytest.mark.parametrize("seed", [0, 8, 129])
def test_all_parameters_within_one_per_cent_of_the_exact_search(solver, seed):
    exact = exact_pair(Knee(solver=solver)).objective
    plain = searched(method="exact", search_space="surrogate", solver=solver, seed=seed)
    repaired = searched(method="exact", repair=True, solver=solver, seed=seed)
    repair = repaired.repair
    assert plain.objective_model < 0.98 * exact  # there is something to repair
    assert abs(repair.rounds[-1].gap_percent) < 1.0
    assert repair.reached
    assert repaired.stop_reason == "repaired"
    assert repair.n_models <= 40
    assert 0.99 * exact <= repaired.objective_model <= exact * (1.0 + 1e-6)


def test_the_genetic_algorithm_is_repaired_too():
    exact = exact_pair(Knee(SMALL)).objective
    repaired = searched(SMALL, repair=True, pop_size=60, n_generations=60)
    assert repaired.objective_model > 0.99 * exact
    assert repaired.repair.reached
    assert repaired.counts["pairs_evaluated"] > 60 * 60


def test_the_result_says_what_it_is(result):
    repair = result.repair
    assert result.settings.search_space == "surrogate"
    assert result.objective_model == pytest.approx(sum_of(result), abs=1e-9)
    assert result.objective_surrogate == repair.rounds[-1].objective_surrogate
    assert len(result.training_x) == 50 + repair.n_models
    assert result.counts["models_simulated"] == 50 + repair.n_models
    added = [r.n_models for r in repair.rounds]
    assert added == sorted(added)
    assert added[-1] == repair.n_models
    assert "Surrogate repaired with" in str(result)


def test_the_samples_are_what_the_model_says(result):
    batch = simulate_batch(result.training_x, baseline=SMALL.baseline)
    np.testing.assert_allclose(np.radians(result.training_y), batch.flexion, rtol=1e-12)
    pairs = np.degrees(np.abs(batch.flexion[:, None] - batch.flexion)).sum(axis=2)
    assert result.objective_model == pytest.approx(pairs.max(), abs=1e-9)


def test_no_model_is_computed_twice(result):
    unit = SMALL.to_unit(result.training_x)
    apart = np.abs(unit[:, None] - unit).max(axis=2)
    np.fill_diagonal(apart, 1.0)
    assert apart.min() > 1e-3


def test_the_first_gap_is_that_of_the_search_without_repair(result):
    plain = searched(SMALL, method="exact", search_space="surrogate", seed=2)
    assert result.repair.rounds[0].objective_surrogate == plain.objective_surrogate
    assert result.repair.rounds[0].gap_percent == pytest.approx(plain.gap_percent, abs=1e-9)


def test_json_follows_the_schema_and_comes_back(result):
    document = check_comes_back(result)
    again = SearchResult.from_json(result.to_json())
    assert again.repair == SearchResult.from_json(again.to_json()).repair
    document["repair"]["rounds"][0].pop("gap_percent")
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document, SCHEMA)
    plain = json.loads(searched(SMALL, method="exact", search_space="surrogate").to_json())
    del plain["repair"]
    assert SearchResult.from_json(json.dumps(older(plain))).repair is None


def test_the_command_gives_the_same_result_again(result, capsys):
    words = command_line(result).removeprefix("python -m kneecore.search ").split()
    assert "--repair" in words
    code, out, _ = called(capsys, main, *words, "--json", "--quiet", "--threads", "1")
    assert code == 0
    again, mine = json.loads(out), json.loads(result.to_json())
    for key in ("seconds", "threads", "digest"):
        again.pop(key), mine.pop(key)
    assert again == mine


def test_files_hold_the_repairs_figure(result, tmp_path):
    names = {path.name for path in result.save(tmp_path / "out")}
    assert {"figure_5_repair.png", "figure_5_repair.svg"} <= names
    plain = searched(SMALL, pop_size=20, n_generations=5)
    plain.save(tmp_path / "out", force=True)
    assert not list((tmp_path / "out").glob("figure_5*"))


def test_as_few_models_as_were_allowed():
    for allowed in (2, 3, 5):
        few = searched(SMALL, method="exact", repair=True, repair_models=allowed)
        assert few.repair.n_models <= allowed
        assert few.repair.rounds[0].n_models == 2


@pytest.mark.parametrize(("most", "seed"), [(8, 1), (8, 2), (9, 0), (11, 1), (12, 0)])
def test_no_more_models_than_were_allowed(most, seed):
    asked = {"repair_models": most, "repair_gap_percent": 10.0, "training_samples": 10}
    settings = SearchSettings(method="exact", repair=True, seed=seed, **asked)
    assert worst_case(ishigami(), settings).repair.n_models <= most


def test_a_goal_that_is_out_of_reach_is_told():
    hard = searched(method="exact", repair=True, repair_models=2, repair_gap_percent=0.5)
    assert hard.stop_reason == "not_repaired"
    assert not hard.repair.reached
    assert "not repaired" in str(hard)


def holed(k):
    """Two stiff springs whose model fails where the surrogate's optimum is."""
    y = np.outer(1.0 / k[:, 0] + 1.0 / k[:, 1], [1.0, 2.0, 5.0])
    y[(k[:, 0] < 90.5) & (k[:, 1] < 45.25)] = np.nan
    return y


def test_failed_models_are_counted_and_in_no_fit():
    springs = Model(
        holed,
        [Input("k_1", lower=90.0, upper=110.0), Input("k_2", lower=45.0, upper=55.0)],
        [Output("stretch", axis=(1, 2, 5))],
        batched=True,
    )
    pair = worst_case(
        springs, SearchSettings(training_samples=20, method="exact", repair=True, repair_models=12)
    )
    assert pair.repair.n_failed >= 1
    assert np.isfinite(pair.y).all()
    assert pair.repair.rounds[0].gap_percent is None
    assert pair.objective_model > 0.9 * 8.0 * (1 / 90 + 1 / 45 - 1 / 110 - 1 / 55)
    assert "of them failed" in str(pair)


def test_knees_that_fail_in_the_corner_do_not_cost_the_answer():
    wide = ParameterSpace(geometry_bound_mm=3.0)
    fixed = searched(wide, method="exact", repair=True, rest_length="fixed")
    plain = searched(wide, method="exact", search_space="surrogate", rest_length="fixed")
    assert plain.objective_model is None
    assert fixed.objective_model == pytest.approx(sum_of(fixed), abs=1e-9)


def test_same_seed_same_bytes_on_any_number_of_threads():
    one, two = (searched(SMALL, repair=True, pop_size=40, n_generations=20, threads=t)
                for t in (1, 2))  # fmt: skip
    assert one.x.tobytes() == two.x.tobytes()
    assert one.repair == two.repair
    assert one.training_y.tobytes() == two.training_y.tobytes()


@pytest.mark.parametrize("method", ["ga", "exact"])
def test_a_callback_cancels_and_keeps_what_there_is(method):
    def stop(report):
        return report.stage == "repair" and report.done >= 4

    found = searched(method=method, repair=True, callback=stop)
    assert found.stop_reason == "cancelled"
    assert 4 <= found.repair.n_models < 40
    assert found.objective_model == pytest.approx(sum_of(found), abs=1e-9)


def test_each_model_of_the_pair_keeps_its_place(monkeypatch):
    """A surrogate's pair has no order: trials of one model must not be taken for the other's."""
    tried = []
    original = kneecore.search.repair._Repairing._try_one

    def watched(self, u, y):
        done = original(self, u, y)
        tried.append((u.copy(), y.copy()))
        return done

    monkeypatch.setattr(kneecore.search.repair._Repairing, "_try_one", watched)
    searched(method="exact", repair=True, solver="equilibrium")
    sides = {bool(y[0, 5] > y[1, 5]) for _, y in tried}
    assert len(tried) > 10
    assert len(sides) == 1


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"repair": True, "search_space": "model"}, "`search_space` is 'model'; with `repair`"),
        ({"repair_models": 20}, "`repair_models` is 20; it needs `repair`"),
        ({"repair_gap_percent": 2}, "`repair_gap_percent` is 2.0; it needs `repair`"),
        ({"repair": True, "repair_gap_percent": 0.0}, "a number above 0 and below 100"),
        ({"repair": True, "repair_gap_percent": float("nan")}, "a finite number is allowed"),
        ({"repair": True, "repair_models": 1}, "at least 2 are needed"),
        ({"repair": True, "repair_models": 0}, "`repair_models` is 0"),
    ],
)
def test_conflicting_arguments_are_refused(arguments, said):
    with pytest.raises(ParameterError) as error:
        searched(SMALL, **arguments)
    assert said in str(error.value)


def test_conflicts_on_the_command_line(capsys, tmp_path):
    for words, said in (
        (["--repair", "--space", "model"], "`--space` is 'model'; with `--repair`"),
        (["--repair-models", "20"], "`--repair-models` is 20; it needs `--repair`"),
    ):
        code, out, err = called(capsys, main, *words, "--out", str(tmp_path / "none"))
        assert (code, out) == (2, "")
        assert said in err
        assert len([line for line in err.splitlines() if not line.endswith("...")]) == 1
    assert not (tmp_path / "none").exists()

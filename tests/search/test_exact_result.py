"""The method "exact": the same result as the genetic algorithm's, with its evidence."""

import json

import jsonschema
import numpy as np
import pytest
from results import SCHEMA, check_comes_back, older
from searches import searched, sum_of

from kneecore import (
    Input,
    Model,
    Output,
    ParameterError,
    ParameterSpace,
    SearchResult,
    SearchSettings,
    worst_case,
)
from kneecore.cli.search import main
from kneecore.report.command import command_line

SMALL = ParameterSpace(case="material")


@pytest.fixture(
    scope="module",
    params=[("model", "dynamics"), ("model", "equilibrium"), ("surrogate", "dynamics")],
)
def result(request):
    search_space, solver = request.param
    return searched(SMALL, method="exact", search_space=search_space, solver=solver, seed=2)


def test_the_result_says_what_it_is(result):
    assert result.settings.method == "exact"
    assert result.stop_reason == "converged"
    assert result.objective_model == pytest.approx(sum_of(result), abs=1e-9)
    assert result.evidence is not None
    assert result.evidence.n_climbs > 0
    assert "No proof" in str(result)
    assert result.counts["pairs_evaluated"] == 0
    assert result.responses["model_1"].settled.all() or result.model.solver == "dynamics"


def test_json_follows_the_schema_and_comes_back(result):
    broken = check_comes_back(result)
    broken["evidence"]["share_reached"] = 2
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(broken, SCHEMA)


def test_the_command_gives_the_same_result_again(result, capsys):
    words = command_line(result).removeprefix("python -m kneecore.search ").split()
    assert main([*words, "--json", "--quiet"]) == 0
    again = json.loads(capsys.readouterr().out)
    mine = json.loads(result.to_json())
    for key in ("seconds", "threads", "digest"):
        again.pop(key), mine.pop(key)
    assert again == mine


def test_files_can_be_written(result, tmp_path):
    written = result.save(tmp_path / "out")
    assert SearchResult.load(tmp_path / "out").to_json() == result.to_json()
    assert len(written) > 2


def test_an_older_result_without_method_or_evidence_is_read():
    old = json.loads(searched(SMALL, pop_size=20, n_generations=5).to_json())
    for key in ("method", "solver", "evidence", "lost_at_nm"):
        del old[key]
    jsonschema.validate(old, SCHEMA)
    again = SearchResult.from_json(json.dumps(older(old)))
    assert (again.settings.method, again.model.solver) == ("ga", "dynamics")
    assert again.evidence is None


def test_exact_is_not_below_the_genetic_algorithm_in_the_same_space():
    for search_space in ("surrogate", "model"):
        exact, ga = (
            searched(SMALL, search_space=search_space, solver="equilibrium", method=m, **size)
            for m, size in (("exact", {}), ("ga", {"pop_size": 60, "n_generations": 60}))
        )
        assert exact.run_values[0] > ga.run_values[0] - 1e-4


def test_the_solver_is_the_response_that_is_searched():
    motion, rest = (searched(SMALL, method="exact", solver=s) for s in ("dynamics", "equilibrium"))
    assert rest.objective_model == pytest.approx(sum_of(rest), abs=1e-9)
    assert motion.objective_model < rest.objective_model
    ga = searched(SMALL, search_space="model", solver="equilibrium", pop_size=40, n_generations=20)
    assert ga.model.solver == "equilibrium"
    assert ga.objective_model == pytest.approx(sum_of(ga), abs=1e-9)
    assert ga.objective_model < rest.objective_model + 1e-9
    assert ga.counts["models_unsettled"] == 0


def stretch(k):
    return np.outer(1.0 / k[:, 0] + 1.0 / k[:, 1], [1.0, 2.0, 5.0])


OWN = Model(
    stretch,
    [Input("k_1", lower=90.0, upper=110.0), Input("k_2", lower=45.0, upper=55.0)],
    [Output("stretch", axis=(1, 2, 5))],
    batched=True,
)


def test_a_model_of_ones_own_is_searched_by_its_surrogate():
    pair = worst_case(OWN, SearchSettings(method="exact", training_samples=20))
    assert np.sort(pair.x[:, 0]).tolist() == [90.0, 110.0]
    assert np.sort(pair.x[:, 1]).tolist() == [45.0, 55.0]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"method": "newton"}, "`method` is 'newton'; 'ga' or 'exact' is allowed"),
        ({"solver": "newton"}, "`solver` is 'newton'; 'dynamics' or 'equilibrium' is allowed"),
        ({"method": "exact", "pop_size": 50}, "`pop_size` is 50; it is the genetic algorithm's"),
        ({"method": "exact", "n_runs": 2}, "`n_runs` is 2; it is the genetic algorithm's"),
        (
            {"method": "exact", "search_space": "surrogate", "weights": [1.0, -1.0, 1.0]},
            "`weights` is [1.0, -1.0, 1.0]; a row of finite numbers of at least 0",
        ),
    ],
)
def test_conflicting_arguments_are_refused(arguments, said):
    with pytest.raises(ParameterError) as error:
        searched(**arguments)
    assert said in str(error.value)


def test_a_model_without_gradients_is_not_searched_exactly_in_itself():
    with pytest.raises(ParameterError) as error:
        worst_case(OWN, SearchSettings(method="exact", search_space="model"))
    said = "`search_space` is 'model'; the method 'exact' has no gradients of this model"
    assert said in str(error.value)


def test_the_solver_is_no_option_of_a_search_and_of_no_other_model():
    with pytest.raises(TypeError, match="'solver'"):
        SearchSettings(solver="equilibrium")
    with pytest.raises(TypeError, match="'solver'"):
        Model(stretch, OWN.inputs, OWN.outputs, solver="equilibrium")


def test_a_callback_cancels():
    seen = []

    def stop_at_the_search(report):
        seen.append(report)
        return report.stage == "search" and report.best is not None

    result = searched(SMALL, method="exact", callback=stop_at_the_search)
    assert result.stop_reason == "cancelled"
    assert [r.stage for r in seen].count("search") >= 2
    assert np.isfinite(result.objective_model)


def test_conflicts_on_the_command_line(capsys):
    assert main(["--method", "exact", "--generations", "10"]) == 2
    assert "`--generations` is 10; it is the genetic algorithm's" in capsys.readouterr().err

"""`worst_case(method="exact")`: the same result as the genetic algorithm's, with its evidence."""

import json

import jsonschema
import numpy as np
import pytest
from results import SCHEMA, check_comes_back

from kneecore import ParameterError, ParameterSpace, SearchResult, worst_case
from kneecore.cli.search import main

SMALL = ParameterSpace(case="material")


@pytest.fixture(
    scope="module",
    params=[("model", "dynamics"), ("model", "equilibrium"), ("surrogate", "dynamics")],
)
def result(request):
    search_space, solver = request.param
    return worst_case(SMALL, method="exact", search_space=search_space, solver=solver, seed=2)


def sum_of(result):
    return float(np.degrees(np.abs(result.model_1.flexion - result.model_2.flexion)).sum())


def test_the_result_says_what_it_is(result):
    assert result.method == "exact"
    assert result.stop_reason == "converged"
    assert result.objective_model == pytest.approx(sum_of(result), abs=1e-9)
    assert result.evidence is not None
    assert result.evidence.n_climbs > 0
    assert "No proof" in str(result)
    assert result.counts["pairs_evaluated"] == 0
    assert result.model_1.settled.all() or result.solver == "dynamics"


def test_json_follows_the_schema_and_comes_back(result):
    broken = check_comes_back(result)
    broken["evidence"]["share_reached"] = 2
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(broken, SCHEMA)


def test_the_command_gives_the_same_result_again(result, capsys):
    words = result.command().removeprefix("python -m kneecore.search ").split()
    assert main([*words, "--json", "--quiet"]) == 0
    again = json.loads(capsys.readouterr().out)
    mine = json.loads(result.to_json())
    for key in ("seconds", "threads"):
        again.pop(key), mine.pop(key)
    assert again == mine


def test_files_can_be_written(result, tmp_path):
    written = result.save(tmp_path / "out")
    assert SearchResult.load(tmp_path / "out").to_json() == result.to_json()
    assert len(written) > 2


def test_an_older_result_without_method_or_evidence_is_read():
    old = json.loads(worst_case(SMALL, pop_size=20, n_generations=5).to_json())
    for key in ("method", "solver", "evidence", "lost_at_nm"):
        del old[key]
    jsonschema.validate(old, SCHEMA)
    again = SearchResult.from_json(json.dumps(old))
    assert (again.method, again.solver, again.evidence) == ("ga", "dynamics", None)


def test_exact_is_not_below_the_genetic_algorithm_in_the_same_space():
    for search_space in ("surrogate", "model"):
        exact, ga = (
            worst_case(SMALL, search_space=search_space, solver="equilibrium", method=m, **size)
            for m, size in (("exact", {}), ("ga", {"pop_size": 60, "n_generations": 60}))
        )
        assert exact.run_values[0] > ga.run_values[0] - 1e-4


def test_the_solver_is_the_response_that_is_searched():
    motion, rest = (
        worst_case(SMALL, method="exact", solver=s) for s in ("dynamics", "equilibrium")
    )
    assert rest.objective_model == pytest.approx(sum_of(rest), abs=1e-9)
    assert motion.objective_model < rest.objective_model
    ga = worst_case(
        SMALL, search_space="model", solver="equilibrium", pop_size=40, n_generations=20
    )
    assert ga.solver == "equilibrium"
    assert ga.objective_model == pytest.approx(sum_of(ga), abs=1e-9)
    assert ga.objective_model < rest.objective_model + 1e-9
    assert ga.counts["models_unsettled"] == 0


def stretch(k):
    return np.outer(1.0 / k[:, 0] + 1.0 / k[:, 1], [1.0, 2.0, 5.0])


OWN = {"model": stretch, "lower": [90.0, 45.0], "upper": [110.0, 55.0]}


def test_a_model_of_ones_own_is_searched_by_its_surrogate():
    pair = worst_case(**OWN, method="exact", training_samples=20)
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
            {**OWN, "method": "exact", "search_space": "model"},
            "`search_space` is 'model'; the method 'exact' has no grad",
        ),
        ({**OWN, "solver": "equilibrium"}, "`solver`, `threads` are the knee's"),
        (
            {**OWN, "method": "exact", "search_space": "surrogate", "weights": [1.0, -1.0, 1.0]},
            "`weights` has -1; the method 'exact' takes numbers of at least 0",
        ),
    ],
)
def test_conflicting_arguments_are_refused(arguments, said):
    with pytest.raises(ParameterError) as error:
        worst_case(**arguments)
    assert said in str(error.value)


def test_a_callback_cancels():
    seen = []

    def stop_at_the_search(report):
        seen.append(report)
        return report.stage == "search" and report.best is not None

    result = worst_case(SMALL, method="exact", callback=stop_at_the_search)
    assert result.stop_reason == "cancelled"
    assert [r.stage for r in seen].count("search") >= 2
    assert np.isfinite(result.objective_model)


def test_conflicts_on_the_command_line(capsys):
    assert main(["--method", "exact", "--generations", "10"]) == 2
    assert "`--generations` is 10; it is the genetic algorithm's" in capsys.readouterr().err

"""A result beside what all methods find: `--compare`."""

import json

import jsonschema
import numpy as np
import pytest
from commands import called
from results import SCHEMA, check_comes_back, older
from searches import searched

from kneecore import (
    Cancelled,
    Knee,
    ParameterSpace,
    SearchResult,
    SearchSettings,
    compare_methods,
    with_methods,
)
from kneecore.cli.search import main

SPACE = ParameterSpace(case="geometry", geometry_bound_mm=0.6)


@pytest.fixture(scope="module")
def plain():
    return searched(SPACE, solver="equilibrium", pop_size=20, n_generations=5, seed=4)


@pytest.fixture(scope="module")
def result(plain):
    return with_methods(plain)


def test_shortfalls_are_below_the_best_of_all(result, plain):
    found = compare_methods(Knee(SPACE, solver="equilibrium"), SearchSettings(seed=4))
    assert [t.method for t in result.methods] == [t.method for t in found]
    ends = {trace.method: trace.objective[-1] for trace in found}
    best = max([plain.objective_model, *ends.values()])
    assert result.best_of_all == best
    for trace in result.methods:
        expected = 100.0 * (best - ends[trace.method]) / best
        assert trace.shortfall_percent(best) == pytest.approx(expected, abs=1e-9)
        assert (trace.promised is None) == (trace.method in ("exact", "ga"))
        assert result.seconds[f"compare_{trace.method}"] > 0.0


def test_the_search_itself_is_what_it_was(result, plain):
    np.testing.assert_array_equal(result.x, plain.x)
    assert result.objective_model == plain.objective_model
    assert plain.methods == ()
    assert plain.best_of_all == plain.objective_model


def test_the_report_tells_every_shortfall(result):
    told = str(result)
    assert f"Best f of all methods in the true model: {result.best_of_all:.2f} deg" in told
    own = 100.0 * (1.0 - result.objective_model / result.best_of_all)
    assert own > 5.0  # twenty pairs and five generations
    assert f"this search: {own:.2f} %" in told
    for trace in result.methods:
        assert f"{trace.shortfall_percent(result.best_of_all):.2f} % after" in told


def test_json_follows_the_schema_and_comes_back(result):
    document = check_comes_back(result)
    document["comparison"]["methods"]["luck"] = document["comparison"]["methods"].pop("ga")
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document, SCHEMA)
    with pytest.raises(ValueError, match="names the method 'luck'"):
        SearchResult.from_json(json.dumps(document))
    del document["comparison"]
    assert SearchResult.from_json(json.dumps(older(document))).methods == ()


def test_the_command_compares_and_draws(capsys, tmp_path):
    words = ["--case", "material", "--solver", "equilibrium", "--method", "exact", "--compare"]
    code, out, _ = called(capsys, main, *words, "--json", "--out", str(tmp_path / "out"))
    assert code == 0
    document = json.loads(out)
    assert document["comparison"]["methods"]["exact"]["shortfall_percent"] < 1e-6
    assert document["comparison"]["best"] >= document["objective_model"]
    assert "--compare" in document["command"]
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"figure_6_convergence.png", "figure_6_convergence.svg"} <= names


def test_a_cancelled_comparison_is_no_result(plain):
    with pytest.raises(Cancelled):
        with_methods(plain, lambda report: report.done > 50)

"""What is left open is decided in one place, for the library, the command line and files alike."""

import json
from dataclasses import replace

import numpy as np
import pytest
from commands import called
from models import ishigami, ishigami_gradient

from kneecore import (
    Input,
    Knee,
    Model,
    Output,
    ParameterError,
    SearchResult,
    SearchSettings,
    worst_case,
)
from kneecore.cli.search import main

QUICK = {"repair_models": 6}
FILE = """
[[inputs]]
name = "a"
lower = 0.0
upper = 1.0

[[inputs]]
name = "b"
lower = 0.0
upper = 1.0

[[outputs]]
name = "y"

[function]
run = "{}:run"
"""


@pytest.fixture
def file(tmp_path):
    name = f"left_open_{abs(hash(tmp_path))}"
    (tmp_path / f"{name}.py").write_text("def run(x):\n    return x[0] - 2.0 * x[1]\n")
    path = tmp_path / "model.toml"
    path.write_text(FILE.format(name))
    return path


@pytest.mark.parametrize("given", [{}, {"seed": 3}, {"training_samples": 30}, {"objective": "all"}])
def test_a_model_of_ones_own_is_repaired_whatever_else_is_given(given):
    how = SearchSettings(**given).of(ishigami())
    assert (how.method, how.repair, how.search_space) == ("exact", True, "surrogate")
    assert how.repair_models == 99
    assert how.training_samples == given.get("training_samples", 50)


@pytest.mark.parametrize(
    ("given", "method"),
    [
        ({"repair": False}, "exact"),
        ({"method": "ga"}, "ga"),
        ({"pop_size": 60}, "ga"),
        ({"method": "ga", "search_space": "model"}, "ga"),
    ],
)
def test_unless_something_else_is_asked_for(given, method):
    how = SearchSettings(**given).of(ishigami())
    assert (how.method, how.repair) == (method, False)


def test_a_gradient_is_climbed():
    how = SearchSettings(seed=1).of(ishigami(gradient=ishigami_gradient))
    assert (how.method, how.repair, how.search_space) == ("exact", False, "model")


def test_a_knee_is_searched_as_in_the_paper():
    how = SearchSettings(seed=1).of(Knee())
    assert (how.method, how.repair, how.search_space) == ("ga", False, "surrogate")
    assert how.training_samples == 50
    assert SearchSettings(repair=True).of(Knee()).repair_models == 40
    with pytest.raises(ParameterError, match="`repair_models` is 9; it needs `repair`"):
        SearchSettings(repair_models=9).of(Knee())


def test_more_inputs_get_more_samples():
    inputs = [Input(f"x_{k}", lower=0.0, upper=1.0) for k in range(60)]
    how = SearchSettings(seed=1).of(Model(sum, inputs, [Output("y")]))
    assert how.training_samples == 62


@pytest.mark.parametrize(
    ("flags", "repaired"),
    [([], True), (["--seed", "2"], True), (["--repair"], True), (["--no-repair"], False)],
)
def test_the_command_line_and_its_file(file, capsys, tmp_path, flags, repaired):
    out = tmp_path / "found"
    flags = [*flags, "--max-runs", "30", "--quiet", "--json", "--out", str(out)]
    code, told, err = called(capsys, main, "--model", str(file), *flags)
    assert (code, err) == (0, "")
    document = json.loads(told)
    assert (document["repair"] is not None) == repaired
    assert document["search"]["max_runs"] == 30
    assert document["counts"]["models_simulated"] <= 30
    assert document["verdict"]["word"] == "trusted"
    again = SearchResult.load(out)
    assert again.settings.repair is repaired
    assert again.settings == SearchSettings(
        **{"seed": 2} if "2" in flags else {}, max_runs=30, repair=repaired
    ).of(again.model)


def test_yes_and_no_at_once(file, capsys):
    code, _, err = called(capsys, main, "--model", str(file), "--repair", "--no-repair")
    assert code == 2
    assert "`--repair` is given, and its opposite too" in err


@pytest.mark.parametrize("most", [20, 60])
def test_no_more_runs_than_allowed(most):
    found = worst_case(ishigami(), SearchSettings(max_runs=most))
    assert found.counts["models_simulated"] <= most
    assert replace(found.settings, seed=1).of(ishigami()).max_runs == most


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"max_runs": 7}, "`max_runs` is 7; at least 8 are needed: 5 to fit a surrogate of 3 free"),
        ({"max_runs": 60, "training_samples": 50, "repair_models": 40}, "at least 91 are needed"),
        ({"max_runs": 99, "method": "ga", "search_space": "model"}, "this one is in the model"),
    ],
)
def test_too_few_runs_are_one_line(given, said):
    with pytest.raises(ParameterError, match=said.replace("(", r"\(")) as told:
        worst_case(ishigami(), SearchSettings(**given))
    assert "\n" not in str(told.value)


def test_progress_between_runs_with_the_time_left():
    reports = []

    def run(x):
        return np.sin(3.0 * x).sum()

    def watch(report):
        reports.append(report)
        return len([r for r in reports if r.stage == "repair"]) == 7

    model = Model(run, ishigami().inputs, [Output("y")])
    found = worst_case(model, SearchSettings(max_runs=60), callback=watch)
    assert found.stop_reason == "cancelled"
    sampling = [r for r in reports if r.stage == "sampling" and 0 < r.done < r.total]
    assert all(r.seconds_left is not None and r.seconds_left >= 0.0 for r in sampling)
    assert found.counts["models_simulated"] < 40
    assert found.objective_model == pytest.approx(np.ptp(found.training_y))

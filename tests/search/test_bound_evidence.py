"""`bound`: what slopes say about a search's f, as a search tells it, against brute force."""

import json

import models
import numpy as np
import pytest
from results import check_comes_back, older
from searches import knee_of, same_bytes, searched

from kneecore import (
    Input,
    Knee,
    Model,
    Output,
    ParameterError,
    ParameterSpace,
    SearchResult,
    SearchSettings,
    worst_case,
)
from kneecore.cli.search import main
from kneecore.search.exact_model import exact_pair
from kneecore.search.slope_signs import slope_signs, vertices

SMALL = ParameterSpace(case="material")
BOUND = SearchSettings(method="exact", bound=True)


def _brute(model, n):
    """Return the largest f over a grid of n points an input: the outputs are few."""
    axes = [np.linspace(a, b, n) for a, b in zip(model.lower, model.upper, strict=True)]
    y = model.evaluate(np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, len(axes)))
    signs = np.array(np.meshgrid(*[[1.0, -1.0]] * y.shape[1])).reshape(y.shape[1], -1)
    sums = y @ signs
    return float((sums.max(axis=0) - sums.min(axis=0)).max())


def _springs(**options):
    """Two springs in series and a third beside them: every slope keeps its sign."""

    def run(k):
        a, b, c = k.T
        return np.stack([1e3 / a + 1e3 / b, 1e2 / c - 1e2 / a], axis=1)

    def gradient(k):
        a, b, c = k.T
        zero = np.zeros(len(k))
        first = np.stack([-1e3 / a**2, -1e3 / b**2, zero], axis=1)
        return np.stack([first, np.stack([1e2 / a**2, zero, -1e2 / c**2], axis=1)], axis=1)

    inputs = [Input(f"k_{i}", nominal=100.0, tolerance_percent=20) for i in (1, 2, 3)]
    outputs = [Output("stretch"), Output("play")]
    return Model(run, inputs, outputs, gradient=gradient, batched=True, **options)


def _told(result):
    bound = result.evidence.bound
    return [one.objective for one in bound.bounds]


def test_where_the_largest_is_inside_the_bound_is_above_it(monkeypatch):
    monkeypatch.setattr("kneecore.search.sampled_bound.MAX_SPLITS", 2)  # for the test's speed
    model = models.ishigami(gradient=models.ishigami_gradient)
    result = worst_case(model, BOUND)
    bound, true = result.evidence.bound, _brute(model, 61)
    assert result.objective_model >= true - 1e-9
    assert (bound.n_inputs, bound.n_one_signed, bound.n_vertices) == (3, 0, 16)
    assert bound.vertices_objective < true
    told = _told(result)
    assert result.objective_model <= told[0] < told[1] < told[2] < told[3]
    assert [one.widening_percent for one in bound.bounds] == [0, 5, 10, 25]
    check_comes_back(result)
    said = " ".join(str(result).split())
    assert "sampled bound, if slopes stay within 5 % of their sampled range" in said
    assert "sampled bound, if slopes stay within their sampled range" in said
    assert "below the search's f)" in said


def test_where_all_slopes_keep_their_sign_the_bound_is_the_largest_itself():
    model = _springs()
    result = worst_case(model, BOUND)
    bound, true = result.evidence.bound, _brute(model, 5)
    assert (bound.n_one_signed, bound.n_vertices, bound.n_patterns) == (3, 2, 2)
    assert result.objective_model == pytest.approx(true, rel=1e-12)
    assert bound.vertices_objective == pytest.approx(true, rel=1e-12)
    assert bound.vertices_in_motion is None
    assert _told(result)[0] == pytest.approx(true, rel=1e-12)


@pytest.fixture(scope="module", params=["dynamics", "equilibrium"])
def small(request):
    return searched(SMALL, solver=request.param, method="exact", bound=True, seed=2)


def test_a_knee_is_bounded_at_rest(small):
    bound = check_comes_back(small)["evidence"]["bound"]
    assert (bound["inputs"], bound["one_signed"], bound["vertices"]) == (6, 6, 2)
    rest = small.evidence.objective_proxy
    assert bound["vertices_objective"] == pytest.approx(rest, rel=1e-6)
    assert _told(small)[0] == pytest.approx(rest, rel=1e-6)
    moved = bound["vertices_objective_in_motion"]
    if small.model.solver == "equilibrium":
        assert moved is None
    else:
        assert moved == pytest.approx(small.objective_model, rel=1e-6)
        assert "motion has no slopes" in str(small)
    assert "--bound" in small.to_dict()["command"]


def test_all_else_is_as_without_it(small):
    plain = searched(SMALL, solver=small.model.solver, method="exact", seed=2)
    mine, other = small.to_dict(), plain.to_dict()
    assert other["evidence"].pop("bound") is None
    mine["evidence"].pop("bound")
    for document in (mine, other):
        for key in ("seconds", "command", "bound"):
            document.pop(key)
    assert mine == other


def test_the_bytes_depend_on_no_threads():
    few = {"method": "exact", "bound": True, "objective": "extension"}
    runs = [searched(SMALL, threads=n, **few) for n in (1, 2)]
    assert same_bytes(*runs)


def test_the_default_knees_worst_pair_is_the_best_of_its_vertices():
    knee = Knee(solver="equilibrium")
    found = exact_pair(knee)
    signed = np.array(found.evidence.patterns[0][0]) * knee.weights()
    signs = slope_signs(knee.slopes, knee.n_free, signed)
    assert (signs.n_sampled, signs.n_one_signed, signs.n_failed) == (19, 19, 0)
    corners = vertices(signs.sides)
    values = [knee.evaluate(knee.from_free_unit(u)) @ signed for u in corners]
    assert values[0].max() - values[1].min() == pytest.approx(found.objective, abs=1e-6)


def test_where_knees_fail_there_is_no_bound_and_that_is_said():
    wide = {"geometry_bound_mm": 3.0, "slope_bound_deg": 3.0, "material_bound_percent": 30.0}
    knee = Knee(ParameterSpace(**wide), solver="equilibrium")
    result = worst_case(knee, BOUND)
    bound = result.evidence.bound
    assert bound.n_failed > 0
    assert (bound.n_vertices, bound.bounds) == (None, ())
    check_comes_back(result)
    said = " ".join(str(result).split())
    assert f"{28 - bound.n_one_signed} inputs are not one-signed, too many to enumerate" in said
    assert "No sampled bound: models within the bounds fail" in said


def test_progress_is_told_and_a_cancelled_bound_keeps_the_pair():
    reports = []

    def stop(report):
        reports.append(report)
        return report.stage == "bound" and report.done > 40

    few = {"method": "exact", "bound": True, "objective": "extension"}
    result = searched(SMALL, callback=stop, **few)
    shares = [r.done for r in reports if r.stage == "bound"]
    assert shares == sorted(shares)
    assert shares[0] == 0
    assert len(set(shares)) > 5
    assert {r.best for r in reports if r.stage == "bound"} == {result.objective_model}
    assert (result.stop_reason, result.evidence.bound) == ("converged", None)
    check_comes_back(result)
    assert "The sampled bound was cancelled." in str(result)


def test_an_older_result_without_it_is_read():
    old = searched(SMALL, method="exact").to_dict()
    del old["bound"], old["evidence"]["bound"], old["evidence"]["description"]
    again = SearchResult.from_json(json.dumps(older(old)))
    assert again.settings.bound is False
    assert again.evidence.bound is None


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"method": "ga"}, "it needs the method 'exact' in the true model, not the method 'ga'"),
        ({"repair": True}, "it needs the method 'exact' in the true model, not `repair`"),
        (
            {"search_space": "surrogate"},
            "gradients of the true model, and the search is in the surrogate",
        ),
        ({"bound": 3}, "`bound` is 3"),
    ],
)
def test_what_has_no_slopes_is_refused(options, said):
    with pytest.raises(ParameterError) as error:
        searched(SMALL, **{"method": "exact", "bound": True} | options)
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_a_model_without_gradient_or_with_many_outputs_is_refused():
    with pytest.raises(ParameterError, match="this model has none, and its surrogate is searched"):
        worst_case(models.ishigami(), BOUND)
    many = Model(
        lambda x: np.tile(x[:, :1], 13),
        [Input("x", lower=0.0, upper=1.0)],
        [Output("y", axis=tuple(range(13)))],
        gradient=lambda x: np.ones((len(x), 13, 1)),
        batched=True,
    )
    with pytest.raises(ParameterError, match=r"13 numbers .* at most 12 are allowed"):
        worst_case(many, BOUND)


def test_the_command_names_its_flag(capsys):
    assert main(["--bound", "--quiet"]) == 2
    assert "`--bound` is True; it needs the method 'exact'" in capsys.readouterr().err


def test_the_knees_objectives_can_be_bounded():
    for objective in ("extension", "flexion"):
        settings = SearchSettings(method="exact", bound=True, objective=objective)
        settings.of(knee_of(SMALL))

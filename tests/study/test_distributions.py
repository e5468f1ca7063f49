"""Sampling and influence of inputs that are not uniform, against SciPy and exact formulas."""

import json

import numpy as np
import pytest
from results import check_comes_back
from scipy import stats

import kneecore
from kneecore import (
    InfluenceSettings,
    Input,
    Model,
    MonteCarloResult,
    Output,
    ParameterError,
    SamplingSettings,
    SearchSettings,
    influence,
    monte_carlo,
    worst_case,
)

FACTORS = np.array([2.0, -3.0, 0.5])
SD = np.array([1.0, 0.5, 2.0])
MEAN = np.array([5.0, 1.0, 0.0])


def linear(correlation=None, **options):
    """Return a sum of three normal inputs."""
    inputs = [
        Input(f"x_{k}", nominal=m, half_range=2.0 * s, **{"distribution": "normal"} | options,
              **{"deviations": 2.0} if not options else {})
        for k, (m, s) in enumerate(zip(MEAN, SD, strict=True))
    ]  # fmt: skip
    return Model(
        lambda x: x @ FACTORS[:, None], inputs, [Output("y")], batched=True, correlation=correlation
    )


@pytest.mark.parametrize("sampling", ["uniform", "latin-hypercube", "sobol"])
@pytest.mark.parametrize("correlated", [False, True])
def test_a_sum_of_normal_inputs_is_normal(sampling, correlated):
    correlation = [("x_0", "x_1", 0.8), ("x_1", "x_2", -0.3)] if correlated else None
    how = SamplingSettings(n_samples=20_000, sampling=sampling)
    study = monte_carlo(linear(correlation), how)
    matrix = np.eye(3)
    if correlated:
        matrix[0, 1] = matrix[1, 0] = 0.8
        matrix[1, 2] = matrix[2, 1] = -0.3
    parts = FACTORS * SD
    sd = np.sqrt(parts @ matrix @ parts)
    assert study.y.sd[0] == pytest.approx(sd, rel=0.02)
    assert study.y.mean[0] == pytest.approx(MEAN @ FACTORS, abs=0.02 * sd)
    ends = stats.norm(MEAN @ FACTORS, sd).ppf([0.0015, 0.9985])
    found = [study.y.percentile_lower[0], study.y.percentile_upper[0]]
    np.testing.assert_allclose(found, ends, atol=0.2 * sd)
    again = monte_carlo(linear(correlation), how)
    np.testing.assert_array_equal(again.y.percentile_upper, study.y.percentile_upper)


def test_sobol_indices_of_a_sum_are_its_shares_of_the_variance():
    found = influence(linear(), InfluenceSettings(n_base=1024))
    shares = (FACTORS * SD) ** 2 / ((FACTORS * SD) ** 2).sum()
    np.testing.assert_allclose(found.indices.first_order[0], shares, atol=0.02)
    np.testing.assert_allclose(found.indices.total_order[0], shares, atol=0.02)
    # Of uniform inputs, whose deviations go with their bounds, they are the same; so two of the
    # three are given another distribution.
    inputs = list(linear().inputs)
    inputs[0] = Input("x_0", lower=3.0, upper=7.0)
    inputs[2] = Input("x_2", lower=-4.0, upper=4.0, distribution="triangular")
    mixed = Model(lambda x: x @ FACTORS[:, None], inputs, [Output("y")], batched=True)
    sd = np.array([stats.uniform(3, 4).std(), 0.5, stats.triang(0.5, -4, 8).std()])
    shares = (FACTORS * sd) ** 2 / ((FACTORS * sd) ** 2).sum()
    found = influence(mixed, InfluenceSettings(n_base=1024, intervals=False))
    np.testing.assert_allclose(found.indices.first_order[0], shares, atol=0.02)


def test_sobol_indices_of_correlated_inputs_are_refused():
    with pytest.raises(ParameterError) as error:
        influence(linear([("x_0", "x_1", 0.5)]))
    assert str(error.value).startswith("`correlation` of the model is given; Sobol' indices share")
    assert "\n" not in str(error.value)


def test_results_say_it_and_are_read_back():
    study = monte_carlo(linear([("x_0", "x_1", 0.5)]), SamplingSettings(n_samples=100))
    told = "normal with bounds at 2 sd, correlated"
    assert f"Inputs: {told}." in str(study)
    assert "100 samples (independent, seed 0)" in str(study)
    assert told in study.figures()["figure_band"].get_suptitle()
    again = MonteCarloResult.from_json(study.to_json())
    assert again.to_json() == study.to_json()
    u = np.random.default_rng(0).random((9, 3))
    np.testing.assert_array_equal(again.model.drawn(u), study.model.drawn(u))
    found = influence(linear(), InfluenceSettings(n_base=16))
    assert "Inputs: normal with bounds at 2 sd." in str(found)
    assert all(
        "normal with" in figure.get_suptitle() + figure.axes[0].get_title()
        for figure in found.figures().values()
    )
    wrong = json.loads(study.to_json())
    wrong["model"]["correlation"][0][2] = 2.0
    with pytest.raises(kneecore.FileFormatError, match="correlation of x_0 and x_1"):
        MonteCarloResult.from_json(json.dumps(wrong))


def test_what_is_usual_is_not_told():
    study = monte_carlo(linear(distribution="uniform"), SamplingSettings(n_samples=100))
    document = json.loads(study.to_json())
    assert set(document["model"]["inputs"][0]) == {
        *("name", "nominal", "lower", "upper", "unit", "shown_unit", "shown_scale")
    }
    assert "correlation" not in document["model"]
    assert "100 samples (uniform, seed 0)" in str(study)
    assert "Inputs:" not in str(study)


def test_the_worst_case_of_a_quantile_box():
    model = linear().with_quantile(0.95)
    settings = SearchSettings(method="exact", training_samples=10)
    found = worst_case(model, settings)
    z = stats.norm.ppf(0.975)
    assert found.objective_model == pytest.approx(2.0 * z * (np.abs(FACTORS) * SD).sum())
    stated = worst_case(linear(), settings)
    assert stated.objective_model == pytest.approx(4.0 * (np.abs(FACTORS) * SD).sum())
    again = kneecore.SearchResult.from_json(found.to_json())
    assert again.to_json() == found.to_json()
    np.testing.assert_array_equal(again.model.upper, model.upper)
    assert "Bounds: the central 95 % of each distribution" in str(found)
    assert "Bounds:" not in str(stated)
    how = SamplingSettings(n_samples=200)
    np.testing.assert_array_equal(monte_carlo(model, how).y.sd, monte_carlo(linear(), how).y.sd)


def test_a_model_with_other_distributions():
    steps = Input("steps", lower=1, upper=5, integer=True)
    inputs = [
        Input("a", nominal=10.0, tolerance_percent=5),
        Input("b", lower=1.0, upper=2.0),
        steps,
    ]
    model = Model(np.sum, inputs, [Output("y")])
    other = model.with_distributions(
        {"a": ("normal", 2.0), "b": ("log-normal", None), "steps": ("normal", None)}
    )
    assert [i.distribution for i in other.inputs] == ["normal", "log-normal", "uniform"]
    assert [i.deviations for i in other.inputs] == [2.0, 3.0, None]
    assert (other.inputs[0].lower, other.inputs[0].nominal) == (9.5, 10.0)
    assert model.is_uniform
    back = other.with_distributions({"a": ("uniform", None), "b": ("uniform", None)})
    assert back.identity == model.identity
    with pytest.raises(ParameterError, match="`kinds` names 'z'; a, b, steps are allowed"):
        model.with_distributions({"z": ("normal", None)})


def test_another_distribution_is_another_study():
    """What was kept of one is not taken for the other."""
    one, two = linear(), linear([("x_0", "x_1", 0.5)])
    assert len({one.identity, two.identity, linear(distribution="triangular").identity}) == 3


def test_a_searchs_file_of_such_inputs_follows_the_schema():
    inputs = [
        Input("a", choices=[1.0, 2.2, 4.7], measurement="scale"),
        Input("b", nominal=100.0, tolerance_percent=20, distribution="truncated-normal",
              deviations=2, quantile=0.95),
        Input("c", lower=17, upper=21, integer=True),
        Input("d", lower=0.5, upper=2.0, distribution="log-normal", least=0.1, most=5.0),
        Input("e", lower=0.0, upper=1.0, distribution="triangular", mode=0.2),
    ]  # fmt: skip
    model = Model(np.sum, inputs, [Output("y")], correlation=[("b", "d", -0.4)])
    settings = SearchSettings(training_samples=7, pop_size=20, n_generations=2)
    told = check_comes_back(worst_case(model, settings))
    assert set().union(*told["model"]["inputs"]) >= {"choices", "quantile", "measurement"}

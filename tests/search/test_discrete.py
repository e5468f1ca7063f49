"""Searches where some inputs are whole numbers or choices, held against all combinations."""

import itertools
import json

import numpy as np
import pytest

from kneecore import (
    FileFormatError,
    Input,
    Model,
    Output,
    SearchResult,
    SearchSettings,
    SurrogateQualitySettings,
    fit_surrogate,
    landscape,
    surrogate_quality,
    worst_case,
    worst_case_slopes,
)

TEETH, LADDER, OFFSET = range(12, 25), (1.0, 2.2, 4.7, 10.0), range(-3, 4)


def outputs(x):
    """Return two outputs with their largest difference inside of the bounds, not in corners."""
    teeth, rung, offset = x
    return np.array(
        [-((teeth - 17.0) ** 2) / 9.0 + 3.0 * np.log(rung), (offset - 1.0) ** 2 + 0.1 * teeth]
    )


class Gears:
    """Refuses what is not allowed, and counts what is."""

    def __init__(self):
        self.seen = []

    def __call__(self, x):
        assert x[0] in TEETH
        assert x[1] in LADDER
        assert x[2] in OFFSET
        self.seen.append(tuple(x))
        return outputs(x)


def gears(run, **options):
    inputs = [
        Input("teeth", lower=12, upper=24, integer=True),
        Input("rung", choices=LADDER, unit="ohm"),
        Input("offset", nominal=0, half_range=3.2, integer=True),
    ]
    return Model(run, inputs, [Output("p"), Output("q")], **options)


@pytest.fixture(scope="module")
def brute_force():
    y = np.array([outputs(x) for x in itertools.product(TEETH, LADDER, OFFSET)])
    return max(np.ptp(y @ signs) for signs in ([1, 1], [1, -1]))


HOW = {
    "usual": None,
    "climbs": SearchSettings(method="exact", training_samples=150),
    "genetic": SearchSettings(training_samples=150, pop_size=60, n_generations=60),
    "genetic in the model": SearchSettings(search_space="model", pop_size=60, n_generations=60),
    "genetic, repaired": SearchSettings(repair=True, repair_models=60),
}


@pytest.mark.parametrize("how", HOW)
def test_the_worst_pair_is_that_of_all_combinations(how, brute_force):
    run = Gears()
    result = worst_case(gears(run), HOW[how])
    assert result.model.failures == ()
    assert result.objective_model == pytest.approx(brute_force, rel=1e-9)
    assert result.stop_reason in ("converged", "max_generations", "repaired")
    for x in result.x:
        result.model.check_allowed(x)
    again = worst_case(gears(Gears()), HOW[how])
    np.testing.assert_array_equal(again.x, result.x)
    assert SearchResult.from_json(result.to_json()).to_json() == result.to_json()


def test_no_point_is_run_twice():
    run = Gears()
    result = worst_case(gears(run))
    trained = [tuple(x) for x in result.training_x]
    again = 1 + result.repair.n_checked  # the nominal inputs, and the pair
    assert len(set(trained)) == len(trained) == result.counts["models_simulated"] - again
    assert run.seen[:-again] == trained


def test_where_there_are_few_combinations_all_are_run():
    inputs = [Input("a", choices=(1, 2, 4)), Input("b", lower=0, upper=3, integer=True)]
    model = Model(lambda x: np.sin(5.0 * x[0] * x[1]), inputs, [Output("y")])
    result = worst_case(model)
    y = [np.sin(5.0 * a * b) for a, b in itertools.product((1, 2, 4), range(4))]
    assert result.objective_model == pytest.approx(np.ptp(y))
    assert (len(result.training_x), str(result.verdict)) == (12, "Verdict: trusted.")
    flat = Model(lambda x: 1.0, inputs, [Output("y")])
    assert worst_case(flat).verdict.word == "not found"


def test_a_whole_number_beside_a_continuous_input():
    """The optimum over the continuous input is found for the right whole number."""

    def run(x):
        return np.sin(2.0 * x[0]) * (4.0 - abs(x[1] - 2.3))

    inputs = [Input("n", lower=0, upper=3, integer=True), Input("x", lower=0.0, upper=5.0)]
    result = worst_case(Model(run, inputs, [Output("y")]))
    values = [run((n, 2.3)) for n in range(4)]
    assert result.objective_model == pytest.approx(np.ptp(values), rel=2e-3)
    assert sorted(result.x[:, 0]) == sorted([float(np.argmax(values)), float(np.argmin(values))])


def test_gradients_are_none_by_whole_numbers():
    model = gears(Gears(), gradient=lambda x: np.zeros((len(x), 2, 3)))
    assert not model.has_gradient
    assert worst_case(model).settings.repair


def test_a_surrogate_is_asked_at_allowed_values():
    model = gears(Gears())
    found = surrogate_quality(model, SurrogateQualitySettings(training_samples=200, n_test=300))
    # The test points are allowed ones, most of them the surrogate's own.
    assert found.rank_f > 0.999
    trained = fit_surrogate(model, n_samples=60)
    np.testing.assert_allclose(trained.predict(trained.training_x), trained.training_y, atol=1e-8)


def test_a_slice_has_the_allowed_values():
    found = landscape(gears(Gears()), ("teeth", "rung"), n_points=9)
    assert found.y.shape == (9, 4, 2)
    assert set(found.axes[0]) <= set(TEETH)
    assert tuple(found.axes[1]) == LADDER
    again = type(found).from_json(found.to_json())
    np.testing.assert_array_equal(again.y, found.y)
    assert list(found.figures()) == ["figure_landscape"]
    wrong = json.loads(found.to_json())
    wrong["axes"][0][3] += 0.5
    with pytest.raises(FileFormatError, match=r"`axes` has .* for `teeth`; its whole number"):
        type(found).from_json(json.dumps(wrong))


def test_a_search_ends_when_all_values_are_known():
    seen = []

    def run(x):
        seen.append(tuple(x))
        return np.sin(40.0 * x).sum()

    model = Model(
        run,
        [Input("n", lower=0, upper=9, integer=True), Input("m", choices=(1, 2))],
        [Output("y")],
    )
    found = worst_case(model, SearchSettings(training_samples=6, repair_models=40))
    assert len(found.training_x) == 20  # and none of them twice
    assert len({tuple(x) for x in found.training_x.tolist()}) == 20
    assert found.verdict.word == "trusted"
    assert found.objective_model == pytest.approx(np.ptp(found.training_y))


def test_slopes_go_from_one_value_to_the_next():
    result = worst_case(gears(Gears()))
    slopes = worst_case_slopes(result).slopes
    assert (slopes[:, 0, 1] > 0.0).all()  # p grows with the rung
    assert slopes[:, 1, 0] == pytest.approx(0.1 * 6.0)  # q by 0.1 a tooth, 6 of them

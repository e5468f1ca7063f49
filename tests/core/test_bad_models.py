"""What is wrong with a model, or with a call, is told in one line that says what is allowed."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from searches import searched

from kneecore import (
    Input,
    Knee,
    KneecoreError,
    Model,
    ModelError,
    Output,
    ParameterError,
    ParameterSpace,
    SearchSettings,
    Shape,
    compare_methods,
    fit_surrogate,
    warm_up,
    with_methods,
    worst_case,
)

A, B = Input("a", lower=0.0, upper=1.0), Input("b", lower=0.0, upper=2.0)
TWO, ONE, PAIR = [A, B], [Output("y")], [Output("y", axis=(1, 2))]
QUICK = SearchSettings(training_samples=5, method="exact")


def told(call):
    """Return the one line that a call is refused with."""
    with pytest.raises(KneecoreError) as error:
        call()
    line = str(error.value)
    assert "\n" not in line
    assert len(line) < 400
    return line


def ran(run, outputs=ONE, batched=False, **options):
    return lambda: worst_case(Model(run, TWO, outputs, batched=batched, **options), QUICK)


def alternating():
    """Return a function that returns one number, then two, and so on."""
    calls = itertools.count(1)
    return lambda x: np.ones(1 + next(calls) % 2)


@pytest.mark.parametrize(
    ("run", "outputs", "said"),
    [
        (lambda x: x[:, 0], ONE, "returned shape (5,) for 5 points; (5, 1) is allowed; one output "
         "still needs its own axis: y[:, None]"),
        (lambda x: x[:, 0], PAIR, "returned shape (5,) for 5 points; (5, 2) is allowed"),
        (lambda x: x.sum(), ONE, "returned shape () for 5 points; (5, 1) is allowed"),
        (lambda x: x[:, :1], PAIR, "returned shape (5, 1) for 5 points; (5, 2) is allowed; "
         "`outputs` names 2"),
        (lambda x: x[1:, :1], ONE, "returned shape (4, 1) for 5 points; (5, 1) is allowed"),
        (lambda x: x[:, :1, None], ONE, "returned shape (5, 1, 1) for 5 points"),
        (lambda x: [[1.0, 2.0], *[[3.0]] * (len(x) - 1)], PAIR, "returned a ragged array"),
        (lambda x: 1j * x[:, :1], ONE, "returned complex numbers; real numbers are allowed"),
        (lambda x: np.ma.masked_less(x[:, :1], 0.5), ONE, "returned a masked array; NaN marks a "
         "failed run"),
    ],
)  # fmt: skip
def test_what_a_batched_model_returns(run, outputs, said):
    assert f"`run` {said}" in told(ran(run, outputs, batched=True))


@pytest.mark.parametrize(
    ("run", "outputs", "said"),
    [
        (alternating(), ONE, "returned shape (2,) for one point; (1,) is allowed; `outputs` names "
         "1"),
        (lambda x: x, ONE, "returned shape (2,) for one point; (1,) is allowed"),
        (lambda x: x[0], PAIR, "returned shape () for one point; (2,) is allowed"),
        (lambda x: [[1.0, 2.0], [3.0]], PAIR, "returned a ragged array; numbers in rows"),
        (lambda x: 1j * x[0], ONE, "returned complex numbers; real numbers are allowed"),
        (lambda x: np.ma.masked, ONE, "returned a masked array; NaN marks a failed run"),
        (lambda x: None, ONE, "returned None; an array of numbers is allowed"),
        (lambda x: "1.5", ONE, "returned '1.5'; an array of numbers is allowed"),
        (lambda x: True, ONE, "returned True; an array of numbers is allowed"),
        (lambda x: {"y": 1.0}, ONE, "returned {'y': 1.0}; an array of numbers is allowed"),
        (lambda x: 10**400, ONE, "an array of numbers is allowed"),
    ],
)  # fmt: skip
def test_what_a_model_of_one_point_returns(run, outputs, said):
    line = told(ran(run, outputs))
    assert line.startswith("`run` returned")
    assert said in line


@pytest.mark.parametrize(
    ("run", "error"),
    [
        (lambda x: math.sin(x[0]), "TypeError"),
        (lambda x: (lambda a, b: a + b)(*x), "TypeError"),
        (lambda x: x[0] if x[0] > 0.5 else x[1], "ValueError"),
        (lambda x: x[0] + x[1], None),
    ],
)
def test_a_function_of_one_point_given_as_batched(run, error):
    line = told(ran(run, batched=True))
    assert line.endswith("a function of one point at a time needs batched=False")
    assert error is None or f"`run` raised {error} (" in line
    worst_case(Model(run, TWO, ONE), QUICK)  # given as what it is, it is searched


@pytest.mark.parametrize(
    ("run", "error"),
    [
        (lambda x: x[:, :1], "IndexError"),
        (lambda x: np.sum(x, axis=1, keepdims=True), "AxisError"),
        (lambda x: np.atleast_2d(x)[:, :1], None),
    ],
)
def test_a_function_of_many_points_given_as_one_of_one(run, error):
    line = told(ran(run))
    assert line.endswith("a function of many points at once needs batched=True")
    assert error is None or f"`run` raised {error} (" in line
    worst_case(Model(run, TWO, ONE, batched=True), QUICK)


def test_a_models_own_mistake_is_not_hidden():
    with pytest.raises(ModelError) as error:
        ran(lambda x: 1 / 0)()
    told = "run 3 raised ZeroDivisionError: division by zero; all of the first 3 runs failed"
    assert str(error.value) == told
    assert isinstance(error.value.__cause__, ZeroDivisionError)
    with pytest.raises(ParameterError) as error:
        ran(lambda x: x["a"])()
    assert isinstance(error.value.__cause__, IndexError)


def test_a_model_that_changes_its_mind_has_failed_there():
    """Its first five answers are kept; of the pair, which gets another shape, no f is told: the
    best pair of the five is offered."""
    model = Model(lambda x: x[:, :1] if len(x) == 5 else x, TWO, ONE, batched=True)
    found = worst_case(model, replace(QUICK, repair=False))
    assert found.objective_model == np.ptp(found.training_y)
    assert found.verdict.word == "doubtful"
    assert found.counts["models_failed"] == 3  # the pair, and the nominal point
    assert model.failures[0].message.startswith("`run` returned shape (2, 2) for 2 points")
    assert [failure.number for failure in model.failures] == [6, 7, 8]


def test_numbers_of_any_kind_are_numbers():
    for run in (lambda x: int(x[0] > 0.5), lambda x: np.float32(x[0]), lambda x: [x[0]]):
        assert ran(run)().objective_model == 1.0


@pytest.mark.parametrize(
    "wrong",
    [[0.0, 1.0], (0.0,), {"lower": 0.0}, np.array([0.0]), "0", True, 1j, np.nan, -np.inf, 10**400],
)
@pytest.mark.parametrize("place", ["lower", "upper", "nominal", "half_range", "tolerance_percent"])
def test_bounds_are_one_finite_number_each(place, wrong):
    options = {"lower": 0.0, "upper": 1.0}
    if place in ("half_range", "tolerance_percent"):
        options = {"nominal": 1.0}
    line = told(lambda: Input("a", **options | {place: wrong}))
    assert line.startswith(f"`{place} of a` is ")
    assert line.endswith("a finite number is allowed")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({}, "the bounds of `a` are given in no way, or in several"),
        ({"nominal": 1.0}, "the bounds of `a` are given in no way"),
        ({"lower": 0.0}, "the bounds of `a` are given in no way"),
        ({"lower": 0.0, "upper": 1.0, "half_range": 1.0}, "or in several; one is needed"),
        ({"lower": 2.0, "upper": 1.0}, "`lower of a` is 2, above its `upper`, 1"),
        ({"half_range": 1.0}, "`nominal of a` is None; a number is needed"),
        ({"nominal": 1.0, "half_range": -1.0}, "`half_range of a` is -1; at least 0 is allowed"),
        ({"lower": -1e308, "upper": 1e308}, "the bounds of `a` are too wide for numbers"),
        ({"lower": 0.0, "upper": 1.0, "unit": 3}, "`unit of a` is 3; text is allowed"),
        ({"lower": 0.0, "upper": 1.0, "shown_scale": 0.0}, "`shown_scale of a` is 0; above 0"),
    ],
)
def test_an_inputs_uncertainty_is_given_in_one_way(options, said):
    assert said in told(lambda: Input("a", **options))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"axis": 3}, "`axis of y` is 3; a row of finite numbers is allowed"),
        ({"axis": []}, "`axis of y` is []; a row of finite numbers is allowed"),
        ({"axis": [[1, 2], [3]]}, "a row of finite numbers is allowed"),
        ({"axis": [1.0, np.nan]}, "a row of finite numbers is allowed"),
        ({"axis": np.zeros((40, 40))}, "a row of finite numbers is allowed"),
        ({"axis": "abc"}, "`axis of y` is 'abc'; a row of finite numbers is allowed"),
        ({"scale": 0.0}, "`scale of y` is 0; above 0 is allowed"),
        ({"scale": "3"}, "`scale of y` is '3'; a finite number is allowed"),
        ({"unit": None}, "`unit of y` is None; text is allowed"),
    ],
)
def test_an_outputs_axis_and_scale(options, said):
    assert said in told(lambda: Output("y", **options))


MM, DB = Output("place", unit="mm"), Output("gain", unit="dB")


@pytest.mark.parametrize(
    ("inputs", "outputs", "options", "said"),
    [
        ({"a": (0, 1)}, ONE, {}, "`inputs` is {'a': (0, 1)}; a list of kneecore.Input is allowed"),
        ("ab", ONE, {}, "`inputs` is 'ab'; a list of kneecore.Input is allowed"),
        (A, ONE, {}, "a list of kneecore.Input is allowed"),
        (3, ONE, {}, "`inputs` is 3; a list of kneecore.Input is allowed"),
        (np.zeros((99, 2)), ONE, {}, "a list of kneecore.Input is allowed"),
        ([(0.0, 1.0)], ONE, {}, "`inputs` has (0.0, 1.0) in it; kneecore.Inputs are allowed"),
        ([], ONE, {}, "`inputs` is empty; at least one kneecore.Input is needed"),
        ([A, B, A], ONE, {}, "`inputs` has the name 'a' twice; each needs its own"),
        (TWO, ["y"], {}, "`outputs` has 'y' in it; kneecore.Outputs are allowed"),
        (TWO, [], {}, "`outputs` is empty; at least one kneecore.Output is needed"),
        ([Input("a", lower=1.0, upper=1.0)], ONE, {}, "all bounds have zero width"),
        (TWO, [MM, DB], {}, "`outputs` have different units (dB, mm) and 'place' has no `scale`; "
         "give each the difference that counts as 1, such as Output('gain', unit='dB', scale=3)"),
        (TWO, [Output("place", unit="mm", scale=1.0), DB], {}, "and 'gain' has no `scale`"),
        (TWO, [MM, Output("ratio")], {}, "`outputs` have different units (mm, none)"),
        (TWO, ONE, {"gradient": 3}, "`gradient` is 3; a function is allowed"),
        (TWO, ONE, {"draw": "x"}, "`draw` is 'x'; a function is allowed"),
        (TWO, ONE, {"name": 3}, "`name` is 3; text is allowed"),
        (TWO, ONE, {"threads": 0}, "`threads` is 0; a whole number from 1 to 1,024 is allowed"),
        (TWO, ONE, {"batched": "yes"}, "`batched` is 'yes'; True or False is allowed"),
    ],
)  # fmt: skip
def test_what_a_model_is_made_of(inputs, outputs, options, said):
    assert said in told(lambda: Model(lambda x: x, inputs, outputs, **options))


def test_a_model_is_a_function():
    assert told(lambda: Model(3, TWO, ONE)) == "`run` is 3; a function is allowed"


def test_a_gradient_is_checked_like_the_model():
    def ones(*shape):
        return lambda x: np.ones((len(x), *shape))

    assert "(n, m, d) is allowed" in told(ran(lambda x: x[:1], gradient=ones(2)))
    complex_ = told(ran(lambda x: x[:1], gradient=lambda x: 1j * ones(1, 2)(x)))
    assert complex_ == "`gradient` returned complex numbers; real numbers are allowed"


def test_a_picture_is_made_of_shapes():
    line = Shape(name="line", points=[[0, 0], [1, 1]])
    for drawn in (3, line, [np.ones((2, 2))], [line, None]):
        model = Model(lambda x: x[:1], TWO, ONE, draw=lambda x, drawn=drawn: drawn)
        assert "a list of kneecore.Shape is allowed" in told(lambda m=model: m.draw([0.5, 0.5]))
    assert Model(lambda x: x[:1], TWO, ONE, draw=lambda x: [line]).draw([0.5, 0.5]) == (line,)
    for points in ([1.0, 2.0], np.zeros((2, 3)), "ab", [[0, 0], [1]], np.zeros((0, 2))):
        assert "`points` " in told(lambda p=points: Shape(name="line", points=p))
    assert "`kind` is 'dotted'" in told(
        lambda: Shape(name="x", points=line.points, kind="dotted"),
    )


@pytest.mark.parametrize(
    "x",
    [[1.0, 2.0], [[1.0, 2.0, 3.0]], [["a", "b"]], [[1.0, 2.0], [3.0]], [[1j, 2.0]], None, {"a": 1},
     np.ma.masked_array([[1.0, 2.0]], mask=[[True, False]]), [[True, False]]],
)  # fmt: skip
def test_points_to_evaluate(x):
    model = Model(lambda x: x[:1], TWO, ONE)
    assert told(lambda: model.evaluate(x)).startswith("`x` ")


@pytest.mark.parametrize(
    "weights",
    [(1.0, -1.0), (0.0, 0.0), (np.nan, 1.0), (1.0, np.inf), "ab", 3.0, {"y": 1.0}, [[1.0, 2.0]],
     (1j, 1.0), [True, False], [], [1.0, "a"], [1.0, [2.0]], -np.ones(500)],
)  # fmt: skip
def test_weights_are_finite_and_not_negative_and_not_all_zero(weights):
    line = told(lambda: SearchSettings(weights=weights))
    assert line.startswith("`weights` is ")
    assert line.endswith("a row of finite numbers of at least 0, one above 0, is allowed")


def test_as_many_weights_as_numbers():
    model = Model(lambda x: x, TWO, PAIR)
    line = told(lambda: worst_case(model, SearchSettings(weights=(1.0, 2.0, 3.0))))
    assert line.startswith("`weights` has shape (3,); (2,) is needed")
    found = worst_case(model, SearchSettings(weights=np.array([1, 2]), training_samples=5))
    assert found.settings.weights == (1.0, 2.0)
    line = told(lambda: searched(weights=(1.0,)))
    assert line.startswith("`weights` has shape (1,); (12,) is needed")


VERBS = {
    "worst_case": worst_case,
    "compare_methods": compare_methods,
    "warm_up": warm_up,
    "fit_surrogate": lambda model, settings=None: fit_surrogate(model),
}


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("model", [ParameterSpace(), None, 3, "knee", np.sin, Knee, [Knee]])
def test_only_a_model_can_be_searched(verb, model):
    line = told(lambda: VERBS[verb](model))
    assert line.startswith("`model` is ")
    assert line.endswith("a kneecore.Model is allowed, such as kneecore.Knee(space)")


@pytest.mark.parametrize("verb", [v for v in VERBS if v != "fit_surrogate"])
@pytest.mark.parametrize("settings", [{"seed": 1}, 3, "ga", SearchSettings, 0, ""])
def test_settings_are_settings(verb, settings):
    line = told(lambda: VERBS[verb](Knee(), settings))
    assert line.startswith("`settings` is ")
    assert line.endswith("kneecore.SearchSettings are allowed")


def test_a_callback_is_called():
    found = searched(pop_size=20, n_generations=2)
    for call in (
        lambda: worst_case(Knee(), callback=3),
        lambda: compare_methods(Knee(), callback=3),
        lambda: fit_surrogate(Knee(), callback=3),
        lambda: with_methods(found, 3),
    ):
        assert told(call).startswith("`callback` is 3; ")


@pytest.mark.parametrize("size", [0.0, -1.0, np.nan, "wide", [1.0]])
def test_a_size_is_above_zero(size):
    assert told(lambda: Model(lambda x: x, TWO, PAIR).with_size(size)).startswith("`size` is ")

"""Inputs as they are: every way to say how far they go and how likely their values are."""

import numpy as np
import pytest
from scipy import stats

from kneecore import Input, Model, Output, ParameterError

BOUNDS = {"lower": 2.0, "upper": 8.0}
CHANCES = np.array([1e-9, 0.01, 0.3, 0.5, 0.9, 0.999])


@pytest.mark.parametrize(
    ("given", "bounds", "nominal"),
    [
        ({"nominal": -20.0, "tolerance_percent": 10}, (-22.0, -18.0), -20.0),
        ({"nominal": 5, "half_range": 2}, (3.0, 7.0), 5.0),
        ({"lower": 2, "upper": 8}, (2.0, 8.0), 5.0),
        ({"nominal": 3.0, "lower": 2, "upper": 8}, (2.0, 8.0), 3.0),
        ({"lower": 1.2, "upper": 6.9, "integer": True}, (2.0, 6.0), 4.0),
        ({"nominal": 10, "tolerance_percent": 25, "integer": True}, (8.0, 12.0), 10.0),
        ({"nominal": 3, "half_range": 0.1 * 30, "integer": True}, (0.0, 6.0), 3.0),
        ({"choices": [10, 1, 2.2]}, (1.0, 10.0), 2.2),
        ({"choices": (1, 4), "nominal": 4}, (1.0, 4.0), 4.0),
        ({"lower": 2, "upper": 8, "most": 7.5}, (2.0, 7.5), 5.0),
    ],
)
def test_every_way_to_give_bounds(given, bounds, nominal):
    one = Input("k", **given)
    assert (one.box, one.nominal) == (bounds, nominal)


def test_values_that_are_allowed():
    assert Input("n", lower=-1, upper=2, integer=True).allowed == (-1.0, 0.0, 1.0, 2.0)
    assert Input("r", choices=[10, 1, 2.2]).allowed == (1.0, 2.2, 10.0)
    assert Input("k", **BOUNDS).allowed is None
    assert Input("r", choices=[10, 1]).whole
    assert not Input("r", choices=[10, 1.5]).whole


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "the bounds of `k` are given in no way, or in several; one is needed"),
        ({"lower": 1}, "the bounds of `k` are given in no way, or in several"),
        (BOUNDS | {"choices": (1, 2)}, "the bounds of `k` are given in no way, or in several"),
        ({"tolerance_percent": 5}, "`nominal of k` is None; a number is needed with a tolerance"),
        ({"lower": 8, "upper": 2}, "`lower of k` is 8, above its `upper`, 2"),
        ({"choices": ()}, "`choices of k` is (); a row of 1 to 100,000 numbers is allowed"),
        ({"choices": "12"}, "`choices of k` is '12'; a row of 1 to 100,000 numbers is allowed"),
        ({"choices": (1, "2")}, "`choices of k` is '2'; a finite number is allowed"),
        ({"choices": (1, 2, 1.0)}, "`choices of k` has 1 twice; once is enough"),
        ({"choices": (1, 2), "nominal": 3}, "`nominal of k` is 3; one of its choices is allowed"),
        ({"choices": (1, 2), "integer": True}, "`integer of k` is True; it has `choices`, which"),
        (BOUNDS | {"integer": 1}, "`integer of k` is 1; True or False is allowed"),
        (BOUNDS | {"integer": True, "nominal": 2.5}, "`nominal of k` is 2.5; a whole number bet"),
        ({"lower": 0.1, "upper": 0.9, "integer": True}, "`integer of k` is True, and between its"),
        ({"lower": 0, "upper": 1e6, "integer": True}, "`integer of k` is True, and its bounds hol"),
        (BOUNDS | {"distribution": "beta"}, "`distribution of k` is 'beta'; 'uniform' or 'normal'"),
        (BOUNDS | {"deviations": 2}, "`deviations of k` is 2; a uniform distribution has none"),
        (BOUNDS | {"distribution": "normal", "deviations": 0}, "`deviations of k` is 0; above 0"),
        (BOUNDS | {"distribution": "normal", "mode": 3}, "`mode of k` is 3; a normal distribution"),
        (BOUNDS | {"distribution": "triangular", "mode": 9}, "`mode of k` is 9; a value from 2 to"),
        (
            {"nominal": 0.0, "half_range": 1.0, "distribution": "log-normal"},
            "`distribution of k` is 'log-normal' and its lower bound -1; above 0 is needed",
        ),
        (BOUNDS | {"quantile": 1}, "`quantile of k` is 1; above 0 and below 1 is allowed"),
        (BOUNDS | {"least": 9}, "`least` and `most` of k leave nothing between its bounds, 2 and"),
        (
            {"choices": (1, 2), "distribution": "normal"},
            "`distribution of k` is 'normal'; whole numbers and choices have none: each is as",
        ),
        (
            BOUNDS | {"integer": True, "quantile": 0.5},
            "`quantile of k` is 0.5; whole numbers and choices have none",
        ),
    ],
)
def test_what_is_not_allowed_is_told_in_one_line(given, said):
    with pytest.raises(ParameterError) as error:
        Input("k", **given)
    assert str(error.value).startswith(said)
    assert "\n" not in str(error.value)


LIKELY = {
    "uniform": ({}, stats.uniform(2.0, 6.0)),
    "normal": ({}, stats.norm(5.0, 1.0)),
    "truncated-normal": (
        {"deviations": 1.5},
        stats.truncnorm(-1.5, 1.5, loc=5.0, scale=2.0),
    ),
    "log-normal": (
        {"deviations": 2},
        stats.lognorm(np.log(4.0) / 4.0, scale=4.0),
    ),
    "triangular": ({"mode": 3.0}, stats.triang(1.0 / 6.0, loc=2.0, scale=6.0)),
}
"""What each distribution of an input from 2 to 8 is, in SciPy's words."""


@pytest.mark.parametrize("kind", LIKELY)
def test_a_distribution_is_that_of_scipy(kind):
    options, truth = LIKELY[kind]
    one = Input("k", distribution=kind, **BOUNDS, **options)
    np.testing.assert_allclose(one.drawn.quantile(CHANCES), truth.ppf(CHANCES), rtol=1e-9)
    box = Input("k", distribution=kind, quantile=0.9, **BOUNDS, **options).box
    np.testing.assert_allclose(box, truth.interval(0.9), rtol=1e-9)


def test_a_distribution_ends_where_nothing_is_possible():
    one = Input("k", distribution="normal", least=4.0, **BOUNDS)
    truth = stats.truncnorm(-1.0, np.inf, loc=5.0, scale=1.0)
    np.testing.assert_allclose(one.drawn.quantile(CHANCES), truth.ppf(CHANCES), rtol=1e-9)
    assert np.isfinite(one.drawn.quantile([0.0, 1.0])).all()


def test_wider_and_narrower_inputs():
    one = Input("k", distribution="triangular", mode=4.0, **BOUNDS).widened(0.5)
    assert (one.lower, one.upper, one.mode) == (3.5, 6.5, 4.5)
    assert Input("n", lower=0, upper=9, integer=True).widened(0.5).allowed == (
        2.0,
        3.0,
        4.0,
        5.0,
        6.0,
    )
    assert Input("r", choices=(1, 2, 5, 10), nominal=2).widened(0.5).allowed == (2.0, 5.0)
    half = Input("k", nominal=100.0, tolerance_percent=10, distribution="normal")
    assert half.with_quantile(0.9).tolerance_percent == 10
    assert half.with_quantile(0.9).with_quantile(None) == half


INPUTS = [
    Input("a", distribution="normal", **BOUNDS),
    Input("held", lower=1.0, upper=1.0),
    Input("b", distribution="log-normal", deviations=2, **BOUNDS),
    Input("n", lower=1, upper=4, integer=True),
]


def model(correlation=None, inputs=INPUTS):
    return Model(lambda x: x.sum(), inputs, [Output("y")], correlation=correlation)


def test_correlated_samples_have_scipys_moments():
    one = model([("a", "b", 0.6), ("n", "a", -0.5), ("a", "held", 0.1)])
    assert one.drawn_as == (
        "1 normal with bounds at 3 sd, 1 log-normal with bounds at 2 sd, 1 uniform, correlated"
    )
    x = one.drawn(np.random.default_rng(1).random((40_000, 3)))
    a, held, b, n = x.T
    assert (held == 1.0).all()
    assert abs(a.mean() - 5.0) < 0.02
    assert abs(a.std() - 1.0) < 0.02
    assert stats.kstest(b, LIKELY["log-normal"][1].cdf).statistic < 0.01
    np.testing.assert_allclose(np.bincount(n.astype(int))[1:] / len(n), 0.25, atol=0.01)
    # Pearson's correlation of the normal scores, and Spearman's that follows from it.
    assert abs(np.corrcoef(a, np.log(b))[0, 1] - 0.6) < 0.01
    assert abs(stats.spearmanr(a, b).statistic - 6.0 / np.pi * np.arcsin(0.3)) < 0.01
    wanted = stats.multivariate_normal([0, 0], [[1, -0.5], [-0.5, 1]]).cdf([0, 0])
    assert abs(((a < 5.0) & (n <= 2)).mean() - wanted) < 0.01


def test_a_matrix_says_the_same_as_pairs():
    u = np.random.default_rng(1).random((50, 3))
    matrix = np.eye(4)
    matrix[0, 2] = matrix[2, 0] = 0.6
    np.testing.assert_array_equal(model(matrix).drawn(u), model([("b", "a", 0.6)]).drawn(u))
    # A row does not depend on the others, nor a batch on its size.
    np.testing.assert_array_equal(model(matrix).drawn(u)[7], model(matrix).drawn(u[7]))
    assert model(np.eye(4)).correlation is None


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("a", "`correlation` is not an array of numbers; a matrix of shape (4, 4), or a list of"),
        (np.eye(3), "`correlation` has shape (3, 3); a matrix of shape (4, 4), or a list of"),
        (2.0 * np.eye(4), "`correlation` is no correlation matrix; a symmetric one of numbers"),
        (np.triu(np.ones((4, 4))), "`correlation` is no correlation matrix; a symmetric one"),
        ([("a", "c", 0.5)], "`correlation` has ('a', 'c', 0.5) in it; (input, input, number) with"),
        ([("a", "a", 0.5)], "`correlation` has ('a', 'a', 0.5) in it; (input, input, number)"),
        ([("a", "b")], "`correlation` has ('a', 'b') in it; (input, input, number) with"),
        ([("a", "b", 0.5), ("b", "a", 0.5)], "`correlation` has 'b' with 'a' twice"),
        ([("a", "b", 1.5)], "`correlation of a and b` is 1.5; a finite number from -1 to 1 is"),
        ([("a", "b", 1)], "`correlation` is not positive definite (its least eigenvalue is 0)"),
        (
            [("a", "b", 0.9), ("b", "n", 0.9), ("a", "n", -0.9)],
            "`correlation` is not positive definite (its least eigenvalue is -0.8",
        ),
    ],
)
def test_what_is_no_correlation(given, said):
    with pytest.raises(ParameterError) as error:
        model(given)
    assert str(error.value).startswith(said)
    assert "\n" not in str(error.value)


def test_what_is_allowed_goes_to_the_cube_and_back():
    one = model(inputs=[Input("n", lower=-3, upper=3, integer=True), Input("r", choices=(1, 5, 7))])
    n, r = (x.ravel() for x in np.meshgrid(np.arange(-3, 4), (1, 5, 7)))
    x = np.stack([n, r], axis=1).astype(float)
    u = one.to_free_unit(x)
    assert (u.min(), u.max()) == (0.0, 1.0)
    np.testing.assert_array_equal(one.from_free_unit(u), x)
    np.testing.assert_array_equal(one.snapped(u), u)
    drawn = one.from_free_unit(np.random.default_rng(0).random((21_000, 2)))
    found, counts = np.unique(drawn, axis=0, return_counts=True)
    assert len(found) == 21
    assert counts.min() > 850  # of 1,000: each is as likely as another
    with pytest.raises(ParameterError, match=r"`x` has 2\.5 for `n`; its whole numbers"):
        one.evaluate([[2.5, 5.0]])
    with pytest.raises(ParameterError, match="`x` has 2 for `r`; its choices are allowed"):
        one.evaluate([[2.0, 2.0]])

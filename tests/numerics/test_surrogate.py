"""The surrogate: SciPy's numbers, its own gradient and errors."""

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator

from kneecore.errors import ModelError, ParameterError
from kneecore.numerics.surrogate import Surrogate


def data(n=60, d=28, m=12, seed=0):
    rng = np.random.default_rng(seed)
    points = rng.random((n, d))
    values = np.sin(points @ rng.normal(size=(d, m))) * 50.0
    return points, values, rng.random((300, d))


def scipy_of(points, values):
    return RBFInterpolator(points, values, kernel="thin_plate_spline", degree=1)


@pytest.mark.parametrize(
    ("n", "d", "m"), [(60, 28, 12), (50, 28, 12), (29, 28, 12), (33, 6, 12), (7, 2, 1), (400, 5, 3)]
)
def test_values_are_scipys(n, d, m):
    points, values, queries = data(n, d, m)
    surrogate = Surrogate.fit(points, values)
    assert (surrogate.n_dimensions, surrogate.n_values) == (d, m)
    np.testing.assert_allclose(
        surrogate(queries), scipy_of(points, values)(queries), atol=1e-9, rtol=1e-12
    )


def test_training_values_are_met():
    points, values, _ = data()
    np.testing.assert_allclose(Surrogate.fit(points, values)(points), values, atol=1e-9)


def test_values_far_outside_of_the_cube_are_scipys():
    points, values, queries = data(40, 4, 2)
    far = 10.0 * (queries - 0.5)
    np.testing.assert_allclose(
        Surrogate.fit(points, values)(far), scipy_of(points, values)(far), rtol=1e-11, atol=1e-9
    )


def test_gradient_against_central_differences():
    points, values, queries = data(50, 9, 3)
    surrogate = Surrogate.fit(points, values)
    queries, h = queries[:20], 1e-6
    steps = h * np.eye(9)
    differences = np.stack(
        [(surrogate(queries + step) - surrogate(queries - step)) / (2 * h) for step in steps],
        axis=2,
    )
    gradient = surrogate.gradient(queries)
    assert gradient.shape == (20, 3, 9)
    np.testing.assert_allclose(gradient, differences, atol=1e-5 * np.abs(differences).max())


def test_gradient_at_a_centre_is_finite():
    points, values, _ = data(40, 5, 2)
    surrogate = Surrogate.fit(points, values)
    at, near = surrogate.gradient(points[:3]), surrogate.gradient(points[:3] + 1e-9)
    np.testing.assert_allclose(at, near, atol=1e-4)


@pytest.mark.parametrize("n", [31, 50])
def test_leave_one_out_errors_are_those_of_refitting(n):
    points, values, _ = data(n)
    errors = Surrogate.fit(points, values).loo_errors
    for k in (0, 7, n - 1):
        rest = np.arange(n) != k
        refit = scipy_of(points[rest], values[rest])(points[k : k + 1])[0] - values[k]
        np.testing.assert_allclose(errors[k], refit, rtol=1e-7, atol=1e-8)


def test_leave_one_out_is_unknown_where_the_rest_determines_no_spline():
    points, values, _ = data(29)
    assert np.isnan(Surrogate.fit(points, values).loo_errors).all()


@pytest.mark.parametrize("batch", [1, 5, 64, 96, 100])
def test_batch_size_changes_no_bit(batch):
    points, values, queries = data()
    surrogate = Surrogate.fit(points, values)
    parts = [surrogate(queries[k : k + batch]) for k in range(0, len(queries), batch)]
    assert np.vstack(parts).tobytes() == surrogate(queries).tobytes()


def test_fits_do_not_depend_on_blas_threads():
    from threadpoolctl import threadpool_limits

    points, values, _ = data(400, 28, 12)
    weights = []
    for threads in (1, 2):
        with threadpool_limits(threads, user_api="blas"):
            weights.append(Surrogate.fit(points, values).weights.tobytes())
    assert weights[0] == weights[1]


@pytest.mark.parametrize(
    ("points", "values", "error", "said"),
    [
        (np.zeros((28, 28)), np.zeros((28, 1)), ParameterError, "28 rows; .* at least 29"),
        (np.zeros((4, 2)), np.zeros((5, 1)), ParameterError, "shapes"),
        (np.zeros(4), np.zeros(4), ParameterError, "shapes"),
        (np.full((4, 2), np.nan), np.zeros((4, 1)), ParameterError, "not finite"),
        (np.ones((9, 2)), np.zeros((9, 1)), ModelError, "do not determine a surrogate"),
    ],
)
def test_what_cannot_be_fitted_is_named(points, values, error, said):
    with pytest.raises(error, match=said):
        Surrogate.fit(points, values)


def test_a_wrong_query_is_named():
    points, values, _ = data(40, 5, 2)
    with pytest.raises(ParameterError, match=r"`points` has shape \(3, 4\); \(n, 5\) is allowed"):
        Surrogate.fit(points, values)(np.zeros((3, 4)))

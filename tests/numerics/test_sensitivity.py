"""Sobol' indices of functions whose indices are known."""

import numpy as np
import pytest
import scipy.stats

from kneecore.errors import ModelError
from kneecore.numerics.sensitivity import _estimate, _Rows, sobol_indices


def ishigami(u):
    x = np.pi * (2.0 * u - 1.0)
    return (np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0]))[
        :, None
    ]


def ishigami_indices(a=7.0, b=0.1):
    """Analytic indices; a fourth input does nothing."""
    one = 0.5 * (1.0 + b * np.pi**4 / 5.0) ** 2
    two = a**2 / 8.0
    both = b**2 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    whole = one + two + both
    return np.array([one, two, 0.0, 0.0]) / whole, np.array([one + both, two, both, 0.0]) / whole


A = np.array([0.0, 0.5, 3.0, 9.0, 99.0])


def g_function(u):
    return np.prod((np.abs(4.0 * u - 2.0) + A) / (1.0 + A), axis=1, keepdims=True)


def g_indices():
    parts = 1.0 / (3.0 * (1.0 + A) ** 2)
    whole = np.prod(1.0 + parts) - 1.0
    return parts / whole, parts * np.prod(1.0 + parts) / (1.0 + parts) / whole


def test_ishigami_with_a_dummy():
    found = sobol_indices(ishigami, 4, n_base=4096, n_resamples=200)
    first, total = ishigami_indices()
    np.testing.assert_allclose(found.first_order[0], first, atol=0.02)
    np.testing.assert_allclose(found.total_order[0], total, atol=0.02)
    assert found.total_order[0, 3] == pytest.approx(0.0, abs=1e-12)
    assert found.n_evaluations == 4096 * 6


def test_g_function():
    found = sobol_indices(g_function, 5, n_base=4096)
    first, total = g_indices()
    np.testing.assert_allclose(found.first_order[0], first, atol=0.02)
    np.testing.assert_allclose(found.total_order[0], total, atol=0.02)
    assert found.first_order_interval is None


def test_intervals_cover_the_truth_about_as_often_as_they_say():
    first, total = g_indices()
    hits = []
    for seed in range(40):
        found = sobol_indices(g_function, 5, n_base=256, seed=seed, n_resamples=100)
        for truth, interval in (
            (first, found.first_order_interval),
            (total, found.total_order_interval),
        ):
            hits.append((interval[0, 0] <= truth) & (truth <= interval[1, 0]))
    # 400 intervals of 95 %; Sobol' points scatter less than the resampling believes.
    assert 0.90 <= np.mean(hits) <= 1.0
    width = np.diff(found.first_order_interval[:, 0, 0], axis=0)
    assert 0.01 < width[0] < 0.5


def test_several_outputs_and_a_constant_one():
    def model(u):
        return np.column_stack([u[:, 0], np.full(len(u), 3.0), u[:, 0] + u[:, 1]])

    found = sobol_indices(model, 2, n_base=512, n_resamples=20)
    np.testing.assert_array_equal(found.constant, [False, True, False])
    np.testing.assert_allclose(found.first_order[0], [1.0, 0.0], atol=0.01)
    assert np.isnan(found.first_order[1]).all()
    assert np.isnan(found.total_order_interval[:, 1]).all()
    np.testing.assert_allclose(found.first_order[2], [0.5, 0.5], atol=0.02)


def test_batches_change_no_bit_and_the_size_is_rounded_up():
    one = sobol_indices(g_function, 5, n_base=200, batch=16, n_resamples=5)
    two = sobol_indices(g_function, 5, n_base=256, batch=64, n_resamples=5)
    assert one.n_base == 256
    assert one.first_order.tobytes() == two.first_order.tobytes()
    assert one.total_order_interval.tobytes() == two.total_order_interval.tobytes()


def test_rows_with_a_failure_are_replaced_and_counted():
    def holes(u):
        return np.where((u[:, 0] > 0.97)[:, None], np.nan, u @ [[1.0], [1.0]])

    found = sobol_indices(holes, 2, n_base=512)
    assert found.n_failed_rows > 0
    assert found.n_base == 512
    np.testing.assert_allclose(found.first_order[0], [0.5, 0.5], atol=0.1)


def test_mostly_failures_are_an_error():
    with pytest.raises(ModelError, match="hold a failed model"):
        sobol_indices(lambda u: np.full((len(u), 1), np.nan), 2, n_base=64)


def test_it_can_be_cancelled():
    with pytest.raises(InterruptedError):
        sobol_indices(g_function, 5, n_base=256, callback=lambda done, total: done >= 128)


def test_an_output_that_fails_in_some_rows_loses_those_rows_alone():
    def gappy(u):
        y = np.column_stack([u[:, 0] + u[:, 1], u[:, 1], np.full(len(u), np.nan), u[:, 0]])
        y[u[:, 0] > 0.9, 0] = np.nan
        return y

    found = sobol_indices(gappy, 2, n_base=512, n_resamples=20)
    alone = sobol_indices(lambda u: u[:, 1:2], 2, n_base=512, n_resamples=20)
    assert found.n_failed_rows == 0
    assert found.n_used.tolist()[1:] == [512, 0, 512]
    assert 300 < found.n_used[0] < 480
    assert found.unknown.tolist() == [False, False, True, False]
    assert not found.constant.any()
    np.testing.assert_array_equal(found.total_order[1], alone.total_order[0])
    np.testing.assert_array_equal(
        found.total_order_interval[:, 1], alone.total_order_interval[:, 0]
    )
    assert np.isnan(found.total_order[2]).all()
    # x_1 up to 0.9 alone: 0.81 of the other's variance.
    np.testing.assert_allclose(found.total_order[0], [0.81 / 1.81, 1.0 / 1.81], atol=0.05)


def test_the_estimators_are_those_of_scipy():
    """Three inputs, two outputs."""
    rng = np.random.default_rng(0)
    f_a, f_b, f_ab = rng.random((64, 2)), rng.random((64, 2)), rng.random((64, 3, 2))
    sampled = scipy.stats.sobol_indices(
        func={"f_A": f_a.T, "f_B": f_b.T, "f_AB": f_ab.transpose(1, 2, 0)}, n=64
    )
    first, total = _estimate(_Rows(f_a, f_b, f_ab))
    np.testing.assert_allclose(first, sampled.first_order, rtol=1e-12)
    np.testing.assert_allclose(total, sampled.total_order, rtol=1e-12)

"""The Gaussian process: through its points, with its own derivatives and left-out errors."""

import numpy as np
import pytest

from kneecore.numerics.kriging import Kriging, _loss, likely

RNG = np.random.default_rng(0)
X = RNG.random((40, 3))
Z = np.sin(5.0 * X[:, 0]) + X[:, 1] ** 2
THETA = np.log([0.4, 0.9, 20.0, 1e-8])


@pytest.fixture(scope="module")
def process():
    return Kriging(X, Z, THETA)


def test_it_goes_through_its_points_and_is_sure_there(process):
    mean, sd, *_ = process(X)
    np.testing.assert_allclose(mean, Z, atol=1e-5)
    assert sd.max() < 0.01 * process(np.array([[1.0, 0.0, 1.0]]))[1][0]


def test_its_derivatives_are_those_of_differences(process):
    u, h = RNG.random((5, 3)), 1e-6
    slopes = process(u)[2:]
    for k in range(3):
        ahead, behind = (process(u + s * h * np.eye(3)[k])[:2] for s in (1.0, -1.0))
        for one, two, slope in zip(ahead, behind, slopes, strict=True):
            np.testing.assert_allclose((one - two) / (2.0 * h), slope[:, k], atol=1e-4)


def test_the_likelihoods_derivatives_are_those_of_differences():
    z, h = (Z - Z.min()) / np.ptp(Z), 1e-6
    slope = _loss(THETA, X, z)[1]
    for k in range(4):
        step = h * np.eye(4)[k]
        told = (_loss(THETA + step, X, z)[0] - _loss(THETA - step, X, z)[0]) / (2.0 * h)
        assert told == pytest.approx(slope[k], rel=1e-3, abs=1e-3)


def test_left_out_errors_are_those_of_a_process_without_the_point(process):
    """With the mean of the whole: leaving a point out moves it a little."""
    for k in (0, 7):
        rest = np.arange(len(X)) != k
        without = Kriging(X[rest], Z[rest], THETA)(X[k : k + 1])[0][0] - Z[k]
        assert process.loo_errors[k] == pytest.approx(without, rel=0.05, abs=1e-3)


def test_an_input_without_effect_gets_a_long_length():
    lengths = np.exp(likely(X, Z)[:-1])
    assert lengths[2] > 5.0 * max(lengths[:2])


def test_noise_gets_a_nugget():
    x = RNG.random((120, 1))
    z = np.sin(5.0 * x[:, 0])
    noisy = z + 0.3 * RNG.standard_normal(len(z))
    assert np.exp(likely(x, noisy)[-1]) > 1e3 * np.exp(likely(x, z)[-1])


def test_huge_numbers_and_close_points():
    x = np.vstack([X, X[:1] + 1e-9])
    z = 1e200 * np.append(Z, Z[0])
    mean, sd, *_ = Kriging(x, z, likely(x, z))(X)
    np.testing.assert_allclose(mean, 1e200 * Z, rtol=1e-2, atol=1e198)
    assert np.isfinite(sd).all()

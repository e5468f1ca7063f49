"""Exact gradients of the equilibrium angles: against differences, and where they must vanish."""

import numpy as np
import pytest

from kneecore import NAMES, ParameterError, ParameterSpace, flexion_gradient, simulate_batch

SPACE = ParameterSpace()
WIDTH = SPACE.upper - SPACE.lower


def knees(n, seed=0):
    return SPACE.from_unit(np.random.default_rng(seed).random((n, 28)))


def differences(x, rest_length, share=1e-4):
    """Central differences of fourth order, shape (12, 28)."""
    h = share * WIDTH
    shifts = np.array([1.0, -1.0, 2.0, -2.0])
    X = x + (shifts[:, None, None] * np.diag(h)).reshape(-1, 28)
    f = simulate_batch(
        X, baseline=SPACE.baseline, rest_length=rest_length, solver="equilibrium"
    ).flexion.reshape(4, 28, 12)
    return ((8.0 * (f[0] - f[1]) - (f[2] - f[3])) / (12.0 * h[:, None])).T


@pytest.mark.parametrize("rest_length", ["recomputed", "fixed"])
def test_equal_to_central_differences(rest_length):
    X = knees(12, 1)
    exact = flexion_gradient(X, rest_length=rest_length)
    for i, x in enumerate(X):
        off = np.abs(exact[i] - differences(x, rest_length)) * WIDTH
        largest = (np.abs(exact[i]) * WIDTH).max(axis=1, keepdims=True)
        assert (off / largest).max() < 1e-6


def test_no_parameter_is_without_effect():
    effect = np.abs(flexion_gradient(knees(30, 2)) * WIDTH).max(axis=(0, 1))
    assert effect.min() > 1e-6, NAMES[int(np.argmin(effect))]


def test_moving_the_whole_knee_changes_no_angle():
    """All points of the femur shifted, and all of the tibia as much in the load-free pose."""
    shift = np.zeros(28)
    shift[[0, 4, 8, 12, 16]] = 1.0  # all of the femur, anteriorly
    sample = knees(5, 3)
    moved = flexion_gradient(sample, rest_length="recomputed") @ shift
    c, s = np.cos(np.radians(54.79)), np.sin(np.radians(54.79))
    back = np.zeros(28)
    for k in (2, 6, 10, 14, 19):
        back[k], back[k + 1] = c, s
    both = flexion_gradient(sample, rest_length="recomputed") @ (shift + back)
    assert np.abs(both).max() < 1e-6 * np.abs(moved).max()


def test_scaling_all_stiffnesses_is_scaling_the_moment():
    """Angles depend on stiffness over moment: a difference in the moment gives the derivative."""
    x = knees(1, 4)[0]
    stiff = np.zeros(28)
    stiff[22:27] = x[22:27]  # Young's modulus too
    by_stiffness = flexion_gradient(x) @ stiff
    h = 1e-4
    double = simulate_batch(
        np.stack([x + h * stiff, x - h * stiff]), baseline=SPACE.baseline, solver="equilibrium"
    ).flexion
    np.testing.assert_allclose(by_stiffness, (double[0] - double[1]) / (2 * h), rtol=1e-5)
    # Stiffer knees turn less: back towards 54.79 deg.
    assert (by_stiffness[:6] > 0).all()
    assert (by_stiffness[6:] < 0).all()


def test_bits_do_not_depend_on_threads_or_batches():
    X = knees(50, 5)
    whole = flexion_gradient(X, threads=1)
    assert whole.shape == (50, 12, 28)
    assert flexion_gradient(X, threads=2).tobytes() == whole.tobytes()
    assert flexion_gradient(X[7]).tobytes() == whole[7].tobytes()


def test_a_lost_knee_has_no_gradient():
    x = SPACE.baseline.copy()
    x[NAMES.index("pcl_stiffness")] = 0.0
    both = flexion_gradient(np.stack([x, SPACE.baseline]))
    assert np.isnan(both[0]).all()
    assert np.isfinite(both[1]).all()


def test_refused_arguments():
    with pytest.raises(ParameterError, match="`x` has shape"):
        flexion_gradient(np.zeros(27))
    with pytest.raises(ParameterError, match="`rest_length` is 'none'"):
        flexion_gradient(SPACE.baseline, rest_length="none")

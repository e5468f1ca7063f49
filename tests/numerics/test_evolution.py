"""The separable evolution strategy: known maxima, failures, the same points for the same seed."""

import numpy as np

from kneecore.numerics.evolution import evolve_abreast


def evolved(objective, start, **changes):
    settings = {"pop_size": 24, "n_generations": 120, "step": 0.3} | changes
    return evolve_abreast(objective, start, rng=np.random.default_rng(1), **settings)


def test_two_maxima_abreast_inside_and_on_the_bounds():
    targets = np.array([np.linspace(0.1, 0.9, 8), np.linspace(-0.5, 1.5, 8)])
    stretch = np.geomspace(1.0, 100.0, 8)

    def objective(u):
        return -(stretch * (u - targets[:, None]) ** 2).sum(axis=2)

    found = evolved(objective, np.full((2, 8), 0.5))
    np.testing.assert_allclose(found.u, np.clip(targets, 0.0, 1.0), atol=1e-3)
    np.testing.assert_allclose(found.values, objective(found.u[:, None])[:, 0])


def test_failures_are_never_the_best():
    def objective(u):
        values = u.sum(axis=2)
        return np.where(u[..., 0] > 0.5, -np.inf, values)

    found = evolved(objective, np.full((1, 3), 0.2))
    assert found.u[0, 0] <= 0.5
    assert found.values[0] > 2.4


def test_where_all_fail_the_start_is_returned():
    start = np.full((1, 3), 0.25)
    found = evolved(lambda u: np.full(u.shape[:2], -np.inf), start, n_generations=3)
    np.testing.assert_array_equal(found.u, start)
    assert np.isneginf(found.values).all()


def test_the_same_state_gives_the_same_points():
    def objective(u):
        return -((u - 0.3) ** 2).sum(axis=2)

    start = np.full((2, 5), 0.5)
    one, two = evolved(objective, start), evolved(objective, start)
    np.testing.assert_array_equal(one.u, two.u)

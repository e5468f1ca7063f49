"""The pair objective: the fused search against the general one."""

import numpy as np
import pytest

from kneecore.numerics.genetic import Fused, maximize
from kneecore.numerics.pair import ModelPair, SurrogatePair
from kneecore.numerics.surrogate import Surrogate


@pytest.fixture(scope="module")
def surrogate():
    rng = np.random.default_rng(0)
    points = rng.random((40, 7))
    return Surrogate.fit(points, 30.0 * np.sin(points @ rng.normal(size=(7, 5))))


@pytest.mark.parametrize("weights", [np.ones(5), np.array([1.0, 0.0, 0.0, 2.0, 0.0])])
def test_single_precision_is_close_to_the_model_pair(surrogate, weights):
    pairs = np.random.default_rng(1).random((250, 14))
    fast, slow = SurrogatePair(surrogate, weights), ModelPair(surrogate, weights)
    np.testing.assert_allclose(fast(pairs), slow(pairs), rtol=1e-5, atol=1e-4)
    exact = [fast.exact(pair) for pair in pairs[:10]]
    np.testing.assert_allclose(exact, slow(pairs[:10]), rtol=1e-13)


def test_a_pair_of_the_same_model_differs_by_nothing(surrogate):
    u = np.random.default_rng(2).random((20, 7))
    f = SurrogatePair(surrogate, np.ones(5))(np.hstack([u, u]))
    np.testing.assert_allclose(f, 0.0, atol=1e-5)


def test_the_fused_search_gives_the_bytes_of_the_general_one(surrogate):
    fused = SurrogatePair(surrogate, np.ones(5))
    assert isinstance(fused, Fused)
    bounds = np.zeros(14), np.ones(14)
    one = maximize(fused, *bounds, pop_size=60, n_generations=90, seed=3)
    two = maximize(lambda x: fused(x), *bounds, pop_size=60, n_generations=90, seed=3)
    assert one.x.tobytes() == two.x.tobytes()
    assert one.history.tobytes() == two.history.tobytes()
    assert one.n_evaluations == two.n_evaluations


def test_a_fused_search_can_be_cancelled(surrogate):
    result = maximize(
        SurrogatePair(surrogate, np.ones(5)),
        np.zeros(14),
        np.ones(14),
        pop_size=20,
        n_generations=200,
        callback=lambda generation, best: generation >= 50,
    )
    assert result.stop_reason == "cancelled"
    assert len(result.history) == 51


def test_a_failed_model_is_worth_minus_infinity():
    def model(x):
        return np.where(x > 0.5, np.nan, x)

    values = ModelPair(model, np.ones(1))(np.array([[0.1, 0.4], [0.1, 0.9], [0.8, 0.9]]))
    np.testing.assert_allclose(values, [0.3, -np.inf, -np.inf])

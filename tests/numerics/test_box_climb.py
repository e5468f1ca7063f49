"""Climbs over the unit cube: known maxima, on bounds and inside, each by itself."""

import numpy as np
import pytest

from kneecore.numerics.box_climb import climb, polish

D, M = 6, 3


def quadratics(seed, inside=0):
    """Concave y_j(u) = -(u - c)' A (u - c) / 2; the first `inside` inputs peak inside the cube."""
    rng = np.random.default_rng(seed)
    centres = np.where(rng.random((M, D)) < 0.5, -0.5, 1.5)
    centres[:, :inside] = rng.uniform(0.2, 0.8, inside)
    mixed = rng.normal(size=(D, D)) * 0.1
    A = np.eye(D) + mixed @ mixed.T

    def slopes(u, w):
        away = u[:, None] - centres
        y = -0.5 * np.einsum("njd,de,nje->nj", away, A, away)
        g = -np.einsum("nj,njd,de->ne", w, away, A)
        return (w * y).sum(axis=1), g, y

    return slopes


@pytest.mark.parametrize("inside", [0, 1, 3])
@pytest.mark.parametrize("seed", range(4))
def test_maxima_satisfy_the_first_order_conditions(seed, inside):
    slopes = quadratics(seed, inside)
    rng = np.random.default_rng(seed)
    weights = np.tile(np.eye(M), (5, 1))
    ends = climb(slopes, rng.random((len(weights), D)), weights)
    for u, w in zip(ends.u, weights, strict=True):
        end = polish(slopes, u, w)
        u, g = end.u[0], end.gradients[0]
        within = (u > 0.0) & (u < 1.0)
        assert np.abs(g[within]).max(initial=0.0) < 1e-8
        assert (g[u == 0.0] <= 0.0).all()
        assert (g[u == 1.0] >= 0.0).all()
        # The function is concave: this is the maximum.
        u_all = rng.random((2000, D))
        assert slopes(u_all, np.tile(w, (2000, 1)))[0].max() <= end.values[0]


def test_climbs_do_not_look_at_each_other():
    slopes, rng = quadratics(3, 2), np.random.default_rng(0)
    starts, weights = rng.random((20, D)), rng.normal(size=(20, M))
    together = climb(slopes, starts, weights)
    alone = climb(slopes, starts[7:8], weights[7:8])
    np.testing.assert_allclose(together.u[7], alone.u[0], rtol=0, atol=1e-12)
    assert together.n_evaluations > alone.n_evaluations


def test_inputs_that_peak_inside_take_fewer_steps_than_halving():
    slopes, weights = quadratics(0, 3), np.tile(np.eye(M), (5, 1))
    ends = climb(slopes, np.random.default_rng(0).random((len(weights), D)), weights)
    assert ends.n_evaluations < 19 * len(weights)  # 21 if the zeros of the slopes are not used


def test_values_never_fall():
    def bumpy(u, w):
        y = np.sin(9.0 * u).sum(axis=1, keepdims=True)
        return (w * y).sum(axis=1), w * 9.0 * np.cos(9.0 * u), y

    starts = np.random.default_rng(1).random((50, D))
    before = bumpy(starts, np.ones((50, 1)))[0]
    ends = climb(bumpy, starts, np.ones((50, 1)))
    assert (ends.values >= before).all()
    assert ends.values.max() == pytest.approx(D, abs=1e-3)


def test_a_failure_is_walked_around_or_stood_still_on():
    def holed(u, w):
        y = u.sum(axis=1, keepdims=True)
        lost = u[:, 0] > 0.7
        return np.where(lost, -np.inf, (w * y).sum(axis=1)), np.where(lost[:, None], 0.0, w), y

    starts = np.full((2, D), 0.5)
    starts[1, 0] = 0.9
    ends = climb(holed, starts, np.ones((2, 1)))
    assert ends.values[0] > 0.5 * D
    assert ends.u[0, 0] <= 0.7
    assert ends.values[1] == -np.inf


def test_inputs_without_effect_end_in_the_middle():
    def first_only(u, w):
        g = np.zeros_like(u)
        g[:, 0] = w[:, 0]
        return w[:, 0] * u[:, 0], g, u[:, :1]

    end = polish(first_only, np.array([1.0, 0.1, 0.9, 0.3]), np.ones(1))
    assert end.u[0].tolist() == [1.0, 0.5, 0.5, 0.5]

"""The sampled bound, against brute force where the true maximum is known."""

import numpy as np
import pytest

from kneecore.errors import ModelError
from kneecore.search.sampled_bound import bound_half, bound_pair


def _slopes(function, jacobian):
    def slopes(u, w):
        y = function(u)
        return (w * y).sum(1), np.einsum("nk,nkd->nd", w, jacobian(u)), y

    return slopes


def _monotone(u):
    return np.stack([u[:, 0] ** 3 + 2.0 * u[:, 0] - u[:, 1], u[:, 1] + u[:, 2] ** 2], axis=1)


def _monotone_slopes(u):
    zero, one = np.zeros(len(u)), np.ones(len(u))
    first = np.stack([3.0 * u[:, 0] ** 2 + 2.0, -one, zero], axis=1)
    return np.stack([first, np.stack([zero, one, 2.0 * u[:, 2]], axis=1)], axis=1)


def _ishigami(u):
    x = np.pi * (2.0 * u - 1.0)
    s = np.sin(x)
    return (s[:, 0] + 7.0 * s[:, 1] ** 2 + 0.1 * x[:, 2] ** 4 * s[:, 0])[:, None]


def _ishigami_slopes(u):
    x = np.pi * (2.0 * u - 1.0)
    s, c = np.sin(x), np.cos(x)
    parts = [
        c[:, 0] * (1.0 + 0.1 * x[:, 2] ** 4),
        14.0 * s[:, 1] * c[:, 1],
        0.4 * x[:, 2] ** 3 * s[:, 0],
    ]
    return 2.0 * np.pi * np.stack(parts, axis=1)[:, None]


def test_enumeration_is_the_maximum_where_the_model_is_monotone():
    slopes = _slopes(_monotone, _monotone_slopes)
    half = bound_half(slopes, 3, np.array([1.0, 0.0]))
    assert half.n_one_signed == 3
    assert half.best == half.bound == 3.0  # at u = (1, 0, .)
    corners = _monotone(np.array(np.meshgrid(*[[0.0, 1.0]] * 3)).reshape(3, -1).T)
    true = np.abs(corners[:, None] - corners).sum(2).max()
    found = bound_pair(slopes, 3, np.ones(2))
    assert found.best == found.bound == pytest.approx(true, abs=1e-12)


@pytest.mark.parametrize("widening", [0.0, 0.05, 0.25])
def test_the_bound_holds_where_the_maximum_is_inside(widening):
    slopes = _slopes(_ishigami, _ishigami_slopes)
    grid = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 41)] * 3), axis=-1).reshape(-1, 3)
    y = _ishigami(grid)[:, 0]
    found = bound_pair(slopes, 3, np.ones(1), n_samples=4000, widening=widening)
    assert found.best < y.max() - y.min() <= found.bound


def test_a_wider_range_of_slopes_gives_a_larger_bound():
    slopes = _slopes(_ishigami, _ishigami_slopes)
    bounds = [bound_pair(slopes, 3, np.ones(1), widening=w).bound for w in (0.0, 0.05, 0.25)]
    assert bounds == sorted(set(bounds))


def test_too_many_inputs_are_not_enumerated():
    slopes = _slopes(lambda u: ((u - 0.5) ** 2).sum(1)[:, None], lambda u: (2.0 * u - 1.0)[:, None])
    half = bound_half(slopes, 13, np.ones(1))
    assert (half.n_one_signed, half.best) == (0, None)
    assert half.bound >= 13 * 0.25
    found = bound_pair(slopes, 13, np.ones(1))
    assert found.bound >= 13 * 0.25
    assert found.n_not_enumerated == 1


def test_failing_models_are_named():
    def slopes(u, w):
        return np.full(len(u), -np.inf), np.zeros_like(u), np.zeros((len(u), 1))

    with pytest.raises(ModelError, match="fail; there is no sampled bound"):
        bound_half(slopes, 2, np.ones(1))

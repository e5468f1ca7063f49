"""The sampled bound, against brute force where the true maximum is known."""

import numpy as np
import pytest

from kneecore.errors import ModelError
from kneecore.search import sampled_bound
from kneecore.search.half_bound import Half, bound_half
from kneecore.search.sampled_bound import bound_pair
from kneecore.search.slope_signs import slope_signs, vertices


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
    (found,) = bound_pair(slopes, 3, np.ones(2))
    assert found.best == found.bound == pytest.approx(true, abs=1e-12)


@pytest.mark.parametrize("widening", [0.0, 0.05, 0.25])
def test_the_bound_holds_where_the_maximum_is_inside(widening):
    slopes = _slopes(_ishigami, _ishigami_slopes)
    grid = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 41)] * 3), axis=-1).reshape(-1, 3)
    y = _ishigami(grid)[:, 0]
    (found,) = bound_pair(slopes, 3, np.ones(1), n_samples=4000, widenings=(widening,))
    true = y.max() - y.min()
    assert found.best <= true + 1e-9 <= found.bound + 2e-9


def test_a_wider_range_of_slopes_gives_a_larger_bound():
    slopes = _slopes(_ishigami, _ishigami_slopes)
    found = bound_pair(slopes, 3, np.ones(1), n_samples=1000, widenings=(0.0, 0.05, 0.25))
    bounds = [one.bound for one in found]
    assert bounds == sorted(set(bounds))


def test_too_many_inputs_are_not_enumerated():
    slopes = _slopes(lambda u: ((u - 0.5) ** 2).sum(1)[:, None], lambda u: (2.0 * u - 1.0)[:, None])
    half = bound_half(slopes, 13, np.ones(1))
    assert (half.n_one_signed, half.best) == (0, None)
    assert half.bound >= 13 * 0.25
    (found,) = bound_pair(slopes, 13, np.ones(1))
    assert found.bound >= 13 * 0.25
    assert (found.best, found.n_looks) == (0.0, 1)


def test_failing_models_are_named():
    def slopes(u, w):
        return np.full(len(u), -np.inf), np.zeros_like(u), np.zeros((len(u), 1))

    with pytest.raises(ModelError, match="fail; there is no sampled bound"):
        bound_half(slopes, 2, np.ones(1))
    with pytest.raises(ModelError, match="fail; there is no sampled bound"):
        bound_pair(slopes, 2, np.ones(1))


def _crossing(u):
    """Two outputs that are largest together nowhere; the slope by b has a sign on a face only."""
    a, b, c = u.T
    one = a + 0.8 * b * (a - 0.3) + 0.1 * np.sin(5.0 * c)
    return np.stack([one, -0.5 * a + 0.4 * np.cos(4.0 * c)], axis=1)


def _crossing_slopes(u):
    a, b, c = u.T
    first = np.stack([1.0 + 0.8 * b, 0.8 * (a - 0.3), 0.5 * np.cos(5.0 * c)], axis=1)
    second = np.stack([np.full(len(u), -0.5), np.zeros(len(u)), -1.6 * np.sin(4.0 * c)], axis=1)
    return np.stack([first, second], axis=1)


def test_the_bound_holds_over_all_patterns_however_many_are_looked_at(monkeypatch):
    grid = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 13)] * 3), axis=-1).reshape(-1, 3)
    y = _crossing(grid)
    true = np.abs(y[:, None] - y).sum(axis=2).max()
    slopes = _slopes(_crossing, _crossing_slopes)
    bounds = []
    for max_looks in (0, 1, 24):
        monkeypatch.setattr(sampled_bound, "MAX_LOOKS", max_looks)
        (found,) = bound_pair(slopes, 3, np.ones(2), known=0.9 * true, n_samples=3000)
        assert found.bound >= true
        assert found.n_looks <= max_looks
        bounds.append(found.bound)
    assert bounds == sorted(bounds, reverse=True)
    assert bounds[-1] < bounds[0]


@pytest.mark.parametrize("widening", [0.0, 0.1])
def test_halved_boxes_bring_the_bound_down_and_never_below_the_maximum(monkeypatch, widening):
    grid = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 17)] * 3), axis=-1).reshape(-1, 3)
    y = _crossing(grid)
    true = np.abs(y[:, None] - y).sum(axis=2).max()
    slopes = _slopes(_crossing, _crossing_slopes)
    bounds = []
    for max_splits in (0, 4, 24):
        monkeypatch.setattr(sampled_bound, "MAX_SPLITS", max_splits)
        (one,) = bound_pair(slopes, 3, np.ones(2), n_samples=500, widenings=(widening,))
        assert true <= one.bound + 1e-9
        assert one.best <= one.bound
        bounds.append(one.bound)
    assert bounds == sorted(bounds, reverse=True)
    assert bounds[-1] - true < 0.4 * (bounds[0] - true)


def test_what_is_near_the_known_f_is_not_halved(monkeypatch):
    slopes = _slopes(_ishigami, _ishigami_slopes)
    looks = []
    monkeypatch.setattr(Half, "split", lambda half: looks.append(half))
    whole = sum(bound_half(slopes, 3, np.array([side])).bound for side in (1.0, -1.0))
    (near,) = bound_pair(slopes, 3, np.ones(1), known=whole / 1.004)
    assert (near.bound, looks) == (pytest.approx(whole), [])


def test_samples_in_blocks_are_all_looked_at(monkeypatch):
    slopes = _slopes(_crossing, _crossing_slopes)
    whole = sampled_bound._box_ranges(slopes, 3, np.eye(2), np.array([[1.0, 1.0]]), 64, 0)
    seen = []

    def watched(u, w):
        seen.append(len(u))
        return slopes(u, w)

    monkeypatch.setattr(sampled_bound, "_BLOCK", 60)  # ten points a block
    parts = sampled_bound._box_ranges(watched, 3, np.eye(2), np.array([[1.0, 1.0]]), 64, 0)
    assert sum(seen) == 2 * 64
    assert max(seen) == 10
    np.testing.assert_allclose(parts, whole, atol=0.4)


def _bump(u):
    return np.exp(-40.0 * ((u[:, 1:] - 0.8) ** 2).sum(axis=1))


def _hidden(u):
    """The slope by input 0 is above 0 but in a small place, where all others are near 0.8."""
    return (u[:, 0] * (1.0 - 1.5 * _bump(u)))[:, None]


def _hidden_slopes(u):
    bump = _bump(u)[:, None]
    others = 120.0 * u[:, :1] * (u[:, 1:] - 0.8) * bump
    return np.concatenate([1.0 - 1.5 * bump, others], axis=1)[:, None]


def test_a_change_of_sign_that_samples_miss_is_found(monkeypatch):
    for name in ("_N_SAMPLES", "_BATCH"):
        monkeypatch.setattr(f"kneecore.search.slope_signs.{name}", 300)
    found = slope_signs(_slopes(_hidden, _hidden_slopes), 5, np.ones(1), seed=1)
    assert (found.n_sampled, found.n_one_signed) == (1, 0)
    assert found.n_models > 300


def test_signs_of_a_monotone_model_stand_and_its_vertices_are_the_best():
    slopes = _slopes(_monotone, _monotone_slopes)
    found = slope_signs(slopes, 3, np.array([1.0, -1.0]))
    assert found.sides.tolist() == [1, -1, -1]
    assert (found.n_sampled, found.n_one_signed, found.n_failed) == (3, 3, 0)
    best, worst = vertices(found.sides)[:, 0]
    assert (best.tolist(), worst.tolist()) == ([1, 0, 0], [0, 1, 1])
    left = vertices(np.array([1, 0, -1, 0]))
    assert left.shape == (2, 4, 4)
    assert {tuple(v) for v in left[0]} == {(1, a, 0, b) for a in (0, 1) for b in (0, 1)}


def test_inputs_of_failing_models_have_no_sign():
    def slopes(u, w):
        return np.full(len(u), -np.inf), np.zeros_like(u), np.zeros((len(u), 1))

    found = slope_signs(slopes, 2, np.ones(1))
    assert found.n_failed == found.n_models
    assert found.n_one_signed == 0

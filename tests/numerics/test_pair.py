"""The pair objective: the fused search against the general one."""

from concurrent.futures import ThreadPoolExecutor
from threading import Event

import numpy as np
import pytest

from kneecore import _threads
from kneecore.numerics import pair as pair_module
from kneecore.numerics.genetic import Fused, maximize
from kneecore.numerics.pair import ModelPair, SurrogatePair
from kneecore.numerics.pair_kernels import LEAVE, TICKET
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


def fused_search(surrogate, threads, pop_size=300, n_generations=70):
    """Return a search of several blocks of children a generation."""
    objective = SurrogatePair(surrogate, np.ones(5), threads)
    return maximize(
        objective, np.zeros(14), np.ones(14), pop_size=pop_size, n_generations=n_generations
    )


def assert_same_bytes(one, two):
    assert one.x.tobytes() == two.x.tobytes()
    assert one.history.tobytes() == two.history.tobytes()


@pytest.mark.parametrize("pop_size", [100, 200, 213, 450])
@pytest.mark.parametrize("threads", [2, 3])
def test_threads_change_no_bit_of_a_fused_search(surrogate, threads, pop_size):
    alone, shared = (fused_search(surrogate, n, pop_size) for n in (1, threads))
    assert_same_bytes(alone, shared)


def test_a_batch_changes_no_bit_of_a_value(surrogate):
    pairs = np.random.default_rng(4).random((250, 14))
    objective = SurrogatePair(surrogate, np.ones(5))
    alone = np.concatenate([objective(pair[None]) for pair in pairs])
    np.testing.assert_array_equal(objective(pairs), alone)


def test_a_fused_search_needs_no_free_thread(surrogate, monkeypatch):
    free, wanted = Event(), fused_search(surrogate, 1)
    with ThreadPoolExecutor(2) as pool:
        monkeypatch.setattr(_threads, "_pool", lambda _: pool)
        blocked = [pool.submit(free.wait, 60) for _ in range(2)]
        try:
            assert_same_bytes(fused_search(surrogate, 2), wanted)
            assert not any(b.done() for b in blocked)
        finally:
            free.set()


def test_the_leader_of_a_fused_search_may_come_last(surrogate, monkeypatch):
    wanted = fused_search(surrogate, 1)

    def helper_first(work, threads):
        if threads > 1:
            work(False)
        work(True)

    monkeypatch.setattr(pair_module, "run_together", helper_first)
    assert_same_bytes(fused_search(surrogate, 2), wanted)


def test_helpers_of_a_fused_search_that_are_too_slow_are_asked_less_and_less(
    surrogate, monkeypatch
):
    wanted, kernel = fused_search(surrogate, 1, n_generations=1000), pair_module.evolve
    drawn, asked = [], []

    def busy_machine(*arguments):
        counters, leads = arguments[-2:]
        counters[LEAVE] = not leads
        kernel(*arguments)
        drawn.append((leads, int(counters[TICKET])))
        counters[LEAVE] = 1

    def helper_first(work, threads):
        asked.append(threads)
        for leads in (False, True)[threads < 2 :]:
            work(leads)

    monkeypatch.setattr(pair_module, "evolve", busy_machine)
    monkeypatch.setattr(pair_module, "run_together", helper_first)
    assert_same_bytes(fused_search(surrogate, 2, n_generations=1000), wanted)
    # The helper does one block of each call that it is asked to, and is away.
    assert {ticket for leads, ticket in drawn if not leads} == {1}
    assert "".join(str(n) for n in asked) == "2" + "1" * 8 + "2" + "1" * 11


def test_a_centre_far_from_the_origin_costs_no_digits():
    rng = np.random.default_rng(5)
    points = 1e4 + rng.random((40, 7))
    surrogate = Surrogate.fit(points, 30.0 * np.sin((points - 1e4) @ rng.normal(size=(7, 5))))
    pairs = 1e4 + rng.random((100, 14))
    fast, slow = SurrogatePair(surrogate, np.ones(5)), ModelPair(surrogate, np.ones(5))
    np.testing.assert_allclose(fast(pairs), slow(pairs), rtol=1e-4, atol=1e-3)


def test_at_a_centre_a_spline_is_finite(surrogate):
    points = surrogate.centres[: surrogate.n_dimensions + 30, :7]
    pairs = np.hstack([points, points[::-1]])
    fast, slow = SurrogatePair(surrogate, np.ones(5)), ModelPair(surrogate, np.ones(5))
    np.testing.assert_allclose(fast(pairs), slow(pairs), rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_fused_search_can_be_cancelled(surrogate, threads):
    result = maximize(
        SurrogatePair(surrogate, np.ones(5), threads),
        np.zeros(14),
        np.ones(14),
        pop_size=220,
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

"""A search's best pair before it has ended: what a callback may look at."""

import numpy as np
import pytest

import kneecore
from kneecore import Knee, ParameterSpace, SearchResult, SearchSettings
from kneecore.search.best_seen import BestSeen

EXACT = SearchSettings(method="exact")


def at_rest(mm=2.0):
    return Knee(ParameterSpace(geometry_bound_mm=mm), solver="equilibrium", threads=1)


@pytest.fixture(scope="module")
def reports():
    """Every result until now of a search that goes on, and its end."""
    seen = []

    def look(progress):
        if progress.so_far is not None:
            seen.append(progress.so_far())

    end = kneecore.worst_case(at_rest(), EXACT, callback=look)
    return seen, end


def test_each_is_a_pair_of_the_true_model(reports):
    seen, end = reports
    assert len(seen) > 20
    for result in seen[::7]:
        again = end.model.examine(result.x).y
        np.testing.assert_array_equal(again, result.y)
        assert result.objective_model == pytest.approx(np.abs(again[0] - again[1]).sum())
        assert isinstance(result, SearchResult)
        assert result.stop_reason == "cancelled"
        assert result.settings == end.settings
        assert set(result.responses) == set(end.responses)


def test_they_get_better_and_end_close_to_the_end(reports):
    seen, end = reports
    values = [result.objective_model for result in seen]
    assert values == sorted(values)
    assert values[0] < 0.9 * end.objective_model
    assert 0.999 * end.objective_model < values[-1] <= end.objective_model + 1e-9


def test_who_looks_changes_nothing(reports):
    _, end = reports
    blocking = kneecore.worst_case(at_rest(), EXACT)
    assert end.x.tobytes() == blocking.x.tobytes()
    assert end.history.tobytes() == blocking.history.tobytes()
    assert dict(end.counts) == dict(blocking.counts)
    assert end.stop_reason == blocking.stop_reason == "converged"


def test_their_counts_are_those_until_then(reports):
    seen, end = reports
    counts = [result.counts["models_simulated"] for result in seen]
    assert counts == sorted(counts)
    assert 0 < counts[0] < counts[-1] < end.counts["models_simulated"]


def test_there_is_none_where_a_search_cannot_tell():
    told = []
    settings = SearchSettings(pop_size=20, n_generations=3, training_samples=40)
    kneecore.worst_case(Knee(), settings, callback=lambda p: told.append(p.so_far) and None)
    assert set(told) == {None}


def test_a_proxys_pair_is_no_answer():
    told, knee = [], Knee(ParameterSpace(case="material"))
    kneecore.worst_case(knee, EXACT, callback=lambda p: told.append(p.so_far) and None)
    assert len(told) > 10
    assert set(told) == {None}


def test_failures_are_left_out():
    seen = BestSeen(np.array([1.0, 2.0]))
    assert seen.pair is None
    assert seen.value == -np.inf
    seen.take(np.array([[0.1], [0.2]]), np.full((2, 2), np.nan))
    assert seen.pair is None
    u = np.array([[0.1], [0.2], [0.3]])
    seen.take(u, np.array([[1.0, 1.0], [np.nan, 9.0], [0.0, 3.0]]))
    (high, low), y = seen.pair
    assert (high, low) == (0.3, 0.1)
    assert seen.value == 1.0 + 2.0 * 2.0
    seen.take(u[:1], np.array([[0.0, 0.0]]))
    assert seen.value == 6.0
    assert (seen.n_models, seen.n_failed) == (6, 3)
    assert y[0].tolist() == [0.0, 3.0]

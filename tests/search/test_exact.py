"""The exact search: against brute force where that can be, and against the genetic algorithm."""

import itertools

import numpy as np
import pytest
from searches import knee_of

from kneecore import MOMENT, Knee, ModelError, ParameterError, ParameterSpace, simulate_batch
from kneecore.knee.model import ALONG_LOADS
from kneecore.model import Evaluation
from kneecore.numerics.genetic import maximize
from kneecore.numerics.pair import ModelPair
from kneecore.progress import Cancelled
from kneecore.search import exact_model
from kneecore.search.exact_model import exact_pair
from kneecore.search.pattern_climb import climb_from_patterns
from kneecore.search.sign_climb import ExactSettings, climb_pair, sign_patterns
from kneecore.unit_model import UnitModel

SPACE = ParameterSpace()


def multilinear(seed, bend=0.0, d=6, m=5, mixing=0.3):
    """y_j, linear in each input by itself, so that every maximum of a sum is a corner.

    The difference of two models is a line over j, with a `bend` a parabola: it crosses zero once,
    or twice.
    """
    rng = np.random.default_rng(seed)
    j = np.linspace(-1.0, 1.0, m)
    modes = np.stack([np.ones(m), 2.0 * j, bend * (3.0 * j**2 - 1.0)], axis=1)
    linear = modes @ rng.normal(size=(3, d))
    mixed = np.einsum("jk,kde->jde", modes, np.triu(rng.normal(size=(3, d, d)) * mixing, 1))

    def outputs(u):
        return u @ linear.T + np.einsum("nd,jde,ne->nj", u, mixed, u)

    def slopes(u, w):
        y = outputs(u)
        by_input = linear + np.einsum("jde,ne->njd", mixed + mixed.transpose(0, 2, 1), u)
        return (w * y).sum(axis=1), np.einsum("nj,njd->nd", w, by_input), y

    return outputs, slopes


def exact_of(space=None, *, objective="all", seed=0, report=None, **options):
    """Return the exact search's pair of knees, and its two knees, SI."""
    knee = knee_of(space, options)
    weights, settings = knee.weights(objective), ExactSettings(seed=seed)
    found = exact_pair(knee, weights, settings=settings, report=report)
    return found, knee.from_free_unit(found.u)


def settled(space, x):
    y = np.degrees(simulate_batch(x, baseline=space.baseline, solver="equilibrium").flexion)
    return float(np.abs(y[0] - y[1]).sum())


def moved(space, x, rest_length="recomputed"):
    response = simulate_batch(x, baseline=space.baseline, rest_length=rest_length)
    y = np.degrees(response.flexion)
    return float(np.abs(y[0] - y[1]).sum())


def test_patterns_change_their_sign_at_most_once_along_the_loads():
    patterns = sign_patterns(np.ones(12), ALONG_LOADS)
    assert MOMENT[list(ALONG_LOADS)].tolist() == sorted(MOMENT, reverse=True)
    assert patterns.shape == (12, 12)
    changes = np.count_nonzero(np.diff(patterns[:, list(ALONG_LOADS)], axis=1), axis=1)
    assert sorted(changes) == [0] + 11 * [1]
    different = {tuple(s * p) for p in patterns for s in (1.0, -1.0)}
    assert len(different) == 24


def test_loads_that_do_not_count_have_no_sign_of_their_own():
    weights = np.where(MOMENT > 0, 1.0, 0.0)
    patterns = sign_patterns(weights, ALONG_LOADS)
    assert patterns.shape == (6, 12)
    assert (patterns[:, weights == 0.0] == 1.0).all()


def brute_force(outputs, weights):
    y = outputs(np.array(list(itertools.product([0.0, 1.0], repeat=6))))
    return y, float((np.abs(y[:, None] - y[None]) * weights).sum(axis=2).max())


@pytest.mark.parametrize("seed", range(12))
def test_finds_what_brute_force_over_all_corners_finds(seed):
    outputs, slopes = multilinear(seed)
    weights = np.array([1.0, 2.0, 0.5, 1.0, 1.5])
    found = climb_pair(slopes, 6, weights)
    assert found.value == pytest.approx(brute_force(outputs, weights)[1], rel=1e-9)
    assert found.value == pytest.approx((weights * np.abs(found.y[0] - found.y[1])).sum())
    assert found.evidence.second_best is None or found.evidence.second_best < found.value
    assert 0.0 < found.evidence.share_reached <= 1.0


def test_two_crossings_are_mostly_found_from_pairs_with_one():
    reached = 0
    for seed in range(12):
        outputs, slopes = multilinear(seed, bend=2.0)
        found = climb_pair(slopes, 6, np.ones(5))
        y, best = brute_force(outputs, np.ones(5))
        sums = y @ sign_patterns(np.ones(5)).T
        assert found.value >= (sums.max(axis=0) - sums.min(axis=0)).max() - 1e-9
        reached += found.value > best - 1e-9
    assert reached >= 9


def test_brute_force_cases_need_all_kinds_of_patterns():
    """The test above is worth something only if its pairs have none, one and two crossings."""
    best = [
        climb_pair(multilinear(seed, bend)[1], 6, np.ones(5)).evidence.patterns[0][0]
        for seed in range(12)
        for bend in (0.0, 2.0)
    ]
    assert {int(np.count_nonzero(np.diff(signs))) for signs in best} == {0, 1, 2}


def test_settled_worst_case_is_not_below_the_genetic_algorithm():
    found, x = exact_of(solver="equilibrium")
    knee = Knee(SPACE, solver="equilibrium")

    def angles(u):
        return knee.slopes(u, np.zeros((len(u), 12)))[2]

    pairs = ModelPair(angles, np.ones(12))
    ga = [
        maximize(pairs, np.zeros(56), np.ones(56), pop_size=100, n_generations=100, seed=s).value
        for s in range(2)
    ]
    assert found.objective >= max(ga)
    assert found.objective == pytest.approx(settled(SPACE, x), rel=1e-12)
    assert found.evidence.objective_proxy == found.objective
    assert found.evidence.n_models == 0


@pytest.mark.parametrize("solver", ["dynamics", "equilibrium"])
def test_no_single_parameter_improves_the_worst_case(solver):
    found, _ = exact_of(solver=solver, seed=3)
    others = np.repeat(found.u[:, None], 56, axis=1)
    for k in range(28):
        others[:, k, k] = 1.0 - found.u[:, k]
        others[:, 28 + k, k] = np.clip(
            found.u[:, k] + np.where(found.u[:, k] > 0.5, -0.1, 0.1), 0, 1
        )
    responses = simulate_batch(SPACE.from_unit(others.reshape(-1, 28)), solver=solver)
    y = np.degrees(responses.flexion).reshape(2, 56, 12)
    for k in (0, 1):
        assert np.abs(y[k] - found.y[1 - k]).sum(axis=1).max() < found.objective


def test_worst_case_in_motion_is_not_below_the_genetic_algorithm():
    found, x = exact_of(seed=1)
    pairs = ModelPair(UnitModel(Knee(SPACE)), np.ones(12))
    ga = maximize(pairs, np.zeros(56), np.ones(56), pop_size=60, n_generations=40, seed=0)
    assert found.objective > ga.value
    assert found.objective == pytest.approx(moved(SPACE, x), rel=1e-12)
    assert found.evidence.n_models > 0
    assert found.y[0, 5] < found.y[1, 5]


@pytest.mark.parametrize("solver", ["dynamics", "equilibrium"])
def test_all_seeds_end_in_the_same_worst_case(solver):
    values = [exact_of(solver=solver, seed=s)[0].objective for s in range(5)]
    assert max(values) - min(values) < 1e-6


def test_same_seed_same_bytes_on_any_number_of_threads():
    one, two = (exact_of(seed=5, threads=t)[0] for t in (1, 2))
    assert one.u.tobytes() == two.u.tobytes()
    assert one.y.tobytes() == two.y.tobytes()
    assert vars(one.evidence) == vars(two.evidence)


def test_motion_climbs_where_rest_has_misled():
    """With the baseline's rest lengths the knee creeps: the worst pair at rest is not the worst."""
    found, x = exact_of(rest_length="fixed")
    evidence = found.evidence
    assert evidence.objective_before_climb is not None
    assert found.objective > 1.005 * evidence.objective_before_climb
    assert found.objective == pytest.approx(moved(SPACE, x, "fixed"), rel=1e-12)
    assert (SPACE.at_bounds(x) == 0).any()


@pytest.mark.parametrize("objective", ["extension", "flexion"])
def test_only_the_loads_that_count(objective):
    found, _ = exact_of(objective=objective, solver="equilibrium")
    counts = (MOMENT > 0) == (objective == "extension")
    difference = np.abs(found.y[0] - found.y[1])
    assert found.objective == pytest.approx(difference[counts].sum())
    both, _ = exact_of(solver="equilibrium")
    assert found.objective > np.abs(both.y[0] - both.y[1])[counts].sum()


def test_cases_search_their_own_parameters():
    space = ParameterSpace(case="material")
    found, x = exact_of(space, solver="equilibrium")
    assert found.u.shape == (2, 6)
    np.testing.assert_array_equal(x[:, :22], np.tile(space.baseline[:22], (2, 1)))
    assert (space.at_bounds(x)[:, 22:] != 0).all()
    assert found.objective < 0.2 * exact_of(solver="equilibrium")[0].objective


def test_knees_without_an_equilibrium_are_left_out_and_counted():
    half = {"pcl_stiffness": SPACE.baseline[23], "acl_stiffness": 1e6}
    space = ParameterSpace(half_ranges=half, geometry_bound_mm=0.0, material_bound_percent=0.0,
                           slope_bound_deg=0.0)  # fmt: skip
    found, _ = exact_of(space, solver="equilibrium")
    assert found.evidence.n_failed > 0
    assert np.isfinite(found.objective)
    assert np.isfinite(found.y).all()


def test_motion_knows_failures():
    outputs, slopes = multilinear(1)
    found = climb_pair(slopes, 6, np.ones(5))

    def failing(u):
        return np.full((len(u), 5), np.nan)

    assert climb_from_patterns(failing, found, np.ones(5)).value == -np.inf
    assert climb_from_patterns(outputs, found, np.ones(5)).value == pytest.approx(found.value)


class Unscreened(Knee):
    """Knees of which a screening leaves none."""

    @property
    def screening(self):
        return Nothing(self.space)


class Nothing(Knee):
    def _examine(self, x, *, observe):
        return Evaluation(y=np.full((len(x), 12), np.nan), counts={"failed": len(x)})


def test_where_a_screening_leaves_nothing_the_model_itself_is_searched(monkeypatch):
    # One failure is many here, so that small bounds do.
    monkeypatch.setattr(exact_model, "MANY_FAILED", -1.0)
    monkeypatch.setattr(exact_model, "QUICK", ())
    space = ParameterSpace(case="material")
    found = exact_pair(Unscreened(space))
    assert found.objective == pytest.approx(exact_pair(Knee(space)).objective)


def test_a_report_can_end_the_search_at_any_batch():
    seen = []

    def report(best, n_models):
        seen.append(best)
        return np.isfinite(best)

    found, _ = exact_of(solver="equilibrium", report=report)
    whole, _ = exact_of(solver="equilibrium")
    assert np.isfinite(seen).tolist() == [False] * (len(seen) - 1) + [True]
    assert found.evidence.n_evaluations < whole.evidence.n_evaluations
    assert found.objective <= whole.objective


def test_a_search_that_is_ended_before_it_has_a_pair_is_cancelled():
    seen = []

    def second(best, n_models):
        seen.append(best)
        return len(seen) == 2

    with pytest.raises(Cancelled):
        exact_of(solver="equilibrium", report=second)
    assert len(seen) == 2  # within the first climbs, not after them


def test_a_report_changes_nothing():
    quiet, _ = exact_of(solver="equilibrium")
    told, _ = exact_of(solver="equilibrium", report=lambda *_: False)
    assert quiet.u.tobytes() == told.u.tobytes()


def test_refused():
    with pytest.raises(ParameterError, match="`solver` is 'both'"):
        exact_of(solver="both")
    with pytest.raises(ParameterError, match="`n_kicks` is 0"):
        ExactSettings(n_kicks=0)

    def lost(u, w):
        return np.full(len(u), -np.inf), np.zeros_like(u), np.full((len(u), 2), np.nan)

    with pytest.raises(ModelError, match="all of them failed"):
        climb_pair(lost, 3, np.ones(2))

"""The genetic algorithm: its operators one by one, and whether it finds known optima."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kneecore.errors import ModelError, ParameterError
from kneecore.numerics import breeding
from kneecore.numerics.breeding import rank_chances
from kneecore.numerics.genetic import maximize
from kneecore.numerics.genetic_options import GeneticOptions


def bred(population, values, *, options=None, seed=0, generation=1, exponent=1.0, bounds=None):
    """Return the children of one generation and the order of their parents."""
    options = options or GeneticOptions()
    n, d = population.shape
    order, spare = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    breeding.rank(values, order, spare)
    n_elite, n_crossover, _ = options.split(n)
    lower, upper = bounds or (np.zeros(d), np.ones(d))
    children = np.empty_like(population)
    breeding.breed(
        population,
        order,
        rank_chances(options, n),
        breeding.wheel_starts(rank_chances(options, n)),
        lower,
        upper,
        n_elite,
        n_crossover,
        options.blx_alpha,
        exponent,
        options.gene_mutation_probability,
        seed,
        generation,
        0,
        n,
        children,
    )
    return children, order


@pytest.mark.parametrize("n", [1, 2, 3, 10, 97, 200])
def test_rank_is_a_stable_sort_by_falling_value(n):
    values = np.random.default_rng(n).integers(0, max(2, n // 3), n).astype(float)
    values[0] = -np.inf
    order, spare = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    breeding.rank(values, order, spare)
    np.testing.assert_array_equal(order, np.argsort(-values, kind="stable"))


def test_random_numbers_are_uniform_and_uncorrelated():
    x = np.empty((200, 500))
    breeding.first_population(0, np.zeros(500), np.ones(500), x)
    assert 0.0 <= x.min() < 1e-4
    assert 1.0 - 1e-4 < x.max() < 1.0
    counts, _ = np.histogram(x, bins=100, range=(0.0, 1.0))
    # 99 degrees of freedom: 149 is the 99.9 % point of chi squared.
    assert ((counts - 1000.0) ** 2 / 1000.0).sum() < 149.0
    for shifted in (x[:, 1:], x[1:, :]):
        kept = x[: shifted.shape[0], : shifted.shape[1]]
        assert abs(np.corrcoef(kept.ravel(), shifted.ravel())[0, 1]) < 0.015


def test_seeds_generations_and_children_have_numbers_of_their_own():
    first, other = np.empty((10, 5)), np.empty((10, 5))
    breeding.first_population(0, np.zeros(5), np.ones(5), first)
    breeding.first_population(1, np.zeros(5), np.ones(5), other)
    assert not np.isin(first, other).any()
    population = np.random.default_rng(0).random((20, 5))
    values = np.arange(20.0)
    one, _ = bred(population, values, generation=1)
    two, _ = bred(population, values, generation=2)
    assert (one[2:] != two[2:]).any(axis=1).all()


@settings(max_examples=40, deadline=None)
@given(st.integers(10, 60), st.integers(1, 9), st.integers(0, 2**63 - 1), st.floats(0.0, 1.0))
def test_children_are_in_bounds_and_the_elite_is_kept(n, d, seed, exponent):
    rng = np.random.default_rng(seed)
    lower = rng.normal(size=d)
    upper = lower + rng.random(d)
    population = lower + rng.random((n, d)) * (upper - lower)
    values = rng.normal(size=n)
    children, order = bred(population, values, seed=seed, exponent=exponent, bounds=(lower, upper))
    assert (children >= lower).all()
    assert (children <= upper).all()
    n_elite = GeneticOptions().split(n)[0]
    np.testing.assert_array_equal(children[:n_elite], population[order[:n_elite]])


def test_crossover_is_blx_alpha():
    # Two parents only: genes lie on their interval widened by half its width, and fill it.
    population = np.where(np.arange(1000)[:, None] % 2 == 0, 0.4, 0.6) * np.ones((1000, 4))
    options = GeneticOptions(elite_fraction=0.01, crossover_fraction=0.98, mutation_fraction=0.01)
    children, _ = bred(population, np.zeros(1000), options=options)
    crossed = children[10:990]
    mixed = crossed[(crossed != 0.4).all(axis=1) & (crossed != 0.6).all(axis=1)]
    assert 300 < len(mixed) < 700
    assert 0.3 <= mixed.min() < 0.301
    assert 0.699 < mixed.max() <= 0.7
    assert abs(mixed.mean() - 0.5) < 0.01


def test_roulette_follows_the_ranks():
    # Every individual carries its rank; unmutated genes of mutation children tell their parent.
    n = 400
    population = np.repeat(np.arange(n)[:, None] / n, 3, axis=1)
    values = -np.arange(n, dtype=float)
    options = GeneticOptions(
        elite_fraction=0.01,
        crossover_fraction=0.01,
        mutation_fraction=0.98,
        gene_mutation_probability=0.0,
    )
    parents = []
    for generation in range(1, 60):
        children, _ = bred(population, values, options=options, generation=generation)
        genes = children[8:]
        # One gene of three was mutated: the parent's is the median.
        parents.append(np.median(genes, axis=1) * n)
    share, _ = np.histogram(np.concatenate(parents), bins=4, range=(0, n))
    share = share / share.sum()
    # Linear ranking with eta_min 0: 7/16, 5/16, 3/16, 1/16 of the parents a quarter.
    np.testing.assert_allclose(share, [0.4375, 0.3125, 0.1875, 0.0625], atol=0.01)


@settings(max_examples=60, deadline=None)
@given(st.integers(2, 80), st.floats(0.0, 1.0), st.integers(0, 1000))
def test_a_wheel_stops_at_the_first_rank_above(n, eta_min, seed):
    cumulative = rank_chances(GeneticOptions(rank_eta_min=eta_min), n)
    starts = breeding.wheel_starts(cumulative)
    for u in [0.0, np.nextafter(1.0, 0.0), *np.random.default_rng(seed).random(20)]:
        rank = breeding._spin(cumulative, starts, u)
        assert rank == np.searchsorted(cumulative, u, side="right")


def test_rows_of_children_can_be_bred_apart():
    population = np.random.default_rng(0).random((60, 40))
    whole, order = bred(population, np.arange(60.0))
    options, parts = GeneticOptions(), np.full_like(whole, np.nan)
    chances = rank_chances(options, 60)
    for first, stop in ((40, 60), (0, 7), (7, 40)):
        breeding.breed(
            population, order, chances, breeding.wheel_starts(chances), np.zeros(40), np.ones(40),
            6, 42, 0.5, 1.0, 0.05, 0, 1, first, stop, parts,
        )  # fmt: skip
    np.testing.assert_array_equal(parts, whole)


@pytest.mark.parametrize("d", [5, 31, 32, 33, 56, 64, 70])
def test_each_gene_of_a_child_has_a_number_of_its_own(d):
    population = np.array([np.zeros(d), np.ones(d)] * 100)
    children, _ = bred(population, np.zeros(200))
    crossed = children[20:160]
    mixed = crossed[((crossed > 0.0) & (crossed < 1.0)).sum(axis=1) > 1]
    inside = mixed[(mixed > 0.0) & (mixed < 1.0)]
    assert len(inside) > 20 * d
    assert len(np.unique(inside)) == len(inside)
    assert abs(inside.mean() - 0.5) < 0.05


def test_rank_chances():
    even = np.diff(rank_chances(GeneticOptions(rank_eta_min=1.0), 10), prepend=0.0)
    np.testing.assert_allclose(even, 0.1)
    steep = np.diff(rank_chances(GeneticOptions(rank_eta_min=0.0), 10), prepend=0.0)
    assert steep[0] == pytest.approx(0.2)
    assert steep[-1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("exponent", [1.0, 0.1, 0.001, 0.0])
def test_mutation_steps_shrink_and_go_both_ways(exponent):
    population = np.full((1000, 1), 0.3)
    options = GeneticOptions(elite_fraction=0.01, crossover_fraction=0.01, mutation_fraction=0.98)
    children, _ = bred(population, np.zeros(1000), options=options, exponent=exponent)
    steps = children[20:, 0] - 0.3
    if exponent == 0.0:
        assert (steps == 0.0).all()
        return
    assert 0.4 < (steps > 0).mean() < 0.6
    # y (1 - r^e) has the mean y (1 - 1 / (1 + e)): y is 0.7 up and 0.3 down.
    expected = exponent / (1.0 + exponent)
    assert steps[steps > 0].mean() == pytest.approx(0.7 * expected, rel=0.2)
    assert steps[steps < 0].mean() == pytest.approx(-0.3 * expected, rel=0.2)


def test_every_mutated_child_changes_and_only_the_drawn_genes_do():
    population = np.full((500, 20), 0.5)
    options = GeneticOptions(elite_fraction=0.02, crossover_fraction=0.02, mutation_fraction=0.96)
    children, _ = bred(population, np.zeros(500), options=options)
    changed = (children[20:] != 0.5).sum(axis=1)
    assert changed.min() >= 1
    # 20 genes at 5 %: 1 on average, and the 36 % of children without any get one.
    assert changed.mean() == pytest.approx(1.0 + 0.95**20, abs=0.15)


@pytest.mark.parametrize(
    ("pop_size", "split"), [(200, (20, 140, 40)), (100, (10, 70, 20)), (10, (1, 7, 2))]
)
def test_the_split_is_70_20_10(pop_size, split):
    assert GeneticOptions().split(pop_size) == split


def sphere(x):
    return -((x - 0.37) ** 2).sum(axis=1)


def rastrigin(x):
    z = 10.24 * (x - 0.43)
    return -(10.0 * x.shape[1] + (z**2 - 10.0 * np.cos(2.0 * np.pi * z)).sum(axis=1))


def corner(x):
    """A convex function: each of the 2^d corners is a local maximum, one is best."""
    return ((x - 0.45) ** 2).sum(axis=1)


@pytest.mark.parametrize(
    ("objective", "best", "tolerance", "at_least"),
    [
        (sphere, 0.0, 1e-3, 20),
        # A thousand traps around each optimum: a good half of the seeds get through.
        (rastrigin, 0.0, 1e-2, 11),
        (corner, 10 * 0.55**2, 1e-6, 20),
    ],
)
def test_success_rates_over_20_seeds(objective, best, tolerance, at_least):
    found = [
        maximize(objective, np.zeros(10), np.ones(10), pop_size=200, n_generations=400, seed=s)
        for s in range(20)
    ]
    assert sum(best - r.value < tolerance for r in found) >= at_least


def test_history_never_falls_and_evaluations_are_counted():
    seen = []

    def counted(x):
        seen.append(len(x))
        return rastrigin(x)

    result = maximize(counted, np.zeros(6), np.ones(6), pop_size=50, n_generations=30)
    assert (np.diff(result.history) >= 0.0).all()
    assert len(result.history) == 31
    assert result.history[-1] == result.value
    assert result.n_evaluations == sum(seen) == 50 + 30 * 45
    assert result.stop_reason == "max_generations"
    assert rastrigin(result.x[None])[0] == result.value


def test_the_same_seed_gives_the_same_bytes_and_another_does_not():
    runs = [
        maximize(rastrigin, np.zeros(6), np.ones(6), pop_size=30, n_generations=20, seed=seed)
        for seed in (5, 5, 6)
    ]
    assert runs[0].x.tobytes() == runs[1].x.tobytes()
    assert runs[0].x.tobytes() != runs[2].x.tobytes()


def test_a_callback_sees_progress_and_can_cancel():
    seen = []

    def watch(generation, best):
        seen.append((generation, best))
        return generation >= 7

    result = maximize(sphere, np.zeros(3), np.ones(3), pop_size=20, callback=watch)
    assert result.stop_reason == "cancelled"
    assert [g for g, _ in seen] == list(range(8))
    assert seen[-1][1] == result.value


def test_a_callback_hears_of_the_last_generation():
    seen = []
    maximize(
        sphere,
        np.zeros(3),
        np.ones(3),
        pop_size=20,
        n_generations=5,
        callback=lambda generation, best: seen.append(generation),
    )
    assert seen == [0, 1, 2, 3, 4, 5]


def test_failures_count_as_minus_infinity():
    def holes(x):
        return np.where(x[:, 0] > 0.5, np.nan, x[:, 0])

    result = maximize(holes, np.zeros(2), np.ones(2), pop_size=40, n_generations=60)
    assert 0.49 < result.value <= 0.5


def test_nothing_but_failures_is_an_error():
    with pytest.raises(ModelError, match="every model of the search failed"):
        maximize(lambda x: np.full(len(x), np.nan), [0.0], [1.0], pop_size=10, n_generations=3)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"pop_size": 4}, "`pop_size` is 4; at least 10 is allowed"),
        ({"pop_size": 0}, "`pop_size` is 0; a whole number"),
        ({"pop_size": 20.5}, "`pop_size` is 20.5"),
        ({"n_generations": 0}, "`n_generations` is 0"),
        ({"seed": -1}, "`seed` is -1"),
        ({"seed": 2**63}, "`seed` is 9223372036854775808"),
        ({"lower": [0.0, 0.0]}, "have shapes"),
        ({"lower": [2.0]}, "no lower above its upper"),
        ({"upper": [np.inf]}, "must be finite"),
        ({"objective": lambda x: x}, "`objective` returned shape"),
    ],
)
def test_what_is_not_allowed_is_named(arguments, said):
    given_ = {"objective": sphere, "lower": [0.0], "upper": [1.0]} | arguments
    with pytest.raises(ParameterError, match=said):
        maximize(given_.pop("objective"), given_.pop("lower"), given_.pop("upper"), **given_)


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ({"crossover_fraction": 0.8}, "sum 1"),
        ({"elite_fraction": 0.0, "crossover_fraction": 0.8}, "positive shares"),
        ({"rank_eta_min": 1.5}, "`rank_eta_min` is 1.5; 0 to 1 is allowed"),
        ({"gene_mutation_probability": -0.1}, "`gene_mutation_probability` is -0.1"),
        ({"blx_alpha": np.nan}, "`blx_alpha` is nan"),
    ],
)
def test_wrong_options_are_named(option, said):
    with pytest.raises(ParameterError, match=said):
        GeneticOptions(**option)

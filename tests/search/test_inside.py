"""Worst pairs inside the bounds, and what the search says of how far it is to be trusted."""

import json

import models
import numpy as np
import pytest
from results import check_comes_back

from kneecore import Input, Model, Output, SearchResult, SearchSettings, worst_case
from kneecore.numerics.surrogate import _squared_distances
from kneecore.search.inside import Half, thrown
from kneecore.search.training import train
from kneecore.unit_model import UnitModel

BEST_ISHIGAMI = 9.0 + 0.2 * np.pi**4  # by hand
HOW = {"method": "exact", "repair": True, "repair_models": 99}


def own(run, d=3, m=1, **options):
    inputs = [Input(f"x_{k}", lower=0.0, upper=1.0) for k in range(d)]
    return Model(run, inputs, [Output("y", axis=range(m) if m > 1 else None)],
                 **{"batched": True} | options)  # fmt: skip


@pytest.fixture(scope="module")
def ishigami():
    return worst_case(models.ishigami())


def test_a_model_of_ones_own_is_repaired_unless_told_otherwise(ishigami):
    assert ishigami.settings.repair
    assert ishigami.objective_model > 0.998 * BEST_ISHIGAMI
    assert ishigami.verdict.word == "trusted"
    assert ishigami.counts["models_simulated"] < 150  # it ends where nothing is left to find
    assert "Verdict: trusted." in str(ishigami)


def test_the_verdict_comes_back_from_its_file(ishigami):
    document = check_comes_back(ishigami)
    told = {"word": "trusted", "reasons": [], "outlook": ishigami.verdict.outlook}
    assert document["verdict"] == told
    assert "What more runs would buy" in str(ishigami)
    assert SearchResult.from_json(ishigami.to_json()).verdict == ishigami.verdict
    document["verdict"]["word"] = "sure"
    with pytest.raises(ValueError, match=r"`verdict\.word`"):
        SearchResult.from_json(json.dumps(document))


def test_no_more_runs_than_allowed_and_in_batches():
    sizes = []

    def rough(x):
        sizes.append(len(x))
        return np.sin(40.0 * x).sum(axis=1)[:, None]

    how = SearchSettings(**HOW | {"repair_models": 30}, repair_batch=8)
    found = worst_case(own(rough), how)
    assert found.repair.n_models + found.repair.n_checked == 30
    assert sum(sizes) == 81  # 50, 30 and the nominal one
    assert sizes[50:] == [8, 8, 5, 2, *[1] * 7, 1] or sizes[1:4] == [8, 8, 5]
    assert found.verdict.word == "doubtful"


def test_outputs_in_any_order():
    """Outputs that rise and fall in turn: no pattern with one change of sign is theirs."""
    slopes = np.array([[3.0, 1.0, -2.0], [-1.0, 2.0, 1.0], [2.0, -3.0, 1.0], [-2.0, 1.0, 3.0]])

    def run(x):
        return x @ slopes.T

    corners = np.stack(np.meshgrid(*[[0.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
    y = corners @ slopes.T
    best = np.abs(y[:, None] - y).sum(axis=2).max()
    for order in ([0, 1, 2, 3], [0, 2, 1, 3]):
        found = worst_case(own(lambda x, o=order: run(x)[:, o], m=4), SearchSettings(**HOW))
        assert found.objective_model == pytest.approx(best, rel=1e-6)


def test_a_constant_model_has_no_pair():
    found = worst_case(own(lambda x: np.full((len(x), 1), 7.0)))
    assert found.verdict.word == "not found"
    assert found.repair.n_models == 0
    assert len(found.verdict.reasons) == 1


def test_a_model_that_fails_at_its_optimum_still_has_a_working_pair():
    def run(x):
        y = x.sum(axis=1)
        return np.where(y > 2.7, np.nan, y)[:, None]

    found = worst_case(own(run))
    assert np.isfinite(found.y).all()
    assert 2.4 < found.objective_model <= 2.7
    assert found.repair.n_failed > 0
    assert found.verdict.word == "doubtful"
    assert "fail" in str(found.verdict)


def test_huge_outputs():
    found = worst_case(own(lambda x: 1e200 * np.sin(4.0 * x).sum(axis=1)[:, None]))
    best = 3e200 * (1.0 - np.sin(4.0))
    assert found.objective_model == pytest.approx(best, rel=2e-3)
    assert found.verdict.word == "trusted"
    assert found.loo_rms is None


def test_noise_is_remarked():
    rng = np.random.default_rng(0)
    found = worst_case(own(lambda x: x[:, :1] + rng.normal(0.0, 1.0, (len(x), 1))))
    assert found.verdict.word == "doubtful"


def first_runs(d, max_runs=30):
    settings = SearchSettings(max_runs=max_runs).of(own(np.sin, d))
    return train(UnitModel(own(lambda x: x[:, :1], d)), settings).points


def test_few_runs_for_many_inputs_begin_at_corners_and_across_from_them():
    many = first_runs(20, 150)
    corners = np.round(many)
    assert len(many) == 50
    assert 0.0 < np.abs(many - corners).max() <= 0.01
    assert (corners[:25] == 1.0 - corners[25:]).all()
    assert len(np.unique(many, axis=0)) == 50


@pytest.mark.parametrize("d", [3, 8])  # enough runs; too few for corners to tell inputs apart
def test_other_first_runs_lie_inside(d):
    first = first_runs(d)
    assert len(first) == 10
    assert np.abs(first - np.round(first)).max() > 0.3


def test_two_inputs_are_thrown_together_and_none_twice():
    class Process:
        """Inputs 0 and 2 gain together, each of them loses alone."""

        lengths = np.ones(3)

        def __call__(self, u):
            lost = u[:, 0] + u[:, 2] + u[:, 1]
            return np.where((u == [1.0, 0.0, 1.0]).all(axis=1), 1.0, -lost), np.zeros(len(u))

    half, best = Half(np.ones(1), 1.0, 3), np.zeros(3)
    chosen = [thrown(Process(), half, best, own(None)).tolist() for _ in range(7)]
    assert chosen[0] == [1.0, 0.0, 1.0]
    assert chosen[-1] == [1.0, 1.0, 1.0]
    assert len({tuple(u) for u in chosen}) == 7


def test_same_seed_same_bytes():
    one, two = (worst_case(models.borehole(), SearchSettings(**HOW, seed=3)) for _ in range(2))
    assert one.training_x.tobytes() == two.training_x.tobytes()
    assert one.verdict == two.verdict


@pytest.mark.parametrize(("n", "d"), [(50, 28), (150, 7), (200, 150)])
def test_distances_are_those_of_all_differences_to_the_bit(n, d):
    x = np.random.default_rng(0).random((n, d))
    assert np.array_equal(_squared_distances(x), ((x[:, None] - x) ** 2).sum(axis=2))

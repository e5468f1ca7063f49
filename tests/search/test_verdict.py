"""Each doubt has its sentence, and a model made for it; the best working pair is offered."""

import numpy as np
import pytest
from models import ishigami
from results import check_comes_back

from kneecore import Input, Model, Output, SearchResult, SearchSettings, worst_case
from kneecore.search.verdict import Seen, judged

FINE = {
    "history": (0.9, 1.0, 1.0, 1.0, 1.0), "promised": 1.0, "possible": 1.01, "ranks": 0.99,
    "first_ranks": 0.95, "n_runs": 90, "n_inputs": 3,
}  # fmt: skip


def own(run, d=3, **options):
    inputs = [Input(f"x_{k}", lower=0.0, upper=1.0) for k in range(d)]
    return Model(run, inputs, [Output("y")], batched=True, **options)


def searched(run, d=3, **settings):
    return worst_case(
        own(run, d), SearchSettings(**{"training_samples": 30, "repair_models": 30} | settings)
    )


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"promised": 1.06}, "still promises 6 % more than any run has shown; allow more runs"),
        ({"history": (0.9, 0.9, 0.9, 0.9, 1.0)}, "still gained 10.0 %"),
        ({"ranks": 0.88}, "rank correlation of 0.88 only"),
        ({"first_ranks": 0.94, "n_inputs": 20}, "90 runs are few for 20 inputs"),
        ({"noise": 0.02}, "the model is noisy; fix its random seed"),
        ({"noise": np.inf}, "The pair run again failed"),
        ({"jump": 0.4, "jump_width": 1e-3}, "model jumps: between two runs 0.1 % of the bounds"),
        ({"error": 0.5}, "the model is rough there"),
        ({"n_failed": 20}, "20 of 90 runs failed"),
        ({"n_failed_best": 2, "n_failed": 20}, "this one is the best that works"),
    ],
)  # fmt: skip
def test_each_doubt_has_one_sentence(change, said):
    assert judged(Seen(**FINE)).word == "trusted"
    verdict = judged(Seen(**FINE | change))
    assert verdict.word == "doubtful"
    assert len(verdict.reasons) == 1
    assert said in verdict.reasons[0]


def test_what_more_runs_would_buy():
    told = judged(Seen(**FINE | {"possible": 1.25})).outlook
    assert "the surrogate promises 0.0 % more; 25 % is within two standard deviations" in told


def test_noise():
    rng = np.random.default_rng(0)
    found = searched(lambda x: x.sum(axis=1, keepdims=True) + rng.normal(0.0, 0.02, (len(x), 1)))
    assert found.verdict.word == "doubtful"
    assert "noisy" in str(found.verdict)
    assert "jumps" not in str(found.verdict)
    check_comes_back(found)


def test_a_jump():
    found = searched(lambda x: x[:, :1] + 0.1 * x[:, 1:2] + 2.0 * (x[:, 2:] > 0.613))
    assert found.verdict.word == "doubtful"
    assert "The model jumps" in str(found.verdict)
    assert "noisy" not in str(found.verdict)
    assert found.repair.n_checked == 9
    assert found.counts["models_simulated"] <= 61
    check_comes_back(found)


def test_a_steep_model_is_no_jump():
    found = searched(lambda x: np.tanh(30.0 * (x[:, :1] - 0.5)) + 0.1 * x[:, 1:2])
    assert "jumps" not in str(found.verdict)


def test_failures_at_the_optimum():
    def run(x):
        y = x.sum(axis=1, keepdims=True)
        return np.where(y > 2.7, np.nan, y)

    found = searched(run)
    assert found.verdict.word == "doubtful"
    assert "failed where more was promised" in str(found.verdict)
    assert np.isfinite(found.y).all()


@pytest.mark.parametrize("method", ["ga", "exact"])
def test_without_a_repair_the_best_working_pair_is_offered(method):
    def run(x):
        y = x.sum(axis=1, keepdims=True)
        return np.where(y > 2.7, np.nan, y)

    small = {"pop_size": 40, "n_generations": 30} if method == "ga" else {}
    found = worst_case(own(run), SearchSettings(method=method, repair=False, **small))
    assert np.isfinite(found.y).all()
    assert found.objective_model == pytest.approx(np.ptp(found.training_y[:, 0][np.isfinite(
        found.training_y[:, 0])]))  # fmt: skip
    assert found.verdict.word == "doubtful"
    assert "this one is the best that works" in str(found.verdict)
    text = found.to_json()
    assert SearchResult.from_json(text).to_json() == text


def test_without_a_repair_the_gap_is_told():
    found = worst_case(ishigami(), SearchSettings(repair=False, method="exact"))
    assert found.gap_percent < -5.0
    assert f"is {-found.gap_percent:.0f} % below what the model says" in str(found.verdict)

"""A failed run is a row with its reason; nothing else is lost by it."""

import numpy as np
import pytest
from run_models import PAIR, SQUARE, Failing, many, plain, points, square

import kneecore
from kneecore import Input, Model, ModelError, Output, ParameterError, SamplingSettings

X = points(40)
BAD = X[:, 0] > 0.8
KINDS = {
    "raises": ("raised", "raised ValueError: no convergence"),
    "exits": ("raised", "raised SystemExit: enough"),
    "nan": ("nan", "returned NaN or infinity for 1 of 2 outputs"),
    "shape": ("returned", "`run` returned shape (3,) for one point; (2,) is allowed; `outputs` "
              "names 2"),
    "complex": ("returned", "`run` returned complex numbers; real numbers are allowed"),
    "ragged": ("returned", "`run` returned a ragged array; numbers in rows are allowed"),
    "text": ("returned", "`run` returned 'broken'; an array of numbers is allowed"),
}  # fmt: skip


@pytest.mark.parametrize("how", KINDS)
@pytest.mark.parametrize("workers", [None, 2])
def test_a_failed_run_is_a_row_with_its_reason(how, workers):
    model = square(Failing(how), workers=workers)
    done = model.examine(X)
    model.close()
    assert done.counts["failed"] == np.count_nonzero(BAD) > 3
    np.testing.assert_array_equal(done.y[~BAD], [plain(x) for x in X[~BAD]])
    assert np.isnan(done.y[BAD][:, 0]).all()
    assert [f.number for f in model.failures] == (np.flatnonzero(BAD) + 1).tolist()
    np.testing.assert_array_equal([f.x for f in model.failures], X[BAD])
    assert {(f.kind, f.message) for f in model.failures} == {KINDS[how]}
    assert ("in raises" in model.failures[0].traceback) == (how == "raises")


def test_numbers_of_runs_go_on():
    model = square(Failing("raises"))
    for _ in range(2):
        model.evaluate(X)
    first, second = np.array([f.number for f in model.failures]).reshape(2, -1)
    assert (second - first == len(X)).all()
    assert str(model.failures[0]) == f"run {first[0]} raised ValueError: no convergence"


@pytest.mark.parametrize("workers", [None, 2])
def test_the_first_failure_can_end_everything(workers):
    model = square(Failing("raises"), on_failure="abort", workers=workers)
    number = np.flatnonzero(BAD)[0] + 1
    with pytest.raises(ModelError) as error:
        model.evaluate(X)
    model.close()
    assert str(error.value) == f"run {number} raised ValueError: no convergence"


@pytest.mark.parametrize("workers", [None, 2])
def test_a_model_that_cannot_be_run_at_all_is_told_at_once(workers):
    model = square(Failing("raises", above=-1.0), workers=workers)
    with pytest.raises(ModelError, match=r"^run 3 raised ValueError: no convergence; all of"):
        model.evaluate(X)
    model.close()
    model = square(Failing("shape", above=-1.0), workers=workers)
    with pytest.raises(ParameterError, match=r"returned shape \(3,\) for one point"):
        model.evaluate(X)
    model.close()


def test_a_batch_loses_the_rows_alone_that_fail():
    def run(x):
        if (x[:, 0] > 0.8).any():
            raise ValueError("one of them")
        return many(x)

    model = square(run, batched=True)
    done = model.examine(X)
    assert (np.isnan(done.y).any(axis=1) == BAD).all()
    np.testing.assert_array_equal(done.y[~BAD], many(X[~BAD]))
    assert [f.number for f in model.failures] == (np.flatnonzero(BAD) + 1).tolist()


def test_retries():
    calls = []

    def run(x):
        calls.append(x[0])
        if x[0] > 0.8 and calls.count(x[0]) < 3:
            raise RuntimeError("licence server")
        return plain(x)

    model = square(run, retries=2)
    done = model.examine(X)
    assert np.isfinite(done.y).all()
    assert done.counts == {"failed": 0, "retried": np.count_nonzero(BAD)}
    calls.clear()
    model = square(run, retries=1)
    assert model.examine(X).counts["failed"] == np.count_nonzero(BAD)
    assert {f.tries for f in model.failures} == {2}


def test_a_batch_is_tried_again_too():
    calls = []

    def run(x):
        calls.append(len(x))
        if len(calls) == 1:
            raise RuntimeError("licence server")
        return many(x)

    model = square(run, batched=True, retries=1)
    assert model.examine(X).counts == {"failed": 0, "retried": len(X)}
    assert calls == [len(X)] * 2


class Own(Model):
    """Examines in a way of its own, and knows of no watch."""

    def examine(self, x, *, observe=False):
        return super().examine(x)


def test_a_model_with_an_examination_of_its_own_is_searched_and_sampled():
    own, usual = (kind(plain, SQUARE, PAIR) for kind in (Own, Model))
    how = kneecore.SearchSettings(training_samples=6, method="exact")
    found = [kneecore.worst_case(m, how, callback=lambda _: False).x for m in (own, usual)]
    np.testing.assert_array_equal(*found)
    settings = SamplingSettings(n_samples=30)
    sampled = [kneecore.monte_carlo(m, settings).y.mean for m in (own, usual)]
    np.testing.assert_array_equal(*sampled)


def test_a_search_tells_why_all_failed():
    model = square(lambda x: [np.nan, 1.0])
    with pytest.raises(ModelError) as error:
        kneecore.worst_case(model, kneecore.SearchSettings(training_samples=4))
    assert str(error.value) == (
        "4 of 4 training samples failed; the surrogate needs 3 that did not; run 4 returned NaN or "
        "infinity for 1 of 2 outputs"
    )


def test_a_report_tells_why_runs_failed():
    found = kneecore.worst_case(
        square(Failing("raises", above=0.7)),
        kneecore.SearchSettings(training_samples=30, pop_size=20, n_generations=3),
    )
    first = found.model.failures[0]
    assert f"Failed: run {first.number} raised ValueError: no convergence.\n" in str(found)
    n = found.counts["models_failed"]
    assert f"All {n} are in `model.failures`." in str(found)
    assert len(found.model.failures) == n > 3
    study = kneecore.monte_carlo(square(Failing("nan")), SamplingSettings(n_samples=20))
    assert "returned NaN or infinity for 1 of 2 outputs." in str(study)


def test_one_failed_output_costs_that_output():
    settings = SamplingSettings(n_samples=3000)
    gappy = kneecore.monte_carlo(square(Failing("nan")), settings)
    whole = kneecore.monte_carlo(square(), settings)
    assert (gappy.counts["failed"], whole.counts) == (0, {"failed": 0})
    n = gappy.counts["partial"]
    assert gappy.n_used.tolist() == [3000 - n, 3000]
    assert whole.n_used is None
    assert 500 < n < 700
    # The second output has all its samples; the first those where it was known.
    assert gappy.y.mean[1] == pytest.approx(
        whole.y.mean[1] + np.mean(_second_of_failed(3000)), rel=1e-12
    )
    assert gappy.y.percentile_upper[0] < whole.y.percentile_upper[0]
    again = kneecore.MonteCarloResult.from_json(gappy.to_json())
    assert again.n_used.tolist() == gappy.n_used.tolist()
    assert "with some of their outputs only" in str(again)


def _second_of_failed(n):
    x = np.random.default_rng(0).random((n, 2)) * [1.0, 2.0]
    return np.where(x[:, 0] > 0.8, x.sum(axis=1) - x[:, 0] * x[:, 1], 0.0)


def test_an_output_that_is_never_known_is_told_as_unknown():
    study = kneecore.monte_carlo(
        Model(lambda x: [np.nan, x[0]], SQUARE, PAIR), SamplingSettings(n_samples=50)
    )
    assert np.isnan(study.y.mean[0])
    assert study.counts == {"failed": 0, "partial": 50}
    assert np.isfinite(study.y.mean[1])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"workers": 0}, "`workers` is 0; a whole number from 1, the address of a scheduler, or an "
         "executor with `submit` or `map` is allowed"),
        ({"workers": 1.5}, "`workers` is 1.5; a whole number from 1"),
        ({"workers": "four"}, "`workers` is 'four'; a number, an executor or the address of a "
         "scheduler such as 'tcp://host:8786' is allowed"),
        *(({"workers": a}, f"`workers` is '{a}'; a number, an executor or the address of a sch")
          for a in ("tcp://host", "nothing://host:1", "tcp://:1", "tcp://a b:1", "http://a:80/x",
                    "tcp://host:1 ", "tcp://host:123456")),
        ({"timeout_s": 0}, "`timeout_s` is 0 s; above 0 is allowed"),
        ({"timeout_s": "1"}, "`timeout_s` is '1'; a finite number of at most"),
        ({"on_failure": "ignore"}, "`on_failure` is 'ignore'; 'continue' or 'abort' is allowed"),
        ({"retries": -1}, "`retries` is -1; a whole number from 0 to 100 is allowed"),
        ({"rerun_failures": 1}, "`rerun_failures` is 1; True or False is allowed"),
        ({"keep": 3}, "`keep` is 3; the name of a file is allowed"),
    ],
)  # fmt: skip
def test_how_runs_are_done_is_checked(options, said):
    with pytest.raises(ParameterError) as error:
        square(**options)
    assert str(error.value).startswith(said)
    with pytest.raises(ParameterError):
        square().with_runs(**options)


def test_options_of_runs_are_known():
    with pytest.raises(ParameterError, match="`threads` is no option of runs; workers, keep"):
        square().with_runs(threads=2)
    with pytest.raises(ParameterError, match="`keep` is 'runs'; this model is run faster"):
        kneecore.Knee().with_runs(keep="runs")


def test_an_empty_list_of_points():
    assert square().evaluate(np.empty((0, 2))).shape == (0, 2)


def test_a_run_that_is_watched_is_cancelled():
    seen = []

    def watch(done):
        seen.append(done)
        return done > 10

    with pytest.raises(kneecore.Cancelled):
        square(lambda x: plain(x)).examine(np.tile(X, (50, 1)), watch=watch)
    assert seen[0] <= 10 < seen[-1] < 2000


def test_a_training_that_is_cancelled_ends_between_runs():
    reports = []

    def callback(report):
        reports.append(report)
        return report.stage == "sampling" and report.done > 3

    model = Model(Failing("hangs", above=2.0), [Input("a", lower=0.0, upper=1.0), *SQUARE[1:]],
                  [Output("y", axis=(1, 2))])  # fmt: skip
    with pytest.raises(kneecore.Cancelled):
        kneecore.worst_case(
            model, kneecore.SearchSettings(training_samples=2000), callback=callback
        )
    assert reports[-1].done < 2000

"""Every study of models that are no knee: Ishigami, Borehole, and a filter with two outputs."""

import dataclasses
import json

import numpy as np
import pytest
from study_models import (
    ISHIGAMI_FIRST,
    ISHIGAMI_LEAST,
    ISHIGAMI_MEAN,
    ISHIGAMI_MOST,
    ISHIGAMI_TOTAL,
    ISHIGAMI_VARIANCE,
    Filter,
    borehole,
    corner_values,
    ishigami,
)

import kneecore
from kneecore import (
    AccuracyAllocationSettings,
    BoundSweepSettings,
    Cancelled,
    InfluenceSettings,
    Input,
    Model,
    ModelError,
    NeededAccuracySettings,
    Output,
    ParameterError,
    SamplingSettings,
    SearchSettings,
    SurrogateQualitySettings,
    TrainingSweepSettings,
)

MODELS = {"ishigami": ishigami, "borehole": borehole, "filter": Filter}
SLICES = {"ishigami": ("x_1", "x_3"), "borehole": ("r_w", "H_u"), "filter": ("L", "C")}
GOALS = {"ishigami": 9.0, "borehole": 200.0, "filter": -1.0}
EASY = GOALS | {"borehole": 400.0}  # many searches of it take long


@pytest.fixture(scope="module", params=MODELS)
def name(request):
    return request.param


@pytest.fixture(scope="module")
def results(name):
    """Return one small result of each study."""
    model = MODELS[name]()
    worst = kneecore.worst_case(model, SearchSettings(pop_size=40, n_generations=40))
    sampled = kneecore.monte_carlo(model, SamplingSettings(n_samples=2000), marks=worst.y)
    surrogate = kneecore.fit_surrogate(model)
    return {
        "monte_carlo": sampled,
        "comparison": kneecore.compare_with_sampling(worst, sampled),
        "influence": kneecore.influence(model, InfluenceSettings(n_base=64)),
        "landscape": kneecore.landscape(model, SLICES[name], surrogate=surrogate, n_points=5),
        "bound_sweep": kneecore.bound_sweep(model, BoundSweepSettings(sizes=(0.5, 1.0))),
        "needed_accuracy": kneecore.needed_accuracy(
            model, NeededAccuracySettings(within=GOALS[name], largest=1.0, tolerance=0.1)
        ),
        "accuracy_allocation": kneecore.accuracy_allocation(
            model, AccuracyAllocationSettings(within=EASY[name], tolerance=0.5)
        ),
        "training_sweep": kneecore.training_sweep(
            model, TrainingSweepSettings(sizes=(30, 60), n_seeds=2, method="exact")
        ),
        "surrogate_quality": kneecore.surrogate_quality(
            model, SurrogateQualitySettings(n_test=200)
        ),
    }


KINDS = (
    "monte_carlo",
    "comparison",
    "influence",
    "landscape",
    "bound_sweep",
    "needed_accuracy",
    "accuracy_allocation",
    "training_sweep",
    "surrogate_quality",
)


@pytest.mark.parametrize("kind", KINDS)
class TestEveryResult:
    def test_is_told(self, results, kind):
        result = results[kind]
        text = str(result)
        assert result.summary().count("\n") == 0
        assert result.summary().endswith(".")
        column = result.model.columns[result.model.watched]
        assert column.output.name in text or kind == "training_sweep"
        assert "knee" not in text
        assert "…" not in text
        assert "<pre" in result._repr_html_()

    def test_comes_back_to_the_byte(self, results, kind, tmp_path):
        result = results[kind]
        written = [path.name for path in result.save(tmp_path / "a")]
        assert written[-1].endswith(".json")
        for again in (
            kneecore.load(tmp_path / "a"),
            type(result).load(tmp_path / "a" / written[-1]),
        ):
            assert type(again) is type(result)
            assert again.to_json() == result.to_json()
            assert str(again) == str(result)
        assert json.loads(result.to_json())["model"]["name"] == result.model.name

    def test_is_drawn(self, results, kind, tmp_path):
        result = results[kind]
        figures = result.figures()
        assert figures
        written = {path.name for path in result.save(tmp_path / "a")}
        assert {f"{name}.{kind_of}" for name in figures for kind_of in ("png", "svg")} <= written
        texts = [axes.get_ylabel() + axes.get_xlabel() for f in figures.values() for axes in f.axes]
        assert any(texts)
        assert "knee" not in "".join(texts)
        again = type(result).from_json(result.to_json())
        assert set(again.figures()) == set(figures)

    def test_files_of_strangers_are_refused_in_a_sentence(self, results, kind):
        result = results[kind]
        document = result.to_dict()
        derived = {"answer", "n_searches", "share_of_outputs_outside"}
        derived |= {"equal_cost", "cheapest_cost"}
        settings = {"samples", "sampling", "base_samples", "intervals", "training_samples"}
        settings |= {"seed", "test_points", "column"}  # the usual ones where there are none
        settings |= {"counts", "marks"}  # files of before have none
        for key in document.keys() - derived - settings:
            broken = {k: v for k, v in document.items() if k != key}
            with pytest.raises(kneecore.FileFormatError) as refused:
                type(result).from_json(json.dumps(broken))
            assert "\n" not in str(refused.value)
        with pytest.raises(kneecore.FileFormatError, match="`schema` is None"):
            type(result).from_json("{}")
        with pytest.raises(kneecore.FileFormatError):
            type(result).from_json(json.dumps(document | {"model": {"name": "x"}}))


class TestIshigami:
    def test_moments(self):
        found = kneecore.monte_carlo(ishigami(), SamplingSettings(n_samples=4096, sampling="sobol"))
        assert found.y.mean[0] == pytest.approx(ISHIGAMI_MEAN, abs=0.02)
        assert found.y.sd[0] == pytest.approx(np.sqrt(ISHIGAMI_VARIANCE), rel=0.01)
        assert found.counts == {"failed": 0}
        assert found.observed == {}

    def test_indices_are_the_analytic_ones(self):
        found = kneecore.influence(ishigami(), InfluenceSettings(n_base=4096, intervals=False))
        np.testing.assert_allclose(found.indices.first_order[0], ISHIGAMI_FIRST, atol=0.02)
        np.testing.assert_allclose(found.indices.total_order[0], ISHIGAMI_TOTAL, atol=0.02)
        assert found.deciding(0) == ["x_1", "x_2", "x_3"]
        assert found.groups == {}
        assert found.summary().startswith("x_1, x_2 and x_3 decide y: alone they explain 7")

    def test_a_slice_is_the_function(self):
        found = kneecore.landscape(ishigami(), ("x_3", "x_1"), n_points=9)
        three, one = np.meshgrid(*found.axes, indexing="ij")
        np.testing.assert_allclose(
            found.y[..., 0], np.sin(one) * (1.0 + 0.1 * three**4), atol=1e-12
        )
        elsewhere = kneecore.landscape(ishigami(), ("x_3", "x_1"), x=[0, np.pi / 2, 0], n_points=9)
        np.testing.assert_allclose(elsewhere.y, found.y + 7.0)

    def test_bounds_around_the_middle(self):
        """At 1 the extremes are inside of the bounds, where only a search in the model finds them;
        a repaired surrogate comes near them, and never beyond."""
        sweep = kneecore.bound_sweep(ishigami(), BoundSweepSettings(sizes=(0.25, 1.0)))
        assert not sweep.in_model
        assert ISHIGAMI_LEAST - 1e-9 <= sweep.extremes[1, 0] < 0.95 * ISHIGAMI_LEAST
        assert 0.95 * ISHIGAMI_MOST < sweep.extremes[1, 1] <= ISHIGAMI_MOST + 1e-9
        assert sweep.objective[1] == pytest.approx(sweep.pair[1, 1] - sweep.pair[1, 0])
        assert (sweep.extremes[:, 0] <= sweep.pair[:, 0]).all()
        assert (sweep.extremes[:, 1] >= sweep.pair[:, 1]).all()
        # To a quarter of the bounds the largest is 7 sin^2 (pi / 4) and what x_1 and x_3 add.
        quarter = np.pi / 4
        most = np.sin(quarter) * (1.0 + 0.1 * quarter**4) + 7.0 * np.sin(quarter) ** 2
        assert sweep.extremes[0, 1] == pytest.approx(most, rel=1e-3)

    def test_exact_gradients_are_used_where_the_model_has_them(self):
        def gradient(x):
            one, two, three = x.T
            factor = 1.0 + 0.1 * three**4
            slopes = [
                np.cos(one) * factor,
                7.0 * np.sin(2.0 * two),
                0.4 * three**3 * np.sin(one),
            ]
            return np.stack(slopes, axis=1)[:, None]

        plain = ishigami()
        model = Model(
            lambda x: plain.evaluate(x),
            plain.inputs,
            plain.outputs,
            batched=True,
            gradient=gradient,
        )
        sweep = kneecore.bound_sweep(model, BoundSweepSettings(sizes=(1.0,)))
        assert sweep.in_model
        np.testing.assert_allclose(sweep.extremes[0], [ISHIGAMI_LEAST, ISHIGAMI_MOST], rtol=1e-6)
        assert "Exact searches" in str(sweep)


class TestBorehole:
    """It is monotone in each input: its extremes are in corners."""

    def test_worst_cases_are_the_corners(self):
        model = borehole()
        sweep = kneecore.bound_sweep(model, BoundSweepSettings(sizes=(0.3, 0.9)))
        for k, size in enumerate((0.3, 0.9)):
            corners = corner_values(model.with_size(size))
            assert sweep.objective[k] == pytest.approx(np.ptp(corners), rel=2e-3)
            np.testing.assert_allclose(sweep.extremes[k], [corners.min(), corners.max()], rtol=2e-2)

    def test_needed_accuracy_is_where_a_corner_passes_the_goal(self):
        settings = NeededAccuracySettings(within=200.0, largest=1.0, tolerance=0.01)
        need = kneecore.needed_accuracy(borehole(), settings)
        assert need.beyond - need.size <= 0.01
        assert need.largest_value <= 200.0 < need.beyond_value
        assert corner_values(borehole().with_size(need.beyond + 0.01)).max() > 200.0
        assert corner_values(borehole().with_size(need.size - 0.01)).max() < 200.0
        assert need.sampled_value <= need.largest_value
        assert need.n_searches == len(need.tried)
        assert "flow is at most 200 m3/yr" in need.summary()

    def test_what_decides(self):
        found = kneecore.influence(borehole(), InfluenceSettings(n_base=1024))
        assert found.deciding(0, 1) == ["r_w"]
        assert found.indices.total_order[0, 0] == pytest.approx(0.87, abs=0.05)

    def test_more_runs_make_a_better_surrogate(self):
        qualities = [
            kneecore.surrogate_quality(borehole(), SurrogateQualitySettings(training_samples=n))
            for n in (20, 200)
        ]
        few, many = qualities
        assert few.explained[0] < many.explained[0]
        assert few.rank_f < many.rank_f
        assert few.rms_error[0] > many.rms_error[0]
        # Leave-one-out errors tell of new points before there are any.
        assert many.loo_rms[0] == pytest.approx(many.rms_error[0], rel=0.5)

    def test_a_training_sweep_is_judged_as_one_surrogate_is(self):
        settings = TrainingSweepSettings(sizes=(40,), n_seeds=1, method="exact")
        sweep = kneecore.training_sweep(borehole(), settings)
        alone = kneecore.surrogate_quality(
            borehole(), SurrogateQualitySettings(training_samples=40)
        )
        assert sweep.rank_f[0, 0] == alone.rank_f
        assert sweep.rms_error[0, 0] == pytest.approx(alone.rms_error[0])
        search = SearchSettings(
            method="exact", search_space="surrogate", training_samples=40, repair=False
        )
        worst = kneecore.worst_case(borehole(), search)
        assert sweep.objective_model[0, 0] == worst.objective_model
        assert sweep.gap_percent[0, 0] == pytest.approx(worst.gap_percent)


class Observing(Model):
    """A model that tells of more than its outputs."""

    def examine(self, x, *, observe=False):
        done = super().examine(x)
        if not observe:
            return done
        return dataclasses.replace(done, observed={"force_n": np.stack([x[:, 0], x[:, 0]], axis=1)})


def failing(x):
    return [np.nan if x[0] > 0.8 else x[0] + x[1]]


SQUARE = [Input("a", lower=0.0, upper=1.0), Input("b", lower=0.0, upper=1.0)]


class TestOddModels:
    def test_what_is_observed_is_spread_too_and_comes_back(self):
        model = Observing(failing, SQUARE, [Output("y")])
        found = kneecore.monte_carlo(model, SamplingSettings(n_samples=500))
        assert 0 < found.n_failed < 500
        assert found.observed["force_n"].mean.shape == (2,)
        assert found.observed["force_n"].percentile_upper.max() <= 0.8
        again = kneecore.MonteCarloResult.from_json(found.to_json())
        assert again.to_json() == found.to_json()
        np.testing.assert_array_equal(again.observed["force_n"].sd, found.observed["force_n"].sd)

    def test_failures_leave_holes_in_a_slice(self):
        found = kneecore.landscape(Model(failing, SQUARE, [Output("y")]), ("a", "b"), n_points=6)
        assert (found.n_models, found.n_failed) == (36, 6)
        again = kneecore.Landscape.from_json(found.to_json())
        np.testing.assert_array_equal(again.y, found.y)
        assert "6 failed" in str(again)
        assert set(again.figures()) == {"figure_landscape"}

    def test_marks_are_placed_among_the_samples(self):
        model = Model(lambda x: [x[0]], SQUARE, [Output("y")])
        found = kneecore.monte_carlo(model, SamplingSettings(n_samples=2000), marks=[[0.25], [2.0]])
        np.testing.assert_allclose(found.below, [[0.25], [1.0]], atol=0.03)

    def test_an_output_that_does_not_vary(self):
        model = Model(
            lambda x: [x[0], 3.0], SQUARE, [Output("y"), Output("fixed")], name="half fixed"
        )
        quality = kneecore.surrogate_quality(model, SurrogateQualitySettings(n_test=50))
        assert np.isnan(quality.explained[1])
        assert np.isnan(quality.judgement.rank[1])
        found = kneecore.influence(model, InfluenceSettings(n_base=16))
        assert found.deciding(0)[0] == "a"
        worst = kneecore.worst_case(model, SearchSettings(pop_size=20, n_generations=10))
        compared = kneecore.compare_with_sampling(worst, kneecore.monte_carlo(model))
        for result in (quality, found, compared):
            again = type(result).from_json(result.to_json())
            assert again.to_json() == result.to_json()
            assert str(again) == str(result)
            assert result.figures()

    def test_small_numbers_keep_their_digits_in_files(self):
        model = Model(lambda x: [1e-14 * x[0]], SQUARE, [Output("y")])
        found = kneecore.monte_carlo(model, SamplingSettings(n_samples=100))
        again = kneecore.MonteCarloResult.from_json(found.to_json())
        assert again.y.mean[0] == found.y.mean[0] > 0.0

    def test_a_loaded_model_is_not_run(self):
        found = kneecore.monte_carlo(borehole(), SamplingSettings(n_samples=50))
        again = kneecore.MonteCarloResult.from_json(found.to_json())
        with pytest.raises(ModelError, match="was read from a file"):
            kneecore.monte_carlo(again.model)

    def test_threads_and_runs_change_no_byte(self):
        texts = []
        for _ in range(2):
            found = kneecore.influence(Filter(), InfluenceSettings(n_base=32))
            document = found.to_dict()
            del document["seconds"]
            texts.append(json.dumps(document))
        assert texts[0] == texts[1]

    def test_groups_and_what_is_watched_come_back(self):
        found = kneecore.influence(Filter(), InfluenceSettings(n_base=64, intervals=False))
        assert set(found.groups) == {"storage", "loss"}
        again = kneecore.InfluenceResult.from_json(found.to_json())
        assert again.model.watched == 2
        assert again.summary() == found.summary()
        assert "decide gain at 41000 Hz" in found.summary()


@pytest.mark.parametrize("verb", ["influence", "landscape", "bounds", "quality", "training"])
def test_a_callback_cancels(verb):
    calls = {
        "influence": lambda stop: kneecore.influence(ishigami(), callback=stop),
        "landscape": lambda stop: kneecore.landscape(ishigami(), ("x_1", "x_2"), callback=stop),
        "bounds": lambda stop: kneecore.bound_sweep(ishigami(), callback=stop),
        "quality": lambda stop: kneecore.surrogate_quality(ishigami(), callback=stop),
        "training": lambda stop: kneecore.training_sweep(ishigami(), callback=stop),
    }
    with pytest.raises(Cancelled):
        calls[verb](lambda report: True)


def test_a_bound_sweep_is_cancelled_within_a_search():
    stages = []

    def stop(report):
        stages.append(report.done)
        return len(stages) > 6

    with pytest.raises(Cancelled):
        kneecore.bound_sweep(ishigami(), BoundSweepSettings(sizes=(1.0,)), callback=stop)
    assert len(stages) < 12


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: kneecore.monte_carlo(3), "`model` is 3; a kneecore.Model is allowed"),
        (lambda: kneecore.monte_carlo(ishigami(), 100), "`settings` is 100"),
        (lambda: kneecore.monte_carlo(ishigami(), marks=[1.0, 2.0]), "(k, 1) is allowed"),
        (lambda: kneecore.monte_carlo(ishigami(), marks="high"), "`marks` is not an array"),
        (lambda: SamplingSettings(n_samples=0), "`n_samples` is 0"),
        (lambda: SamplingSettings(sampling="grid"), "`sampling` is 'grid'"),
        (lambda: InfluenceSettings(n_base=True), "`n_base` is True"),
        (lambda: InfluenceSettings(intervals=1), "`intervals` is 1"),
        (lambda: kneecore.influence(ishigami(), callback="x"), "`callback` is 'x'"),
        (lambda: kneecore.landscape(ishigami(), ("x_1", "x_9")), "`names` is ('x_1', 'x_9')"),
        (lambda: kneecore.landscape(ishigami(), "x_1"), "`names` is 'x_1'"),
        (lambda: kneecore.landscape(ishigami(), ("x_1", ["x_2"])), "`names` is ('x_1', ['x_2'])"),
        (lambda: kneecore.landscape(Filter(), ("L", "T")), "free inputs are allowed: L, C, R"),
        (lambda: kneecore.landscape(ishigami(), ("x_1", "x_2"), x=[1, 2]), "`x` has shape (2,)"),
        (lambda: kneecore.landscape(ishigami(), ("x_1", "x_2"), x=[1, 2, np.inf]), "finite"),
        (
            lambda: kneecore.landscape(ishigami(), ("x_1", "x_2"), surrogate=3),
            "kneecore.fit_surrogate returns is allowed",
        ),
        (lambda: BoundSweepSettings(sizes=[0.0]), "`sizes` is 0; a number above 0"),
        (lambda: BoundSweepSettings(sizes="wide"), "`sizes` is 'wide'"),
        (lambda: BoundSweepSettings(sizes=["a"]), "`sizes` is 'a'; a finite number"),
        (lambda: kneecore.needed_accuracy(ishigami()), "the largest value of 'y'"),
        (lambda: TrainingSweepSettings(sizes=[40], n_seeds=-1), "`n_seeds` is -1"),
        (
            lambda: kneecore.training_sweep(ishigami(), TrainingSweepSettings(sizes=[3])),
            "`training_samples` is 3",
        ),
        (lambda: SurrogateQualitySettings(n_test=3), "`n_test` is 3; at least 4"),
        (
            lambda: kneecore.surrogate_quality(
                borehole(), SurrogateQualitySettings(training_samples=5)
            ),
            "`training_samples` is 5",
        ),
    ],
)
def test_refused_in_a_sentence(call, said):
    with pytest.raises(ParameterError) as refused:
        call()
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_only_what_is_computed_alike_is_compared():
    worst = kneecore.worst_case(borehole(), SearchSettings(pop_size=20, n_generations=5))
    sampled = kneecore.monte_carlo(borehole().with_size(0.5), SamplingSettings(n_samples=50))
    with pytest.raises(ParameterError, match="other bounds"):
        kneecore.compare_with_sampling(worst, sampled)
    sampled = kneecore.monte_carlo(borehole(), SamplingSettings(n_samples=50))
    with pytest.raises(ParameterError, match="`objective` is 'up'"):
        kneecore.compare_with_sampling(worst, sampled).share_outside("up")


def test_a_model_that_always_fails_is_told():
    model = Model(lambda x: [np.nan], SQUARE, [Output("y")])
    for verb in (
        kneecore.monte_carlo,
        kneecore.influence,
        kneecore.bound_sweep,
        kneecore.surrogate_quality,
        kneecore.training_sweep,
    ):
        with pytest.raises(ModelError) as told:
            verb(model)
        assert "\n" not in str(told.value)

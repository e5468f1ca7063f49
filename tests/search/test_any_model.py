"""Models that nobody here wrote, through every door that a search's result has."""

import csv
import io
import itertools
import json
from dataclasses import replace

import jsonschema
import models
import numpy as np
import pytest
from results import SCHEMA, check_comes_back

import kneecore
from kneecore import (
    Input,
    Model,
    ModelError,
    Output,
    ParameterError,
    SearchResult,
    SearchSettings,
    compare_methods,
    with_methods,
    worst_case,
)
from kneecore.files.search import curves_csv
from kneecore.report.command import command_line

IN_MODEL = {"search_space": "model", "pop_size": 60, "n_generations": 60}


def worst_on(model, points):
    """Return f of the best pair among points of the unit cube, by brute force."""
    y = model.evaluate(model.from_free_unit(points)) * model.weights()
    return float(max(np.abs(one - y).sum(axis=1).max() for one in y))


def corners(model):
    return np.array(list(itertools.product([0.0, 1.0], repeat=model.n_free)))


@pytest.fixture(scope="module")
def ishigami_best():
    """A grid of 37^3 points that has the corners, the middles and the quarters in it."""
    model = models.ishigami()
    side = np.linspace(0.0, 1.0, 37)
    grid = np.array(list(itertools.product(side, repeat=3)))
    best = float(np.ptp(model.evaluate(model.from_free_unit(grid))))
    assert best == pytest.approx(9.0 + 0.2 * np.pi**4, rel=1e-12)  # by hand
    return best


@pytest.fixture(scope="module")
def borehole_best():
    """The flow rises or falls with each input, so that a corner is the worst."""
    model = models.borehole()
    best = worst_on(model, corners(model))
    inside = np.random.default_rng(0).random((4000, 8))
    assert np.ptp(model.evaluate(model.from_free_unit(inside))) < best
    return best


def test_ishigamis_gradient_equals_central_differences():
    x = np.random.default_rng(1).uniform(-np.pi, np.pi, (20, 3))
    h = 1e-5
    for k, step in enumerate(h * np.eye(3)):
        difference = (models.ishigami_y(x + step) - models.ishigami_y(x - step)) / (2.0 * h)
        np.testing.assert_allclose(models.ishigami_gradient(x)[:, :, k], difference, atol=1e-6)


# Ishigami: waves inside the bounds.


def test_climbs_with_ishigamis_gradient_find_the_worst_pair(ishigami_best):
    model = models.ishigami(gradient=models.ishigami_gradient)
    for seed in range(5):
        found = worst_case(model, SearchSettings(method="exact", seed=seed))
        assert found.settings.search_space == "model"
        assert found.objective_surrogate is None
        assert found.objective_model == pytest.approx(ishigami_best, rel=1e-9)
        np.testing.assert_allclose(np.abs(found.x[:, 0]), np.pi / 2, atol=1e-4)
        assert found.evidence.n_evaluations > 0


@pytest.mark.parametrize("seed", range(3))
def test_the_genetic_algorithm_in_the_model_finds_ishigamis(seed, ishigami_best):
    found = worst_case(models.ishigami(), SearchSettings(seed=seed, **IN_MODEL))
    assert found.objective_model == pytest.approx(ishigami_best, rel=1e-3)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("method", ["ga", "exact"])
def test_repair_finds_ishigamis_where_fifty_samples_do_not(seed, method, ishigami_best):
    """What holds: the plain surrogate is far off, the repaired one is not."""
    settings = SearchSettings(
        method=method, search_space="surrogate", seed=seed, repair=False, training_samples=50
    )
    plain = worst_case(models.ishigami(), settings)
    assert plain.objective_model <= ishigami_best
    repaired = worst_case(models.ishigami(), replace(settings, repair=True, repair_models=40))
    assert 0.99 * ishigami_best < repaired.objective_model <= ishigami_best
    assert plain.objective_model < 0.95 * ishigami_best
    assert repaired.repair.n_models <= 40


# Borehole: eight inputs of very different sizes, one point at a time.


@pytest.mark.parametrize(
    ("options", "share"),
    [
        ({}, 0.85),
        ({"method": "exact"}, 0.85),
        ({"method": "exact", "repair": True}, 0.98),
        ({"repair": True, "pop_size": 60, "n_generations": 100}, 0.98),
        (IN_MODEL, 0.98),
    ],
)
def test_boreholes_worst_pair(options, share, borehole_best):
    for seed in range(2):
        found = worst_case(models.borehole(), SearchSettings(seed=seed, **options))
        assert share * borehole_best < found.objective_model <= borehole_best * (1.0 + 1e-12)
        flow = [models.borehole_y(x) for x in found.x]
        np.testing.assert_allclose(found.y[:, 0], flow, rtol=1e-12)
        assert found.objective_model == pytest.approx(abs(flow[0] - flow[1]), rel=1e-12)
        if found.gap_percent is not None:
            expected = 100.0 * (1.0 - found.objective_model / found.objective_surrogate)
            assert found.gap_percent == pytest.approx(expected)


# What is told, written and read again.

SEARCHES = {
    "Ishigami, exact": (
        lambda: models.ishigami(gradient=models.ishigami_gradient),
        {"method": "exact"},
    ),
    "Borehole, repaired": (models.borehole, {"method": "exact", "repair": True}),
    "Borehole, in the model": (models.borehole, {**IN_MODEL, "n_runs": 2}),
    "slider-crank": (models.slider_crank, {"method": "exact"}),
    "two units": (models.two_units, {"pop_size": 20, "n_generations": 20}),
}


@pytest.fixture(scope="module", params=SEARCHES)
def result(request):
    make, options = SEARCHES[request.param]
    return worst_case(make(), SearchSettings(seed=1, **options))


def test_json_follows_the_schema_and_comes_back(result):
    document = check_comes_back(result)
    for key in ("case", "solver", "flexion_deg", "baseline", "extension_difference_deg"):
        assert key not in document
    assert document["model"]["name"] == result.model.name
    again = SearchResult.from_json(result.to_json())
    for name in ("x", "y", "y_nominal", "y_surrogate", "training_x", "training_y", "history"):
        left, right = getattr(again, name), getattr(result, name)
        assert (left is None) == (right is None)
        if right is not None:
            np.testing.assert_array_equal(left, right, err_msg=name)
    assert again.settings == result.settings
    assert again.model.inputs == tuple(
        replace(i, tolerance_percent=None, half_range=None) for i in result.model.inputs
    )
    assert again.model.outputs == result.model.outputs


@pytest.mark.parametrize(
    "change",
    [
        lambda d: d.update(case="both"),
        lambda d: d.update(command="python -m kneecore.search"),
        lambda d: d["y"].pop("baseline"),
        lambda d: d["model"].pop("outputs"),
        lambda d: d["model"]["inputs"][0].update(lower="a"),
        lambda d: d.update(model=3),
        lambda d: d.pop("y"),
    ],
)
def test_the_schema_refuses_what_is_wrong(result, change):
    document = result.to_dict()
    jsonschema.validate(document, SCHEMA)
    change(document)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document, SCHEMA)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda d: d["y"].pop("model_1"), "the key 'model_1' is missing"),
        (lambda d: d["parameters"].pop(), "`parameters` must hold two models"),
        (lambda d: d["parameters"][0].update(other=1.0), "`parameters` must name the"),
        (lambda d: d["model"]["inputs"][0].update(lower=1e9), "above its `upper`"),
        (lambda d: d["model"].update(inputs=[]), "`inputs` is empty"),
        (lambda d: d["model"]["inputs"][0].update(colour="red"), "no usable result"),
        (lambda d: d["model"].update(size=0), "`size` is 0; a number above 0 is allowed"),
        (lambda d: d["y"].update(model_1=[1.0] * 99), "`y` h"),
        (lambda d: d.update(model=3), "no usable result"),
        (lambda d: d["counts"].pop("models_failed"), "the key 'models_failed' is missing"),
    ],
)
def test_a_damaged_result_is_refused_in_one_line(result, change, said):
    document = result.to_dict()
    change(document)
    with pytest.raises(kneecore.FileFormatError) as error:
        SearchResult.from_json(json.dumps(document))
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_files_and_figures_are_written_and_read_again(result, tmp_path):
    names = [path.name for path in result.save(tmp_path)]
    assert names[0] == "curves.csv"
    assert names[-1] == "result.json"
    expected = {"figure_1_outputs.png", "figure_1_outputs.svg"}
    if result.model.has_picture:
        expected |= {"figure_2_picture.png", "figure_2_picture.svg"}
    if result.repair is not None:
        expected |= {"figure_5_repair.png", "figure_5_repair.svg"}
    assert set(names) == expected | {"curves.csv", "result.json"}
    for read in (SearchResult.load(tmp_path), kneecore.load(tmp_path)):
        assert read.to_json() == result.to_json()
        assert str(read) == str(result)
        drawn = set(read.figures())
        assert drawn == {name.removesuffix(".png") for name in expected if "png" in name} - {
            "figure_2_picture"  # a file holds no function that could draw
        }


def test_what_is_printed(result):
    told = str(result)
    assert max(len(line) for line in told.splitlines()) <= 100
    for one in result.model.inputs:
        assert one.name in told
    for output in result.model.outputs:
        assert output.name in told
    assert f"Model: {result.model.name}." in told
    for knees_word in ("knee", "deg of flexion", "solver", "python -m"):
        assert knees_word not in told
    assert result.summary() in told
    assert command_line(result) is None
    assert result._repr_html_().startswith("<pre")


def test_csv_has_a_row_for_each_model_and_number(result):
    rows = list(csv.DictReader(io.StringIO(curves_csv(result))))
    m = result.model.n_outputs
    assert [r["model"] for r in rows] == m * ["baseline"] + m * ["model_1"] + m * ["model_2"]
    assert [float(r["value"]) for r in rows[m:]] == result.y.ravel().tolist()
    assert [r["output"] for r in rows[:m]] == [c.output.name for c in result.model.columns]
    assert [r["unit"] for r in rows[:m]] == [c.output.unit for c in result.model.columns]


def test_a_loaded_model_says_that_it_cannot_be_run(result):
    loaded = SearchResult.from_json(result.to_json())
    with pytest.raises(ModelError, match="was read from a file, which holds no function"):
        loaded.model.evaluate(loaded.x)
    with pytest.raises(ModelError, match="was read from a file"):
        worst_case(loaded.model)


def test_the_same_seed_gives_the_same_bytes(result):
    again = worst_case(result.model, result.settings)
    one, two = again.to_dict(), result.to_dict()
    del one["seconds"], two["seconds"]
    assert one == two


def test_numbers_of_any_size_survive_a_file():
    def run(x):
        return 1e-12 * x  # a capacity in farad

    model = Model(run, [Input("C", nominal=10.0, tolerance_percent=5.0)], [Output("C", unit="F")])
    found = worst_case(model, SearchSettings(training_samples=5, method="exact"))
    assert found.objective_model == pytest.approx(1e-12, rel=1e-9)
    document = check_comes_back(found)
    assert document["objective_model"] == found.objective_model
    assert "1e-12 F" in str(found)


# Several methods.


@pytest.mark.parametrize("gradient", [models.ishigami_gradient, None])
def test_all_methods_side_by_side(gradient, ishigami_best, tmp_path):
    model = models.ishigami(gradient=gradient)
    found = {trace.method: trace for trace in compare_methods(model, SearchSettings(seed=2))}
    names = ["ga_surrogate", "repair", *(["exact"] if gradient else []), "ga"]
    assert list(found) == names
    assert found["ga"].objective[-1] == pytest.approx(ishigami_best, rel=1e-3)
    if gradient:
        assert found["exact"].objective[-1] == pytest.approx(ishigami_best, rel=1e-9)
    own = worst_case(model, SearchSettings(seed=2, pop_size=20, n_generations=20))
    beside = with_methods(own)
    assert [trace.method for trace in beside.methods] == names
    assert [t.objective for t in beside.methods] == [t.objective for t in found.values()]
    assert beside.best_of_all == pytest.approx(ishigami_best, rel=1e-3)
    check_comes_back(beside)
    assert "Best f of all methods in the true model: 28.48" in str(beside)
    assert "figure_6_convergence.png" in {path.name for path in beside.save(tmp_path)}


# Units, scales, axes, pictures.


@pytest.mark.parametrize("make", [models.two_units, models.slider_crank])
def test_f_is_counted_in_scales(make):
    model = make()
    found = worst_case(model, SearchSettings(method="exact"))
    scale = np.repeat([o.scale for o in model.outputs], [o.n_columns for o in model.outputs])
    expected = (np.abs(found.y[0] - found.y[1]) / scale).sum()
    assert found.objective_model == pytest.approx(expected, rel=1e-12)
    assert found.objective_model == pytest.approx(worst_on(model, corners(model)), rel=1e-6)
    assert model.objective_unit == ""


def test_one_output_or_ones_own_weights_can_count():
    model = models.two_units()
    frequency = worst_case(model, SearchSettings(method="exact", objective="frequency"))
    assert frequency.objective_model == pytest.approx(np.ptp(frequency.y[:, 3]) / 2.0)
    weights = (0.0, 3.0, 0.0, 0.0)
    one = worst_case(model, SearchSettings(method="exact", weights=weights))
    assert one.objective_model == pytest.approx(3.0 * np.ptp(one.y[:, 1]) / 0.01)
    for found in (frequency, one):
        check_comes_back(found)
    assert one.to_dict()["weights"] == [0.0, 3.0, 0.0, 0.0]
    with pytest.raises(ParameterError, match="`objective` is 'mass'; all, stretch, frequency is"):
        worst_case(model, SearchSettings(objective="mass"))
    with pytest.raises(ParameterError, match="all 0 where the objective counts"):
        worst_case(model, SearchSettings(objective="frequency", weights=weights))


def test_axes_are_labelled_with_names_and_units():
    found = worst_case(models.slider_crank(), SearchSettings(method="exact"))
    figures = found.figures()
    place, ratio = figures["figure_1_outputs"].axes
    assert (place.get_xlabel(), place.get_ylabel()) == ("crank angle, deg", "place, mm")
    assert ratio.get_ylabel() == "stroke ratio"
    curves = {line.get_label(): line.get_ydata() for line in place.lines}
    np.testing.assert_array_equal(curves["model 1"], found.y[0, :5])
    np.testing.assert_array_equal(curves["baseline"], found.y_nominal[:5])
    bars = [line.get_ydata()[0] for line in ratio.lines[1:]]
    assert bars == [found.y_nominal[5], found.y[0, 5], found.y[1, 5]]
    assert "crank angle deg" in str(found)
    assert "place at 120 deg: model 1 gives" in found.summary()  # it differs most


def test_a_picture_shows_the_three_models():
    found = worst_case(models.slider_crank(), SearchSettings(method="exact"))
    axes = found.figures()["figure_2_picture"].axes[0]
    assert len(axes.lines) == 3 * 3
    for n, x in enumerate((found.model.nominal, *found.x)):
        crank, rod, slider = (np.array(line.get_xydata()) for line in axes.lines[3 * n : 3 * n + 3])
        np.testing.assert_allclose(crank[1], models.joints_of(x)[0, 2])
        np.testing.assert_allclose(rod, models.joints_of(x)[:, 2])
        assert len(slider) == 5  # closed
    assert {text.get_text() for text in axes.texts} == {"crank", "rod"}


def test_of_very_many_outputs_those_are_drawn_that_differ_most():
    model = Model(
        lambda x: np.outer(x[:, 0], np.arange(1.0, 31.0)),
        [Input("a", lower=0.0, upper=1.0)],
        [Output(f"y_{k}") for k in range(1, 31)],
        batched=True,
    )
    found = worst_case(model, SearchSettings(method="exact", training_samples=5))
    shown = [axes.get_ylabel() for axes in found.figures()["figure_1_outputs"].axes]
    assert shown == [f"y_{k}" for k in range(7, 31)]


def test_wider_bounds_survive_a_file():
    wide = models.two_units().with_size(2.0)
    found = worst_case(wide, SearchSettings(method="exact"))
    check_comes_back(found)
    again = SearchResult.from_json(found.to_json()).model
    assert again.size == 2.0
    half, stated = again.with_size(1.0), models.two_units()
    np.testing.assert_allclose([half.lower, half.upper], [stated.lower, stated.upper])

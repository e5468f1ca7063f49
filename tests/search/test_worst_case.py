"""The worst-case search of the knee and of other mechanisms."""

import numpy as np
import pytest
from searches import f_of, same_bytes, searched, sum_of

import kneecore
from kneecore import (
    MOMENT,
    Input,
    Knee,
    Model,
    Output,
    ParameterSpace,
    Progress,
    SearchResult,
    SearchSettings,
    simulate,
    worst_case,
)
from kneecore.errors import ModelError, ParameterError
from kneecore.knee.extension import extension_difference_deg, extension_difference_percent
from kneecore.report.command import command_line

FAST = {"pop_size": 40, "n_generations": 60}


@pytest.fixture(scope="module")
def result():
    return searched(seed=0)


def pair_of(result):
    """Return the responses of the two knees."""
    return result.responses["model_1"], result.responses["model_2"]


def plain_model(run, n_inputs=1, n_outputs=1, lower=0.0, upper=1.0, **options):
    """Return a batched model without units."""
    inputs = [Input(f"x_{k}", lower=lower, upper=upper) for k in range(n_inputs)]
    return Model(run, inputs, [Output("y", axis=range(n_outputs))], batched=True, **options)


def test_the_main_run_as_the_paper_describes_it(result):
    """200 x 800 on a 50-sample surrogate: what the paper says of both models, as orders."""
    one, two = (np.degrees(knee.flexion) for knee in pair_of(result))
    assert one[5] < -10.0  # model 1 over-extends far
    assert two[5] > 10.0  # model 2 cannot extend fully
    assert (one < two).all()  # and the order is kept in flexion
    assert 300.0 < result.objective_model < 500.0
    assert 0.0 < result.gap_percent < 20.0
    assert 25.0 < extension_difference_percent(result.responses) < 45.0


def test_the_pair_is_recomputed_in_the_true_model(result):
    for x, response in zip(result.x, pair_of(result), strict=True):
        np.testing.assert_array_equal(simulate(x).flexion, response.flexion)
    assert result.objective_model == pytest.approx(sum_of(result), rel=1e-12)
    predicted = result.y_surrogate
    f = np.abs(predicted[0] - predicted[1]).sum()
    assert result.objective_surrogate == pytest.approx(f, rel=1e-12)
    gap = 100.0 * (1.0 - result.objective_model / result.objective_surrogate)
    assert result.gap_percent == pytest.approx(gap)


def test_differences_in_extension(result):
    one, two = (np.degrees(knee.flexion[5]) for knee in pair_of(result))
    assert extension_difference_deg(result.responses) == pytest.approx(two - one)
    baseline = np.degrees(result.responses["baseline"].flexion)
    motion = baseline[11] - baseline[5]
    percent = 100.0 * (two - one) / motion
    assert extension_difference_percent(result.responses) == pytest.approx(percent)


def test_model_1_is_the_one_that_extends_further():
    found = [searched(seed=seed, pop_size=20, n_generations=10) for seed in range(8)]
    for each in found:
        one, two = pair_of(each)
        assert one.flexion[5] < two.flexion[5]
        assert each.y_surrogate[0, 5] < each.y_surrogate[1, 5]
        np.testing.assert_array_equal(simulate(each.x[0]).flexion, one.flexion)


def test_both_knees_are_within_the_bounds(result):
    space = result.model.space
    assert (result.x >= space.lower).all()
    assert (result.x <= space.upper).all()
    assert np.count_nonzero(space.at_bounds(result.x)) > 40


def test_the_surrogate_ranks_models_well():
    surrogate = kneecore.fit_surrogate(Knee())
    fresh = ParameterSpace().from_unit(np.random.default_rng(99).random((100, 28)))
    truth = np.degrees(kneecore.simulate_batch(fresh).flexion)
    predicted = surrogate.predict(fresh)
    assert predicted.shape == truth.shape
    for load in range(12):
        ranks = [np.argsort(np.argsort(v[:, load])) for v in (truth, predicted)]
        assert np.corrcoef(*ranks)[0, 1] > 0.9
    error = np.sqrt(np.mean((predicted - truth) ** 2))
    assert error == pytest.approx(surrogate.loo_rms, rel=0.6)
    np.testing.assert_allclose(surrogate.predict(fresh[0]), predicted[0])


def test_geometry_decides_and_material_matters_little(result):
    geometry = searched(ParameterSpace(case="geometry"))
    material = searched(ParameterSpace(case="material"))
    assert 0.75 < geometry.objective_model / result.objective_model < 1.02
    assert material.objective_model / result.objective_model < 0.25
    held = ~geometry.model.free
    np.testing.assert_array_equal(
        geometry.x[:, held], np.tile(result.model.space.baseline[held], (2, 1))
    )


def test_the_true_models_space_finds_more_than_the_surrogate(result):
    model = searched(search_space="model", pop_size=60, n_generations=40)
    assert model.objective_surrogate is None
    assert model.gap_percent is None
    assert model.training_x is None
    assert model.y_surrogate is None
    assert model.objective_model == pytest.approx(model.history[-1], rel=1e-12)
    assert model.objective_model > 0.85 * result.objective_model
    assert model.counts["models_simulated"] == 2 * (60 + 40 * 54) + 2


@pytest.mark.parametrize("objective", ["extension", "flexion"])
def test_only_the_loads_that_count_are_summed(objective, result):
    chosen = searched(objective=objective, **FAST)
    counts = (MOMENT > 0) == (objective == "extension")
    assert chosen.objective_model == pytest.approx(f_of(*pair_of(chosen), counts))
    assert chosen.objective_model > f_of(*pair_of(result), counts) * 0.9


def test_several_runs_keep_the_best_and_report_the_spread():
    several = searched(n_runs=4, pop_size=20, n_generations=20)
    assert len(several.run_values) == 4
    assert len(set(several.run_values)) > 1
    assert several.objective_surrogate == max(several.run_values)
    first = searched(n_runs=1, pop_size=20, n_generations=20)
    assert first.run_values[0] == several.run_values[0]
    assert several.counts["pairs_evaluated"] == 4 * (20 + 20 * 18)


@pytest.mark.parametrize("search_space", ["surrogate", "model"])
def test_threads_change_no_byte_and_seeds_do(search_space):
    options = {"search_space": search_space, "pop_size": 120, "n_generations": 12}
    one, two = (searched(seed=7, threads=threads, **options) for threads in (1, 2))
    assert one.threads == 1
    assert two.threads == 2
    assert same_bytes(one, two)
    assert not same_bytes(one, searched(seed=8, **options))


def test_progress_goes_through_the_stages():
    seen: list[Progress] = []
    searched(callback=lambda report: seen.append(report), **FAST)
    stages = list(dict.fromkeys(report.stage for report in seen))
    assert stages == ["compile", "sampling", "fit", "search", "verify"]
    bests = [r.best for r in seen if r.stage == "search"]
    assert bests == sorted(bests)
    assert seen[-2].done == seen[-2].total == FAST["n_generations"]


@pytest.mark.parametrize("search_space", ["surrogate", "model"])
def test_a_cancelled_search_returns_the_best_pair_so_far(search_space):
    def stop(report):
        return report.stage == "search" and report.done >= 50

    cancelled = searched(search_space=search_space, pop_size=20, callback=stop)
    assert cancelled.stop_reason == "cancelled"
    assert len(cancelled.history) == 51
    assert cancelled.objective_model > 0.0


def test_a_search_cancelled_before_it_began_says_so():
    for stage in ("compile", "sampling", "fit"):
        with pytest.raises(kneecore.Cancelled):
            searched(callback=lambda report, stage=stage: report.stage == stage)


def test_rest_lengths_of_the_baseline():
    # In the true model's space: near the corners of the bounds a pre-stressed knee may fail.
    options = {"search_space": "model", "pop_size": 40, "n_generations": 40}
    fixed = searched(rest_length="fixed", **options)
    for response in pair_of(fixed):
        baseline = fixed.responses["baseline"]
        np.testing.assert_array_equal(response.rest_length, baseline.rest_length)
    free = searched(**options)
    assert fixed.objective_model > free.objective_model


def test_failed_samples_are_left_out_and_counted():
    wide = ParameterSpace(geometry_bound_mm=6.0, material_bound_percent=90.0)
    found = searched(wide, training_samples=200, **FAST)
    n_failed = np.count_nonzero(~np.isfinite(found.training_y).all(axis=1))
    assert 0 < n_failed < 170
    assert found.counts["models_failed"] >= n_failed
    if "failed" in [knee.status for knee in pair_of(found)]:
        assert found.objective_model is None
        assert found.gap_percent is None
        assert "fails" in str(found)


def test_too_many_failed_samples_are_an_error():
    def broken(x):
        return np.where(x[:, :1] > 0.2, np.nan, x)

    with pytest.raises(ModelError, match="of 50 training samples failed"):
        worst_case(plain_model(broken, 15, 15), SearchSettings(**FAST))


def four_bar(x):
    """Coupler angle (rad) of a planar four-bar linkage, for five crank angles; lengths in m."""
    ground, crank, coupler, rocker = x.T[:, :, None]
    turn = np.radians([30.0, 60.0, 90.0, 120.0, 150.0])
    diagonal_x, diagonal_y = ground - crank * np.cos(turn), -crank * np.sin(turn)
    diagonal = np.hypot(diagonal_x, diagonal_y)
    cosine = (coupler**2 + diagonal**2 - rocker**2) / (2.0 * coupler * diagonal)
    inside = np.abs(cosine) <= 1.0  # a linkage that cannot be assembled is a failure
    angle = np.arctan2(diagonal_y, diagonal_x) + np.arccos(np.where(inside, cosine, 0.0))
    return np.where(inside.all(axis=1, keepdims=True), angle, np.nan)


@pytest.mark.parametrize("search_space", ["surrogate", "model"])
def test_another_mechanism(search_space):
    nominal = np.array([0.40, 0.12, 0.35, 0.30])
    names = ("ground", "crank", "coupler", "rocker")
    linkage = Model(
        four_bar,
        [
            Input(name, lower=0.98 * length, upper=1.02 * length, unit="m")
            for name, length in zip(names, nominal, strict=True)
        ],
        [Output("coupler angle", unit="rad", axis=(30, 60, 90, 120, 150), axis_unit="deg")],
        batched=True,
    )
    repair = search_space == "surrogate"
    settings = SearchSettings(search_space=search_space, repair=repair, seed=1, **FAST)
    found = worst_case(linkage, settings)
    assert (found.x >= 0.98 * nominal).all()
    assert (found.x <= 1.02 * nominal).all()
    y = four_bar(found.x)
    np.testing.assert_allclose(found.y, y)
    assert found.objective_model == pytest.approx(np.abs(y[0] - y[1]).sum())
    # All 256 pairs of corners, by brute force: the optimum lies on one of them.
    corners = nominal * (0.98 + 0.04 * np.array(list(np.ndindex(2, 2, 2, 2))))
    at_corners = four_bar(corners)
    best = np.abs(at_corners[:, None] - at_corners[None]).sum(axis=2).max()
    assert found.objective_model == pytest.approx(best, rel=1e-3)
    assert "rocker" in str(found)


@pytest.mark.parametrize("wrong", ["fewer rows", "other columns", "no columns"])
def test_a_model_whose_answers_change_shape_is_named(wrong):
    def model(x):
        if len(x) == 1 or wrong == "no columns":
            return x[:, :0] if wrong == "no columns" else x
        return x[1:] if wrong == "fewer rows" else x[:, :1]

    with pytest.raises(ParameterError, match="`run` returned shape"):
        worst_case(plain_model(model, 3, 3), SearchSettings(search_space="model", **FAST))


def test_numpy_scalars_are_as_good_as_numbers():
    space = ParameterSpace(
        geometry_bound_mm=np.float32(1.0), half_ranges={"plateau_x": np.float32(0.5e-3)}
    )
    options = kneecore.GeneticOptions(blx_alpha=np.float32(0.5))
    found = searched(
        space, seed=np.int64(3), pop_size=np.int32(20), n_generations=np.int64(5), options=options
    )
    assert SearchResult.from_json(found.to_json()).settings.seed == 3


def test_too_few_samples_for_a_leave_one_out_error():
    found = searched(training_samples=29, pop_size=20, n_generations=5)
    assert found.loo_rms is None
    assert "unknown (too few samples)" in str(found)
    assert str(SearchResult.from_json(found.to_json())) == str(found)


def test_an_input_without_width_is_held():
    inputs = [Input("free", lower=0.0, upper=1.0), Input("held", lower=2.0, upper=2.0)]
    model = Model(lambda x: x, inputs, [Output("y", axis=(0, 1))], batched=True)
    found = worst_case(model, SearchSettings(training_samples=5, **FAST))
    np.testing.assert_array_equal(found.x[:, 1], [2.0, 2.0])
    np.testing.assert_allclose(np.sort(found.x[:, 0]), [0.0, 1.0])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"search_space": "moon"}, "`search_space` is 'moon'"),
        ({"objective": "jump"}, "`objective` is 'jump'"),
        ({"rest_length": "short"}, "`rest_length` is 'short'"),
        ({"training_samples": 28}, "`training_samples` is 28; with 28 free parameters at least 29"),
        ({"pop_size": 6}, "`pop_size` is 6; at least 10"),
        ({"n_generations": 0}, "`n_generations` is 0"),
        ({"n_runs": 0}, "`n_runs` is 0"),
        ({"seed": -3}, "`seed` is -3"),
        ({"threads": 0}, "`threads` is 0"),
        ({"space": "abc"}, "`space` is 'abc'; a ParameterSpace"),
        ({"options": {"blx_alpha": 1}}, "`options` is .*; GeneticOptions"),
        ({"threads": "two"}, "`threads` is 'two'"),
    ],
)
def test_what_is_not_allowed_is_named(arguments, said):
    with pytest.raises(ParameterError, match=said):
        searched(**arguments)


def test_a_result_prints_in_a_terminal_and_in_a_notebook(result):
    text = str(result)
    assert "true model" in text
    assert "acl_femur_x" in text
    assert "reconstruction" in text
    assert max(len(line) for line in text.splitlines()) <= 100
    long = searched(
        ParameterSpace(geometry_bound_mm=0.75), pop_size=20, n_generations=5, training_samples=60,
        n_runs=2, objective="flexion", seed=123456789,
    )  # fmt: skip
    assert str(long).splitlines()[-1] == command_line(long)
    assert len(command_line(long)) > 100
    html = result._repr_html_()
    assert html.startswith("<pre")
    assert "acl_femur_x" in html
    assert len(repr(result)) < 300
    assert result.responses["model_1"]._repr_html_().startswith("<pre")


def test_a_result_is_a_search_result(result):
    assert isinstance(result, SearchResult)
    assert result.model.space.case == "both"
    assert result.summary().startswith("At +5 N m model 1 over-extends to -")

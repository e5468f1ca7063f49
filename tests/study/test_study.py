"""Monte Carlo, influence and the comparison with the worst case."""

import errno
import json
import os
import tomllib

import numpy as np
import pytest
import tomli_w
from commands import called

import kneecore
from kneecore import (
    FileFormatError,
    InfluenceSettings,
    Knee,
    ModelError,
    ParameterError,
    ParameterSpace,
    SamplingSettings,
    SearchSettings,
    compare_with_sampling,
    influence,
    monte_carlo,
    simulate_batch,
    worst_case,
    worst_case_slopes,
)
from kneecore.cli.uncertainty import main
from kneecore.files.digest import with_digest
from kneecore.files.influence import to_csv
from kneecore.numerics.sampling import uniform
from kneecore.report.influence import answer

EXTENSION, FLEXION = 5, 11  # the largest moments's places


def sampled(knee=None, *, callback=None, marks=None, **settings):
    """Sample the packaged knees, or others."""
    knee = knee or Knee()
    return monte_carlo(knee, SamplingSettings(**settings), marks=marks, callback=callback)


def indices(knee=None, *, callback=None, **settings):
    """Return the influence of the packaged knees' parameters, or of others'."""
    return influence(knee or Knee(), InfluenceSettings(**settings), callback=callback)


@pytest.fixture(scope="module")
def study():
    return sampled(n_samples=5000, seed=1)


@pytest.fixture(scope="module")
def worst():
    return worst_case(Knee())


@pytest.fixture(scope="module")
def found():
    return indices(n_base=256)


def test_statistics_are_those_of_the_samples():
    few = sampled(n_samples=300, seed=5)
    space = ParameterSpace()
    batch = simulate_batch(space.from_unit(uniform(300, 28, 5)))
    angles = np.degrees(batch.flexion)
    np.testing.assert_allclose(few.y.mean, angles.mean(axis=0), rtol=1e-12)
    np.testing.assert_allclose(few.y.sd, angles.std(axis=0, ddof=1), rtol=1e-10)
    low, high = np.percentile(angles, [0.15, 99.85], axis=0)
    np.testing.assert_allclose(few.y.percentile_lower, low, rtol=1e-12)
    np.testing.assert_allclose(few.y.percentile_upper, high, rtol=1e-12)
    np.testing.assert_allclose(
        few.observed["tension_n"].mean, batch.tension.mean(axis=0), rtol=1e-10
    )
    np.testing.assert_allclose(
        few.observed["ap_position_mm"].sd, 1e3 * batch.ap_position.std(axis=0, ddof=1)
    )
    assert few.counts["unsettled"] == batch.n_unsettled


def test_what_the_paper_leads_one_to_expect(study):
    """Orders: about 5.4 deg of spread at +5 N m, 5.3 at -5, 1.8 at +0.1, and no failure."""
    sd = study.y.sd
    assert sd[5] == pytest.approx(5.4, abs=0.3)
    assert sd[11] == pytest.approx(5.3, abs=0.3)
    assert sd[0] == pytest.approx(1.8, abs=0.2)
    assert study.n_failed == 0
    assert 0 < study.counts["unsettled"] < study.n_samples


def test_seeds_agree_within_the_standard_error(study):
    other = sampled(n_samples=5000, seed=2)
    error = study.y.sd * np.sqrt(2.0 / 5000)
    assert (np.abs(study.y.mean - other.y.mean) < 4.0 * error).all()
    np.testing.assert_allclose(study.y.sd, other.y.sd, rtol=0.06)


def test_threads_change_no_byte():
    one, two = (sampled(Knee(threads=n), n_samples=3000).to_dict() for n in (1, 2))
    for document in (one, two):
        del document["seconds"], document["threads"]
    assert json.dumps(one) == json.dumps(two)


@pytest.mark.parametrize("sampling", ["latin-hypercube", "sobol"])
def test_other_sampling_agrees(sampling, study):
    other = sampled(n_samples=1500, sampling=sampling)
    assert other.n_samples == (2048 if sampling == "sobol" else 1500)
    np.testing.assert_allclose(other.y.sd, study.y.sd, rtol=0.1)


def test_failed_samples_are_counted_and_left_out():
    wide = ParameterSpace(geometry_bound_mm=6.0, material_bound_percent=90.0)
    spread = sampled(Knee(wide), n_samples=300)
    assert 0 < spread.n_failed < 300
    assert np.isfinite(spread.y.mean).all()
    assert f"{spread.n_failed} failed" in str(spread)


def test_equilibria_are_sampled_as_they_are_simulated():
    rest = sampled(Knee(solver="equilibrium"), n_samples=400, seed=3)
    space = ParameterSpace()
    batch = simulate_batch(space.from_unit(uniform(400, 28, 3)), solver="equilibrium")
    low, high = np.percentile(np.degrees(batch.flexion), [0.15, 99.85], axis=0)
    np.testing.assert_allclose(rest.y.percentile_lower, low, rtol=1e-12)
    np.testing.assert_allclose(rest.y.percentile_upper, high, rtol=1e-12)
    assert rest.n_failed == rest.counts["lost"] == rest.counts["unsettled"] == 0
    assert rest.to_dict()["solver"] == "equilibrium"


def test_knees_without_an_equilibrium_are_in_no_statistic():
    wide = ParameterSpace(geometry_bound_mm=5.0)
    rest = sampled(Knee(wide, solver="equilibrium"), n_samples=400, seed=3)
    batch = simulate_batch(wide.from_unit(uniform(400, 28, 3)), solver="equilibrium")
    kept = np.isnan(batch.lost_at)
    assert rest.counts["lost"] == rest.n_failed == np.count_nonzero(~kept) > 0
    angles = np.degrees(batch.flexion[kept])
    np.testing.assert_allclose(rest.y.mean, angles.mean(axis=0), rtol=1e-12)


def test_a_cancelled_study_keeps_what_is_done():
    part = sampled(n_samples=10_000, callback=lambda report: report.done >= 4000)
    assert part.stop_reason == "cancelled"
    assert 4000 <= part.n_samples < 10_000
    assert "cancelled" in str(part)


def test_nothing_but_failures_is_an_error():
    x = ParameterSpace().baseline.copy()
    x[22:26] *= 1e5
    with pytest.raises(ModelError, match="samples failed"):
        sampled(Knee(ParameterSpace(baseline=x)), n_samples=20)


def test_the_worst_case_lies_outside_of_the_band(study, worst):
    angles = worst.y
    counted = sampled(n_samples=5000, seed=1, marks=angles)
    compared = compare_with_sampling(worst, counted)
    np.testing.assert_array_equal(compared.share_outside("extension"), 1.0)
    lower = counted.y.percentile_lower
    np.testing.assert_allclose(compared.excess[0], np.maximum(lower - angles[0], 0.0))
    assert (compared.below[0] <= 0.0015 + 1e-12).all()
    assert (compared.below[1] >= 0.9985 - 1e-12).all()


def test_only_the_same_bounds_can_be_compared(study):
    other = worst_case(
        Knee(ParameterSpace(geometry_bound_mm=0.5)), SearchSettings(pop_size=20, n_generations=5)
    )
    with pytest.raises(ParameterError, match="other bounds"):
        compare_with_sampling(other, study)


def test_influence_of_the_knees_parameters(found):
    assert found.deciding(EXTENSION)[:2] == ["condyle_x", "pcl_femur_x"]
    assert found.deciding(FLEXION)[:2] == ["condyle_y", "pcl_femur_y"]
    first = found.indices.first_order.sum(axis=1)
    np.testing.assert_allclose(first, 1.0, atol=0.1)
    groups = sum(found.groups.values())
    np.testing.assert_allclose(groups, first)
    assert found.groups["material"].max() < 0.1
    # The ACL is slack in flexion, the MCL in extension: they cannot decide anything there.
    assert np.abs(found.groups["acl"][6:]).max() < 0.02
    assert np.abs(found.groups["mcl"][:6]).max() < 0.02
    assert "condyle_x" in found.summary()
    assert "CONDYLE_X" in answer(found, called=str.upper)
    with pytest.raises(ParameterError, match="`column` is 12; a whole number from 0 to 11"):
        found.deciding(12)


def test_indices_as_csv(found):
    lines = to_csv(found).splitlines()
    assert len(lines) == 1 + 12 * 28
    rows = [dict(zip(lines[0].split(","), line.split(","), strict=True)) for line in lines[1:]]
    row = next(r for r in rows if (r["moment_nm"], r["parameter"]) == ("-2", "pcl_femur_y"))
    load, k = kneecore.MOMENT.tolist().index(-2.0), found.names.index("pcl_femur_y")
    told = found.indices
    for key, value in (
        ("first_order", told.first_order[load, k]),
        ("total_order", told.total_order[load, k]),
        ("first_lower", told.first_order_interval[0, load, k]),
        ("total_upper", told.total_order_interval[1, load, k]),
    ):
        assert float(row[key]) == pytest.approx(value, rel=1e-5)


def test_the_answer_where_there_is_little_to_say():
    names = dict.fromkeys(kneecore.NAMES, 0.0)
    space = ParameterSpace(half_ranges=names | {"condyle_x": 1e-3})
    one = indices(Knee(space), n_base=16, intervals=False)
    assert one.summary() == "At +5 N m condyle_x alone varies, and decides the angle."
    line = to_csv(one).splitlines()[1].split(",")
    assert line[3:5] == ["", ""]


def test_influence_agrees_with_the_slopes_at_the_baseline(found):
    """The model is nearly linear: squared slopes rank the parameters as the indices do."""
    space = ParameterSpace()
    steps = 1e-3 * np.eye(28)
    middle = np.full(28, 0.5)
    up = simulate_batch(space.from_unit(middle + steps)).flexion[:, 5]
    down = simulate_batch(space.from_unit(middle - steps)).flexion[:, 5]
    squares = (up - down) ** 2
    expected = squares / squares.sum()
    np.testing.assert_allclose(found.indices.total_order[5], expected, atol=0.1)


def test_influence_of_one_case_only():
    material = indices(Knee(ParameterSpace(case="material")), n_base=64, intervals=False)
    assert len(material.names) == 6
    assert material.indices.first_order.shape == (12, 6)
    json.dumps(material.to_dict(), allow_nan=False)


def test_influence_is_the_same_on_any_number_of_threads():
    one, two = (indices(Knee(threads=t), n_base=32, intervals=False) for t in (1, 2))
    assert one.indices.total_order.tobytes() == two.indices.total_order.tobytes()


def test_influence_can_be_cancelled():
    with pytest.raises(kneecore.Cancelled):
        indices(n_base=256, callback=lambda report: report.done >= 64)


def test_an_influence_study_without_any_influence():
    # The only free width is far below what can move an angle.
    space = ParameterSpace(half_ranges=dict.fromkeys(kneecore.NAMES, 0.0) | {"plateau_x": 1e-18})
    with pytest.raises(ParameterError, match="move no output"):
        indices(Knee(space), n_base=8)


def test_slopes_at_the_worst_case(worst):
    slopes = worst_case_slopes(worst)
    assert slopes.slopes.shape == (2, 12, 28)
    assert slopes.deciding(5)[0] == "condyle_x"
    k = slopes.names.index("condyle_x")
    # Model 1 has its condyle at the lower bound: moving it forwards brings it less far back.
    assert (slopes.slopes[:, 5, k] > 0.0).all()


def in_process(capsys, *arguments):
    return called(capsys, main, *arguments)


def test_the_command_prints_json(capsys):
    code, out, _ = in_process(
        capsys, "--samples", "400", "--json", "--influence", "--base-samples", "16", "--quiet"
    )
    assert code == 0
    document = json.loads(out)
    assert document["n_samples"] == 400
    assert document["bounds_997_deg"]["sigma"].keys() == {"lower", "upper"}
    assert document["bounds_997_deg"]["percentile"].keys() == {"lower", "upper"}
    for key in ("n_failed", "n_unsettled", "mean_deg", "sd_deg", "moment_nm", "seed", "seconds"):
        assert key in document
    assert len(document["influence"]["parameters"]) == 28


def test_the_command_writes_and_compares(capsys, tmp_path, worst):
    worst.save(tmp_path / "worst", figures=False)
    arguments = ["--samples", "300", "--result", str(tmp_path / "worst"), "--out"]
    arguments += [str(tmp_path / "study"), "--influence", "--base-samples", "16"]
    code, out, _ = in_process(capsys, *arguments)
    assert code == 0
    assert "outside of the 99.7 % band" in out
    assert "decide the angle" in out
    names = sorted(p.name for p in (tmp_path / "study").iterdir())
    assert len(names) == 8
    assert json.loads((tmp_path / "study" / "uncertainty.json").read_text())["comparison"]
    code, _, err = in_process(capsys, *arguments)
    assert code == 2
    assert "--force" in err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--samples", "0"], "`--samples` is 0"),
        (["--base-samples", "-4"], "`--base-samples` is -4"),
        (["--sampling", "grid"], "'grid'"),
        (["--case", "material", "--material-bound-percent", "0"], "zero width"),
        (["--result", "none.json"], "none.json: cannot be read"),
        (["--out", "/dev/null/x"], "a writable folder is allowed"),
        (["--threads", "0"], "`--threads` is 0"),
    ],
)
def test_a_users_mistake_gets_one_line_and_exit_code_2(capsys, arguments, said):
    code, out, err = in_process(capsys, "--quiet", *arguments)
    assert (code, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1


def test_a_result_of_other_bounds_is_refused_before_anything_is_sampled(capsys, tmp_path, worst):
    worst.save(tmp_path / "worst", figures=False)
    arguments = ["--result", str(tmp_path / "worst"), "--geometry-bound-mm", "0.5"]
    code, out, err = in_process(capsys, "--quiet", *arguments)
    assert (code, out) == (2, "")
    assert "`--result` and the samples have other bounds" in err
    code, out, err = in_process(capsys, "--quiet", *arguments[:2], "--solver", "equilibrium")
    assert (code, out) == (2, "")
    assert "`--result` has the solver 'dynamics' and the samples 'equilibrium'" in err


def test_indices_of_the_knees_at_rest_are_nearly_those_in_motion():
    moving, resting = (indices(Knee(solver=s), n_base=128) for s in ("dynamics", "equilibrium"))
    assert resting.to_dict()["solver"] == "equilibrium"
    heavy = [2, 3, 4, 5, 8, 9, 10, 11]  # loads at which the motion has come to rest
    assert np.abs(moving.indices.total_order - resting.indices.total_order)[heavy].max() < 0.02
    assert (moving.indices.total_order != resting.indices.total_order).any()


def test_indices_of_what_moves_nothing_are_refused_and_the_samples_stay(capsys, tmp_path):
    text = ParameterSpace().to_toml()
    knee = tomllib.loads(text)
    for name, entry in knee["parameters"].items():
        entry["half_range"] = 1.0 if name.startswith("acl_femur") else 0.0
    knee["parameters"]["acl_stiffness"] |= {"value": 0.0}
    path = tmp_path / "cut.toml"
    path.write_text(tomli_w.dumps(knee))
    arguments = ["--baseline", str(path), "--influence", "--samples", "64", "--json", "--quiet"]
    code, out, err = in_process(capsys, *arguments)
    assert code == 2
    assert err.count("\n") == 1
    assert "move no output" in err
    document = json.loads(out)
    assert document["n_samples"] == 64
    assert document["influence"] is None


def test_a_full_disk_costs_no_result(capsys, tmp_path, monkeypatch):
    def full(*_args):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    arguments = ["--samples", "64", "--json", "--quiet", "--out", str(tmp_path / "study")]
    code, out, err = in_process(capsys, *arguments)
    assert code == 2
    assert "No space left on device" in err
    assert err.count("\n") == 1
    assert json.loads(out)["n_samples"] == 64


def test_sobol_rounding_is_reported(capsys):
    _, out, _ = in_process(capsys, "--samples", "100", "--sampling", "sobol", "--quiet")
    assert "128 samples (sobol, rounded up to a power of two, seed 0)" in out


def test_a_study_comes_back_from_its_folder(capsys, tmp_path, worst):
    worst.save(tmp_path / "worst", figures=False)
    arguments = ["--samples", "300", "--result", str(tmp_path / "worst"), "--influence"]
    arguments += ["--base-samples", "16", "--out", str(tmp_path / "study"), "--quiet"]
    assert in_process(capsys, *arguments)[0] == 0
    text = (tmp_path / "study" / "uncertainty.json").read_text()
    read = kneecore.load(tmp_path / "study")
    assert with_digest(read.to_dict()) == json.loads(text)
    assert read.sampled.settings == SamplingSettings(n_samples=300)
    assert read.influence is not None
    assert read.comparison is not None
    assert isinstance(read.sampled.model, Knee)


@pytest.mark.parametrize("figures", [True, False])
def test_samples_and_influence_are_saved_and_loaded(found, study, tmp_path, figures):
    for result, n_files in ((study, 1), (found, 2)):
        written = result.save(tmp_path / type(result).__name__, figures=figures)
        n_figures = 2 * len(result.figures()) if figures else 0
        assert len(written) == n_files + n_figures
        again = kneecore.load(tmp_path / type(result).__name__)
        assert again.to_json() == result.to_json()
        assert type(again) is type(result)


def test_a_study_of_before_is_refused_in_a_sentence(study):
    document = study.to_dict()
    del document["baseline"]["parameters"]
    with pytest.raises(FileFormatError, match="could not be read back"):
        kneecore.MonteCarloResult.from_json(json.dumps(document))

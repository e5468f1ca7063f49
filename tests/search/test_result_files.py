"""Results on disk and back."""

import csv
import io
import json
import os
from dataclasses import replace

import jsonschema
import matplotlib as mpl
import numpy as np
import pytest
from results import KNEE_KEYS, SCHEMA
from searches import searched

from kneecore import FileFormatError, OutputError, ParameterSpace, SearchResult, simulate
from kneecore.figures import search as figures_of_a_search
from kneecore.files import folder as output
from kneecore.files.search import curves_csv
from kneecore.report.command import command_line


@pytest.fixture(scope="module", params=["surrogate", "model", "own space"])
def result(request):
    if request.param == "own space":
        space = ParameterSpace(
            case="geometry",
            half_ranges={"condyle_radius": 2e-3},
            baseline=1.01 * ParameterSpace().baseline,
            title="mine <b>&",
            note=None,
        )
        return searched(space, pop_size=20, n_generations=10, n_runs=2, objective="extension")
    return searched(search_space=request.param, pop_size=20, n_generations=10, seed=4)


def test_json_follows_the_schema(result):
    jsonschema.validate(json.loads(result.to_json()), SCHEMA)


def test_the_schema_refuses_what_is_wrong(result):
    document = json.loads(result.to_json())
    document["flexion_deg"]["model_1"].pop()
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document, SCHEMA)


def test_every_key_is_documented(result):
    assert set(json.loads(result.to_json())) == KNEE_KEYS - {
        "half_step_change_deg"
    }  # only if asked for


def test_reading_and_writing_again_changes_no_byte(result):
    text = result.to_json()
    again = SearchResult.from_json(text)
    assert again.to_json() == text
    np.testing.assert_array_equal(again.x, result.x)
    np.testing.assert_array_equal(again.model.lower, result.model.lower)
    flexion, expected = (r.responses["model_1"].flexion for r in (again, result))
    np.testing.assert_allclose(flexion, expected, atol=1e-12)
    assert str(again) == str(result)


def test_csv_has_a_row_for_each_model_and_load(result):
    rows = list(csv.DictReader(io.StringIO(curves_csv(result))))
    assert [r["model"] for r in rows] == ["baseline"] * 12 + ["model_1"] * 12 + ["model_2"] * 12
    angles = [float(r["flexion_deg"]) for r in rows[12:24]]
    np.testing.assert_allclose(angles, np.degrees(result.responses["model_1"].flexion), atol=1e-9)
    tension = [float(r["tension_pcl_n"]) for r in rows[:12]]
    np.testing.assert_allclose(tension, result.responses["baseline"].tension[:, 1], atol=1e-9)


def test_failed_models_are_null_and_come_back(tmp_path):
    x = ParameterSpace().baseline.copy()
    x[22:26] *= 1e5
    whole = searched(search_space="model", pop_size=20, n_generations=2)
    y = whole.y.copy()
    y[1] = np.nan
    was = whole.responses["model_2"]
    same = {name: getattr(was, name) for name in ("rest_length", "load_free_position")}
    responses = {**whole.responses, "model_2": replace(simulate(x), **same)}
    failed = replace(whole, y=y, responses=responses, objective_model=None)
    document = json.loads(failed.to_json())
    jsonschema.validate(document, SCHEMA)
    assert document["flexion_deg"]["model_2"] == [None] * 12
    assert document["extension_difference_deg"] is None
    assert document["status"]["model_2"] == "failed"
    assert ",failed" in curves_csv(failed)
    again = SearchResult.from_json(failed.to_json())
    assert np.isnan(again.responses["model_2"].flexion).all()
    assert np.isnan(again.y[1]).all()
    assert "fails for model_2" in str(again)
    assert len(failed.save(tmp_path)) == 10  # figures of what there is


def test_save_writes_all_files_and_load_reads_them(result, tmp_path):
    folder = tmp_path / "new" / "folder"
    written = result.save(folder)
    names = [path.name for path in written]
    assert names[0] == "curves.csv"
    assert names[-1] == "result.json"
    assert sorted(p.name for p in folder.iterdir()) == sorted(names)
    for number in (1, 2, 3, 4):
        for ending, start in (("png", b"\x89PNG"), ("svg", b"<?xml")):
            (figure,) = folder.glob(f"figure_{number}_*.{ending}")
            assert figure.read_bytes().startswith(start)
    assert SearchResult.load(folder).to_json() == result.to_json()
    assert SearchResult.load(folder / "result.json").to_json() == result.to_json()
    if "knee.toml" in names:
        again = ParameterSpace.from_file(folder / "knee.toml", case=result.model.space.case)
        np.testing.assert_array_equal(again.lower, result.model.lower)
        np.testing.assert_array_equal(again.upper, result.model.upper)


def test_figures_are_the_same_bytes_again(result, tmp_path):
    one = {p.name: p.read_bytes() for p in result.save(tmp_path / "1")}
    two = {p.name: p.read_bytes() for p in result.save(tmp_path / "2")}
    assert one == two


def test_a_result_is_not_overwritten_unasked(result, tmp_path):
    result.save(tmp_path, figures=False)
    before = (tmp_path / "result.json").read_bytes()
    with pytest.raises(OutputError, match=r"holds a result\.json already"):
        result.save(tmp_path, figures=False)
    assert (tmp_path / "result.json").read_bytes() == before
    result.save(tmp_path, figures=False, force=True)


def test_an_interrupted_save_leaves_what_was_there(result, tmp_path, monkeypatch):
    result.save(tmp_path)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    real = output._stage

    def fail_at_the_figures(path, content):
        if path.suffix == ".svg":
            raise KeyboardInterrupt
        return real(path, content)

    monkeypatch.setattr(output, "_stage", fail_at_the_figures)
    with pytest.raises(KeyboardInterrupt):
        result.save(tmp_path, force=True)
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


def test_figures_that_cannot_be_drawn_cost_a_line_and_no_number(
    result, tmp_path, monkeypatch, caplog
):
    def no_font(_):
        raise RuntimeError("Failed to process string with tex\nbecause latex could not be found")

    monkeypatch.setattr(figures_of_a_search, "draw", no_font)
    written = result.save(tmp_path)
    assert [path.name for path in written] == [name for name, _ in result.files(figures=False)]
    assert SearchResult.load(tmp_path).to_json() == result.to_json()
    (line,) = caplog.messages
    assert "figures cannot be drawn and are left out: RuntimeError: Failed" in line
    assert "\n" not in line


def test_the_users_matplotlibrc_changes_no_byte(result):
    usual = dict(result.files())
    with mpl.rc_context({"text.usetex": True, "font.size": 30, "svg.fonttype": "none"}):
        assert dict(result.files()) == usual


def test_a_full_disk_leaves_what_was_there(tmp_path, monkeypatch):
    (tmp_path / "file.txt").write_text("old")

    def no_space(path, content):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(output.Path, "write_bytes", no_space)
    with pytest.raises(OutputError, match="No space left on device"):
        output.write_all(tmp_path, [("file.txt", b"new")])
    assert [p.read_text() for p in tmp_path.iterdir()] == ["old"]


def test_an_overwritten_result_leaves_no_stale_files(result, tmp_path):
    result.save(tmp_path)
    result.save(tmp_path, force=True, figures=False)
    names = {p.name for p in tmp_path.iterdir()}
    assert names <= {"curves.csv", "knee.toml", "result.json"}


def test_files_have_the_users_usual_permissions(tmp_path):
    before = os.umask(0o027)
    try:
        output.write_all(tmp_path, [("file.txt", b"")])
    finally:
        os.umask(before)
    assert (tmp_path / "file.txt").stat().st_mode & 0o777 == 0o640


def test_a_folder_that_cannot_be_made(result, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"`folder` is .*; a writable folder is allowed"):
        result.save(tmp_path / "file" / "folder")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda d: d.update(schema="kneecore.result/99"), "`schema` is 'kneecore.result/99'"),
        (lambda d: d.pop("flexion_deg"), "key 'flexion_deg' is missing"),
        (lambda d: d["parameters"][0].pop("acl_femur_x"), "must name the 28 parameters"),
        (lambda d: d["flexion_deg"].update(model_1=[1.0]), r"has shape \(1,\); \(12,\)"),
        (lambda d: d["flexion_deg"].update(model_1=["a"] * 12), "something other than numbers"),
        (lambda d: d.update(case="bones"), "`case` is 'bones'"),
        (lambda d: d.update(parameters=3), "must hold two knees"),
        (lambda d: d["status"].update(model_1="failed"), "does not fit"),
        (lambda d: d["search"]["options"].update(mutants=1), "no usable result"),
        (lambda d: d.update(seed=float("inf")), "not a JSON file: Infinity is no number there"),
        (lambda d: d.update(seed="first"), "`seed` is 'first'; a whole number"),
        (lambda d: d.update(objective_model="x"), "`objective_model` is 'x'; a number or null"),
        (lambda d: d.update(gap_percent=[]), "`gap_percent` is"),
        (lambda d: d["counts"].clear(), "is missing"),
        (lambda d: d["parameters"].append(d["parameters"][0]), "must hold two knees"),
        (lambda d: d["parameters"].pop(), "must hold two knees"),
        (lambda d: d["parameters"][0].update(condyle_radius=None), "`condyle_radius` is nan"),
        (lambda d: d.update(space="moon"), "`space` is 'moon'"),
    ],
)
def test_a_damaged_result_is_refused(result, change, said):
    document = json.loads(result.to_json())
    change(document)
    with pytest.raises(FileFormatError, match=said):
        SearchResult.from_json(json.dumps(document))


@pytest.mark.parametrize("text", ["", "[]", "null", "{", "[" * 100_000, '{"schema": 3}'])
def test_what_is_no_result_is_refused(text):
    with pytest.raises(FileFormatError):
        SearchResult.from_json(text)


def test_files_that_cannot_be_read_are_named(tmp_path):
    with pytest.raises(FileFormatError, match=r"none.*cannot be read"):
        SearchResult.load(tmp_path / "none.json")
    (tmp_path / "result.json").write_bytes(b"\xff\xfe")
    with pytest.raises(FileFormatError, match="UTF-8"):
        SearchResult.load(tmp_path)


def test_a_search_around_another_knee_is_repeated_from_its_files(tmp_path):
    centre = ParameterSpace().from_unit(np.linspace(0.2, 0.8, 28))
    space = ParameterSpace(centre=centre, geometry_bound_mm=0.6)
    found = searched(space, method="exact", solver="equilibrium")
    found.save(tmp_path, figures=False)
    assert "--baseline knee.toml --around current" in command_line(found)
    jsonschema.validate(json.loads(found.to_json()), SCHEMA)
    loaded = SearchResult.load(tmp_path)
    np.testing.assert_array_equal(loaded.model.space.centre, centre)
    np.testing.assert_array_equal(loaded.model.space.lower, space.lower)
    again = ParameterSpace.from_file(tmp_path / "knee.toml", around="current")
    repeated = searched(again, method="exact", solver="equilibrium")
    np.testing.assert_allclose(repeated.x, found.x, rtol=1e-12)
    assert repeated.objective_model == pytest.approx(found.objective_model, rel=1e-12)
    # The box is around another knee, the load-free pose is still the baseline's.
    own = searched(
        ParameterSpace(baseline=centre, geometry_bound_mm=0.6), method="exact", solver="equilibrium"
    )
    assert own.objective_model != pytest.approx(found.objective_model, rel=1e-6)


def test_the_command_names_what_differs_from_the_defaults():
    short = searched(pop_size=20, n_generations=2, training_samples=30, seed=5)
    assert command_line(short) == (
        "python -m kneecore.search --training-samples 30 --pop-size 20 --generations 2 --seed 5"
    )

"""The redone paper's files, there and back, and the command that writes them."""

import json
import re

import pytest
from commands import called
from page import Page

import kneecore
from kneecore import FileFormatError, PaperReport, ParameterSpace, SearchResult
from kneecore.cli.paper import main
from kneecore.paper.claims import packaged_paper

CLAIMS = packaged_paper().claims


@pytest.fixture(scope="module")
def folder(report, tmp_path_factory):
    folder = tmp_path_factory.mktemp("saved") / "paper"
    written = report.save(folder)
    assert written[-1].name == "paper.json"
    assert {path.name for path in written} == {path.name for path in folder.iterdir()}
    return folder


def test_a_report_comes_back_with_what_its_file_holds(report, folder):
    for read in (PaperReport.load(folder), kneecore.load(folder)):
        assert isinstance(read, PaperReport)
        assert read.to_json() == report.to_json() == (folder / "paper.json").read_text()
        assert str(read) == str(report)
        assert read.summary() == report.summary()
        assert read.experiments is None
        assert read.figures() == {}


def test_a_report_that_was_read_says_no_more_than_it_knows(report, folder):
    read = PaperReport.load(folder)
    whole, verdicts = (one.markdown().split("\n## ") for one in (report, read))
    assert [part.splitlines()[0] for part in verdicts[1:]] == ["Verdicts", "Times"]
    assert verdicts[1] in whole
    assert verdicts[2].strip() in [part.strip() for part in whole]
    page = Page(read.html())
    assert page.open == []
    assert page.images == []


def test_a_report_that_was_read_can_be_saved_elsewhere(folder, tmp_path):
    written = PaperReport.load(folder).save(tmp_path / "again")
    assert [path.name for path in written] == ["paper.md", "paper.html", "paper.json"]
    assert written[-1].read_bytes() == (folder / "paper.json").read_bytes()


def test_without_figures_none_is_written_and_old_ones_make_way(report, tmp_path):
    (tmp_path / "figure_2_geometry.png").write_bytes(b"an earlier report's")
    names = {path.name for path in report.save(tmp_path, figures=False)}
    assert not [path for path in tmp_path.iterdir() if path.suffix in (".png", ".svg")]
    assert {"paper.md", "paper.html", "paper.json", "result_both.json"} <= names
    assert ".png" not in (tmp_path / "paper.md").read_text()
    assert Page((tmp_path / "paper.html").read_text()).images == []


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("claims", None, "no usable result"),
        ("quick", "no", "quick"),
        ("paper", {}, "authors"),
        ("paper", {"authors": 3}, "authors"),
        ("versions", {}, "kneecore"),
        ("seed", "0", "seed"),
        ("baseline", {"title": None, "note": None}, "title"),
        ("seconds", {"total": "long"}, "no usable result"),
        ("schema", "kneecore.paper/9", "schema"),
    ],
)
def test_a_broken_file_is_one_line(report, tmp_path, key, value, told):
    file = tmp_path / "paper.json"
    file.write_text(json.dumps({**report.to_dict(), key: value}))
    with pytest.raises(FileFormatError, match=told) as error:
        PaperReport.load(tmp_path)
    assert str(file) in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("outcome", "nearly"),
        ("rule", "around"),
        ("evidence", None),
        ("statement", 3),
        ("limit", "4 %"),
        ("ours", ["a few"]),
        ("ours", 3.0),
    ],
)
def test_a_broken_claim_names_what_is_wrong(report, key, value):
    document = report.to_dict()
    document["claims"][0][key] = value
    with pytest.raises(FileFormatError, match=f"`{key}`") as error:
        PaperReport.from_json(json.dumps(document))
    assert "\n" not in str(error.value)


def test_a_report_by_another_list_says_so(report):
    """Files of earlier versions have fewer claims, and name no figure."""
    document = report.to_dict()
    assert "list" not in str(PaperReport.from_json(json.dumps(document)))
    document["claims"] = [
        {key: value for key, value in claim.items() if key != "figure"}
        for claim in document["claims"][:28]
    ]
    older = PaperReport.from_json(json.dumps(document))
    told = "This report judges 28 claims by an older or newer list; this version of kneecore has"
    for text in (str(older), older.markdown(), older.html()):
        assert f"{told} {len(CLAIMS)}" in " ".join(text.split())


@pytest.mark.parametrize("outcome", ["differs", "indifferent", "cannot be compared"])
def test_an_outcome_follows_from_its_values(report, outcome):
    document = report.to_dict()
    claim = next(c for c in document["claims"] if c["outcome"] == "agrees")
    claim["outcome"] = outcome
    with pytest.raises(FileFormatError, match="follows from `ours`"):
        PaperReport.from_json(json.dumps(document))


def test_a_notebook_shows_the_table(report):
    shown = report._repr_html_()
    assert shown.startswith("<pre")
    assert "claim by claim" in shown


# The command


def test_the_command_writes_what_it_says(capsys, tmp_path):
    folder = tmp_path / "paper"
    code, out, err = called(capsys, main, "--quick", "--out", str(folder))
    assert code == 0
    assert "claims" in out
    assert "files written" in err
    written = {path.name for path in folder.iterdir()}
    document = json.loads((folder / "paper.json").read_text())
    assert len(document["claims"]) == len(CLAIMS)
    assert document["quick"] is True
    markdown = (folder / "paper.md").read_text()
    pictures = set(re.findall(r"\]\(([^)]+\.png)\)", markdown))
    assert len(pictures) == 8
    assert pictures <= written
    assert {name.replace(".png", ".svg") for name in pictures} <= written
    assert (folder / "paper.html").stat().st_size > 100_000
    study = json.loads((folder / "uncertainty.json").read_text())
    assert study["influence"]["parameters"]
    assert study["comparison"]["excess_deg"]["model_1"]
    for case in ("both", "geometry", "material"):
        assert SearchResult.load(folder / f"result_{case}.json").model.space.case == case
    assert not [name for name in written if name.endswith(".tmp")]

    code, out, err = called(capsys, main, "--quick", "--out", str(folder))
    assert code == 2
    assert "--force" in err
    assert out == ""


def test_json_is_one_object_and_nothing_else(capsys, tmp_path):
    file = tmp_path / "knee.toml"
    file.write_text(ParameterSpace(title="My own").to_toml())
    code, out, err = called(
        capsys, main, "--quick", "--json", "--quiet", "--baseline", str(file), "--seed", "3"
    )
    assert code == 0
    assert err == ""
    document = json.loads(out)
    assert document["seed"] == 3
    assert document["baseline"]["title"] == "My own"


def test_an_unwritable_folder_is_one_line_before_anything_is_computed(capsys, tmp_path):
    (tmp_path / "file").write_text("not a folder")
    code, out, err = called(capsys, main, "--quick", "--out", str(tmp_path / "file"))
    assert code == 2
    assert out == ""
    assert len(err.splitlines()) == 1
    assert "`--out`" in err


def test_a_full_disk_takes_no_verdict_away(capsys, tmp_path, monkeypatch):
    folder = tmp_path / "paper"

    def full(*_arguments, **_options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_bytes", full)
    code, out, err = called(capsys, main, "--quick", "--quiet", "--out", str(folder))
    assert code == 2
    assert "claims" in out
    assert len(err.splitlines()) == 1
    assert err.count("No space left") == err.count("cannot be written") == 1
    assert list(folder.iterdir()) == []

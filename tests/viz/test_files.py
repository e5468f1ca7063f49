import io
import json
import zipfile

import models
import pytest
from searches import searched

import kneecore
from kneecore import (
    FileFormatError,
    KneeFile,
    ParameterError,
    SearchSettings,
    asset_path,
    worst_case,
)
from kneecore.files.search import curves_csv
from kneecore.search.result import SearchResult
from kneeviz.actions import downloads as files
from kneeviz.jobs.uploads import parse
from kneeviz.server.app import App

KNEE = asset_path("baseline.toml").read_bytes()


@pytest.fixture(scope="module")
def result():
    return searched(pop_size=20, n_generations=3)


def test_a_knee_file_is_read_whatever_its_name():
    assert isinstance(parse("knee.toml", KNEE), KneeFile)
    assert isinstance(parse("readme", KNEE), KneeFile)


def test_a_downloaded_result_is_read_again(result):
    content = files.result_files(result, "result.json")
    again = parse("result.json", content)
    assert isinstance(again, SearchResult)
    assert (again.x == result.x).all()


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.toml", b"\xff\xfe\x00"), ("a.toml", b""), ("a.toml", b"[parameters"),
        ("a.json", b"{"), ("a.json", b"[]"), ("a.json", b"null"), ("b", b"{}"),
        ("a.toml", KNEE.replace(b"kneecore.knee/1", b"kneecore.knee/9")),
        ("a.toml", KNEE.replace(b"value = 32.1", b"value = nan")),
    ],
)  # fmt: skip
def test_anything_else_is_refused_with_a_reason(name, content):
    with pytest.raises(FileFormatError) as caught:
        parse(name, content)
    assert str(caught.value)


def test_an_unknown_schema_of_a_result_is_refused(result):
    document = json.loads(result.to_json())
    document["schema"] = "kneecore.result/99"
    with pytest.raises(FileFormatError, match="schema"):
        parse("result.json", json.dumps(document).encode())


def test_a_result_of_another_model_than_a_knee_is_refused():
    other = worst_case(models.ishigami(), SearchSettings(pop_size=20, n_generations=3))
    with pytest.raises(ParameterError, match=r"^`result` is of the model '.*'; results of knees"):
        App(port=0, result=other)


def test_a_name_that_is_no_text_is_one_line():
    with pytest.raises(ParameterError, match=r"^`name` is None; "):
        parse(None, KNEE)
    assert isinstance(parse("", KNEE), KneeFile)


@pytest.mark.parametrize("name", ["a.json", "a.toml"])
def test_what_is_refused_is_not_said_at_length(name):
    text = "x" * 100_000
    content = f'{{"schema": "{text}"}}' if name == "a.json" else f'schema = """\n{text[:40_000]}"""'
    with pytest.raises(FileFormatError, match="`schema`") as caught:
        parse(name, content.encode())
    assert len(str(caught.value)) < 300


def test_a_strange_file_is_not_quoted_at_length(tmp_path):
    path = tmp_path / "strange.json"
    path.write_text(json.dumps({"schema": "x" * 100_000}))
    with pytest.raises(FileFormatError, match="no result's") as caught:
        kneecore.load(path)
    assert len(str(caught.value)) < 400


def test_the_curves_are_the_results(result):
    assert files.result_files(result, "curves.csv").decode() == curves_csv(result)


def test_the_archive_holds_all_files(result):
    packed = zipfile.ZipFile(io.BytesIO(files.result_files(result, "result.zip")))
    names = packed.namelist()
    assert {"result.json", "curves.csv"} <= set(names)
    assert any(name.endswith(".png") for name in names)
    assert any(name.endswith(".svg") for name in names)
    assert packed.testzip() is None

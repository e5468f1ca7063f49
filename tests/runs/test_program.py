"""External programs: a template, a folder a run, and what goes wrong with them."""

import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from run_models import SQUARE, plain, points

import kneecore
from kneecore import (
    CsvOutput,
    FileFormatError,
    Input,
    JsonOutput,
    Model,
    ModelError,
    Output,
    ParameterError,
    TextOutput,
)
from kneecore.runs.template import fields_in, filled

SOLVER = """
import json, os, subprocess, sys, time
given = json.load(open(sys.argv[1]))
a, b = given["a"], given["b"]
print("iterations: 7")
if a > float(os.environ.get("LIMIT", "2")):
    {fault}
json.dump({{"results": {{"sum": a + b, "rest": [a * b]}}}}, open("out.json", "w"))
open("out.csv", "w").write(f"t;y\\n0;{{a + b!r}}\\n1;{{a * b!r}}\\n")
print(f"f_1 = {{a + b!r}} Hz\\nf_2 = {{a * b!r}} Hz")
"""
FAULTS = {
    "exit": ("sys.exit('diverged')", "ended with exit code 1: diverged"),
    "no file": ("sys.exit(0)", "the program has not written out.json"),
    "no json": (
        "sys.exit(open('out.json', 'w').write('{') * 0)",
        "out.json: not a JSON file: ",
    ),
    "no key": (
        "sys.exit(open('out.json', 'w').write('{}') * 0)",
        "out.json has no key results.sum",
    ),
    "no number": (
        """sys.exit(open('out.json', 'w').write('{"results": {"sum": null}}') * 0)""",
        "results.sum in out.json is None; a number is needed",
    ),
    "signal": ("os.kill(os.getpid(), 9)", "ended with signal 9: iterations: 7"),
}
READ = JsonOutput("out.json", "results.sum", "results.rest")
OUTPUTS = [Output("y", axis=(1, 2))]
X = points(12)
BAD = X[:, 0] > 0.8


@pytest.fixture
def make(tmp_path, monkeypatch):
    """Return a function that makes the model of a program with a fault."""
    monkeypatch.setenv("LIMIT", "0.8")

    def model(fault="pass", read=READ, **options):
        (tmp_path / "solver.py").write_text(SOLVER.format(fault=fault))
        (tmp_path / "case.json.template").write_text('{"a": {a}, "b": {b:.17g}, "c": {}}')
        return Model.from_program(
            [sys.executable, "solver.py", "{input}"],
            tmp_path / "case.json.template",
            read,
            SQUARE,
            OUTPUTS,
            files=[tmp_path / "solver.py"],
            folder=tmp_path / "runs",
            **options,
        )

    return model


def folders(tmp_path):
    return sorted((tmp_path / "runs").glob("run_*"))


@pytest.mark.parametrize("workers", [None, 2])
@pytest.mark.parametrize(
    "read",
    [
        READ,
        CsvOutput("out.csv", "y", delimiter=";"),
        TextOutput("stdout.txt", r"f_\d = (\S+) Hz"),
        lambda folder: json.loads((folder / "out.json").read_text())["results"]["sum"],
        [JsonOutput("out.json", "results.sum"), TextOutput("stdout.txt", r"^f_2 = (\S+)")],
    ],
    ids=["json", "csv", "text", "function", "two"],
)
def test_outputs_are_read(make, tmp_path, read, workers):
    one = callable(read) and not hasattr(read, "file")
    outputs = 1 if one else 2
    model = make(read=read, workers=workers, keep_runs="all")
    if one:
        model = Model.from_program(
            model._run.command, tmp_path / "case.json.template", read, SQUARE, [Output("y")],
            files=[tmp_path / "solver.py"], folder=tmp_path / "runs", workers=workers,
            keep_runs="all",
        )  # fmt: skip
    y = model.evaluate(X[:3])
    model.close()
    np.testing.assert_array_equal(y, [plain(x)[:outputs] for x in X[:3]])
    assert len(folders(tmp_path)) == 3
    inputs = [json.loads((f / "case.json").read_text()) for f in folders(tmp_path)]
    assert sorted(i["a"] for i in inputs) == sorted(X[:3, 0])  # to the last bit


@pytest.mark.parametrize("fault", FAULTS)
def test_a_run_that_fails_keeps_its_folder(make, tmp_path, fault):
    code, said = FAULTS[fault]
    model = make(code)
    y = model.evaluate(X)
    np.testing.assert_array_equal(y[~BAD], [plain(x) for x in X[~BAD]])
    assert np.isnan(y[BAD]).all()
    assert len(model.failures) == np.count_nonzero(BAD) > 1
    for failure in model.failures:
        assert failure.message.startswith(said)
        given = json.loads((Path(failure.files) / "case.json").read_text())
        assert given["a"] == failure.x[0]
        assert "iterations: 7" in (Path(failure.files) / "stdout.txt").read_text()
    assert sorted(f.files for f in model.failures) == [str(f) for f in folders(tmp_path)]
    assert str(model.failures[0]).endswith(f" (see {model.failures[0].files})")


def test_folders_can_all_be_taken_away(make, tmp_path):
    model = make("sys.exit(3)", keep_runs="none")
    model.evaluate(X)
    assert {f.files for f in model.failures} == {None}
    assert folders(tmp_path) == []


@pytest.mark.parametrize("workers", [None, 2])
def test_a_program_that_hangs_is_ended_with_what_it_started(make, workers):
    marker = f"63.{os.getpid()}"
    model = make(f"subprocess.run(['sleep', '{marker}'])", timeout_s=0.5, workers=workers)
    began = time.monotonic()
    y = model.evaluate(X)
    model.close()
    assert time.monotonic() - began < 10.0
    assert np.isnan(y).all(axis=1).tolist() == BAD.tolist()
    assert {(f.kind, f.message) for f in model.failures} == {
        ("timed out", "took longer than 0.5 s")
    }
    listed = subprocess.run(["ps", "ax", "-o", "args"], capture_output=True, text=True, check=True)
    assert marker not in listed.stdout


def test_a_cancelled_computation_ends_its_programs(make):
    model = make("time.sleep(60)", workers=2)
    began = time.monotonic()
    with pytest.raises(kneecore.Cancelled):
        model.examine(X, watch=lambda done: time.monotonic() - began > 1.0)
    assert time.monotonic() - began < 10.0


def test_retries(make, tmp_path):
    mark = str(tmp_path / "mark")
    once = f"os.path.exists({mark!r}) or sys.exit(open({mark!r}, 'w').close() or 1)"
    model = make(once, retries=1)
    done = model.examine(X)
    assert done.counts == {"failed": 0, "retried": 1}


def test_runs_of_a_program_are_kept_by_what_it_is(make, tmp_path):
    keep = tmp_path / "kept"
    first = make(keep=keep)
    y = first.evaluate(X)
    first.close()
    again = make(keep=keep)
    done = again.examine(X)
    np.testing.assert_array_equal(done.y, y)
    assert done.counts["reused"] == len(X)
    again.close()
    other = make(keep=keep, read=CsvOutput("out.csv", "y", delimiter=";"))
    assert other.examine(X[:2]).counts["reused"] == 0
    other.close()


def test_a_program_that_is_not_there(tmp_path):
    model = Model.from_program(["no-such-program", "{a}", "{b}"], None, READ, SQUARE, OUTPUTS)
    with pytest.raises(ModelError) as error:
        model.evaluate(X)
    line = "run 3 could not start no-such-program (No such file or directory)"
    assert str(error.value).startswith(f"{line} (see ")
    for failure in model.failures:
        os.remove(Path(failure.files) / "stdout.txt")


def test_fields():
    names = ["k", "k_1", "a b"]
    text = '{"k": {k}, "one": {k_1:.3e}, "two": {a b}, "other": {x}, "empty": {}, {{k}}}'
    assert fields_in(text, names) == {"k", "k_1", "a b"}
    assert filled(text, {"k": 0.1, "k_1": 1234.5, "a b": 3.0}) == (
        '{"k": 0.1, "one": 1.234e+03, "two": 3.0, "other": {x}, "empty": {}, {0.1}}'
    )
    with pytest.raises(ParameterError, match=r"`template` has the field '\{k:d\}'; a format of"):
        fields_in("{k:d}", names)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"command": []}, "`command` is []; a program and its arguments are allowed"),
        ({"command": "solve 'x"}, "`command` is \"solve 'x\"; a program"),
        ({"command": ["solve", 3]}, "`command` is ['solve', 3]; a program"),
        ({"read": 3}, "`read` is 3; a function of the run's folder is allowed, such as"),
        ({"read": []}, "`read` is []; a function"),
        ({"keep_runs": "some"}, "`keep_runs` is 'some'; 'failed' or 'all' or 'none' is allowed"),
        ({"files": ["not/there"]}, "`files` has "),
        ({"command": ["solve", "{a}"]}, "`template` has no field for 'b'; each uncertain input "
         "needs one, such as {b}, there or in the command"),
        ({"template": "not/there"}, "`template` not/there: cannot be read (No such file"),
        ({"template": "/dev/zero"}, "`template` /dev/zero: cannot be read (it is a device"),
    ],
)  # fmt: skip
def test_what_a_program_is_made_of(options, said):
    usual = {"command": ["solve", "{a}", "{b}"], "template": None, "read": READ}
    with pytest.raises((ParameterError, FileFormatError)) as error:
        Model.from_program(**usual | options, inputs=SQUARE, outputs=OUTPUTS)
    assert str(error.value).startswith(said)
    assert "\n" not in str(error.value)


def test_an_input_that_is_held_needs_no_field():
    inputs = [*SQUARE, Input("c", lower=1.0, upper=1.0)]
    Model.from_program("solve {a} {b}", None, READ, inputs, OUTPUTS)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: JsonOutput("../out.json", "a"), "`file` is '../out.json'; a file in the run's"),
        (lambda: JsonOutput("/etc/passwd", "a"), "`file` is '/etc/passwd'; a file in the run's"),
        (lambda: JsonOutput("out.json"), "`keys` is empty; at least one"),
        (lambda: JsonOutput("out.json", 3), "`keys` is 3; text is allowed"),
        (lambda: CsvOutput("out.csv", None), "`column` is None; text is allowed"),
        (lambda: CsvOutput("out.csv", "a", ""), "`delimiter` is ''; one character is allowed"),
        (lambda: TextOutput("out", "(a"), "`pattern` is '(a' (missing ), unterminated"),
    ],
)
def test_what_a_reader_is_made_of(make, said):
    with pytest.raises(ParameterError) as error:
        make()
    assert str(error.value).startswith(said)


@pytest.mark.parametrize(
    ("read", "content", "said"),
    [
        (CsvOutput("out", "y"), "", "out has no column y"),
        (CsvOutput("out", "y"), "t,y\n1,2\n3\n", "y in out is None; a number is needed"),
        (CsvOutput("out", "y"), "t,y\n1,fast\n", "y in out is 'fast'; a number is needed"),
        (JsonOutput("out", "a.7"), '{"a": [1]}', "out has no key a.7"),
        (JsonOutput("out", "a"), "[" * 1000, "brackets are nested 1,000 deep"),
        (TextOutput("out", "f = (.*)"), "none", "nothing in out looks like 'f = (.*)'"),
        (TextOutput("out", "f = (.*)"), "f = ?", "what 'f = (.*)' finds in out is '?'; a number"),
        (TextOutput("out", "f"), "\xff", None),
    ],
)
def test_what_cannot_be_read_is_told(tmp_path, read, content, said):
    (tmp_path / "out").write_bytes(content.encode("latin-1"))
    with pytest.raises(FileFormatError, match=re.escape(said or "out: not a text file in UTF-8")):
        read(tmp_path)

"""A model in a TOML file, by the library and from a terminal; each wrong key in one line."""

import gc
import json
import subprocess
import sys

import numpy as np
import pytest

import kneecore
from kneecore import FileFormatError, Model
from kneecore.cli import search, sweep, uncertainty

SPRINGS = """
name = "two springs"

[[inputs]]
name = "k_1"
nominal = 100.0
tolerance_percent = 10
unit = "N/mm"

[[inputs]]
name = "k_2"
lower = 45.0
upper = 55.0

[[outputs]]
name = "stretch"
unit = "mm"
axis = [1.0, 2.0, 5.0]
axis_unit = "N"

"""
FUNCTION = """
[function]
run = "two_springs_{}:stretch"
batched = {}
picture_unit = "mm"
"""
PROGRAM = f"""
[program]
command = ["{sys.executable}", "solver.py", "{{input}}"]
template = "case.json.template"
files = ["solver.py"]
read = [{{ json = "out.json", keys = ["stretch"] }}]

[runs]
timeout_s = 20
retries = 1
"""
MODULE = """
import numpy as np

def stretch(k):
    return (1.0 / k[0] + 1.0 / k[1]) * np.array([1.0, 2.0, 5.0])

def many(k):
    return np.array([stretch(one) for one in k])
"""
SOLVER = """
import json, sys
given = json.load(open(sys.argv[1]))
c = sum(1.0 / k for k in given["springs"])
json.dump({"stretch": [c * f for f in (1.0, 2.0, 5.0)]}, open("out.json", "w"))
"""
X = np.array([[100.0, 50.0], [95.0, 46.0]])
Y = (1.0 / X).sum(axis=1)[:, None] * [1.0, 2.0, 5.0]


@pytest.fixture
def write(tmp_path):
    """Return a function that writes a model's file with all that it needs beside it."""
    # Modules are known by their names for as long as Python runs.
    own = f"two_springs_{abs(hash(tmp_path))}"
    (tmp_path / f"{own}.py").write_text(MODULE)
    (tmp_path / "solver.py").write_text(SOLVER)
    (tmp_path / "case.json.template").write_text('{"springs": [{k_1}, {k_2}]}')

    def model(text):
        path = tmp_path / "model.toml"
        path.write_text(text.replace("two_springs_{}", own))
        return path

    return model


@pytest.mark.parametrize(
    "how",
    [
        FUNCTION.replace("= {}", "= false"),
        FUNCTION.replace("= {}", "= true").replace(":stretch", ":many"),
        PROGRAM,
    ],
    ids=["function", "batched", "program"],
)
@pytest.mark.parametrize("workers", [None, 2])
def test_a_model_is_what_its_file_says(write, how, workers):
    model = Model.from_file(write(SPRINGS + how)).with_runs(workers=workers)
    np.testing.assert_array_equal(model.evaluate(X), Y)
    model.close()
    assert (model.name, model.names) == ("two springs", ("k_1", "k_2"))
    assert model.picture_unit == "mm" * (how != PROGRAM)
    np.testing.assert_array_equal(model.lower, [90.0, 45.0])
    assert [column.label for column in model.columns] == ["1 N", "2 N", "5 N"]


def test_options_of_runs_are_in_the_file_too(write, tmp_path):
    how = FUNCTION.replace("= {}", "= false") + '[runs]\nkeep = "kept.jsonl"\nworkers = 2\n'
    model = Model.from_file(write(SPRINGS + how))
    model.evaluate(X)
    model.close()
    assert (tmp_path / "kept.jsonl").read_text().count("\n") == 3
    assert model._options.workers == 2


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "[[inputs]]",
            "[[input]]",
            "`input` is no key of a model's file; name, note, inputs,",
        ),
        ('name = "two springs"', "name = 3", "`name` is 3; text is allowed"),
        ("nominal = 100.0", 'nominal = "x"', "`inputs[1]`: `nominal of k_1` is 'x'; a finite numb"),
        ("nominal = 100.0", "", "`inputs[1]`: `nominal of k_1` is None; a number is needed"),
        (
            "lower = 45.0",
            "lowest = 45.0",
            "`inputs[2].lowest` is no key of a model's file; name",
        ),
        ('name = "k_2"', "", "`inputs[2].name` is missing"),
        ('name = "k_2"', 'name = "k_1"', "`inputs` has the name 'k_1' twice; each needs its own"),
        (
            "axis = [1.0, 2.0, 5.0]",
            'axis = "all"',
            "`outputs[1]`: `axis of stretch` is 'all'",
        ),
        (
            "lower = 45.0",
            "lower = 45.0\nchoices = [1, 2]",
            "`inputs[2]`: the bounds of `k_2` are given in no way, or in several; one is needed",
        ),
        (
            "lower = 45.0\nupper = 55.0",
            "choices = 3",
            "`inputs[2]`: `choices of k_2` is 3; a row of 1 to 100,000 numbers is allowed",
        ),
        (
            "upper = 55.0",
            "upper = 55.0\ninteger = 1",
            "`inputs[2]`: `integer of k_2` is 1; True or False is allowed",
        ),
        (
            "upper = 55.0",
            'upper = 55.0\ndistribution = "beta"',
            "`inputs[2]`: `distribution of k_2` is 'beta'; 'uniform' or 'normal' or",
        ),
        (
            "upper = 55.0",
            "upper = 55.0\ndeviations = 2",
            "`inputs[2]`: `deviations of k_2` is 2; a uniform distribution has none",
        ),
        ("upper = 55.0", "upper = 55.0\nmode = 2", "`inputs[2]`: `mode of k_2` is 2; a uniform di"),
        (
            "upper = 55.0",
            "upper = 55.0\nquantile = 2",
            "`inputs[2]`: `quantile of k_2` is 2; abo",
        ),
        ('name = "two springs"', 'correlation = "all"', "`correlation` is not an array of numbers"),
        (
            'name = "two springs"',
            'correlation = [["k_1", "k_3", 0.5]]',
            "`correlation` has ['k_1', 'k_3', 0.5] in it; (input, input, number) with two",
        ),
        ("[[outputs]]", "[outputs]", "`outputs` is {"),
        ("[runs]", "[runs]\nworkers = 0", "`workers` is 0; a whole number from 1"),
        ("timeout_s = 20", "timeout = 20", "`runs.timeout` is no key of a model's file; workers,"),
        ("timeout_s = 20", "timeout_s = -1", "`timeout_s` is -1 s; above 0 is allowed"),
        ("retries = 1", "retries = 1.5", "`retries` is 1.5; a whole number from 0 to 100"),
        ("read = [{ json = ", "read = [{ xml = ", "`program.read[1].xml` is no key of a model's"),
        ('keys = ["stretch"]', 'column = "y"', "`program.read[1].keys` is missing"),
        ('keys = ["stretch"]', "keys = [1]", "`program.read[1].keys` is [1]; texts are allowed"),
        (
            '"out.json"',
            '"/tmp/out.json"',
            "`program.read[1]`: `file` is '/tmp/out.json'",
        ),
        ("template = ", "templates = ", "`program.templates` is no key of a model's file; command"),
        ('"case.json.template"', '"none"', "`program`: `template` "),
        ('["solver.py"]', '["none.py"]', "`program`: `files` has "),
        ('["solver.py"]', '"solver.py"', "`program.files` is 'solver.py'; a list of files is all"),
        ("command = [", "command = [[", "not a TOML file: "),
        (
            "[program]",
            '[function]\nrun = "a:b"\n[program]',
            "`function` or `program` is needed",
        ),
        (
            "[program]",
            "[program]\nshell = true",
            "`program.shell` is no key of a model's file",
        ),
    ],
)
def test_a_wrong_key_is_told_in_one_line(write, old, new, said):
    text = SPRINGS + PROGRAM
    assert text.count(old) >= 1
    path = write(text.replace(old, new, 1))
    with pytest.raises(FileFormatError) as error:
        Model.from_file(path)
    assert str(error.value).startswith(f"{path}: {said}")
    assert "\n" not in str(error.value)


AS_THEY_ARE = (
    SPRINGS.replace("upper = 55.0", "upper = 55.0\ninteger = true")
    .replace('unit = "N/mm"', 'distribution = "log-normal"\ndeviations = 2\nquantile = 0.9')
    .replace('name = "two springs"', 'correlation = [["k_1", "k_2", 0.5]]')
)


def test_inputs_as_they_are(write):
    function = FUNCTION.replace("= {}", "= false")
    model = Model.from_file(write(AS_THEY_ARE + function))
    one, two = model.inputs
    assert (one.distribution, one.deviations, one.quantile) == ("log-normal", 2.0, 0.9)
    assert two.allowed == tuple(range(45, 56))
    assert model.correlation[0, 1] == 0.5
    listed = SPRINGS.replace("lower = 45.0\nupper = 55.0", "choices = [47.0, 50.0]")
    assert Model.from_file(write(listed + function)).inputs[1].choices == (47.0, 50.0)


def test_a_program_gets_whole_numbers_as_such(write, tmp_path):
    (tmp_path / "case.json.template").write_text('{"springs": [{k_1}, {k_2:d}]}')
    model = Model.from_file(write(AS_THEY_ARE + PROGRAM))
    np.testing.assert_array_equal(model.evaluate(X), Y)
    assert model.failures == ()
    (tmp_path / "case.json.template").write_text('{"springs": [{k_1:d}, {k_2}]}')
    with pytest.raises(FileFormatError, match=r"`template` has the field '\{k_1:d\}'"):
        Model.from_file(write(AS_THEY_ARE + PROGRAM))


@pytest.mark.parametrize(
    ("named", "said"),
    [
        ("3", "`function.run`: `run` is 3; text is allowed"),
        ('"stretch"', "`function.run`: `run` is 'stretch'; 'package.module:function' is allowed"),
        ('"os:system(1)"', "`function.run`: `run` is 'os:system(1)'; 'package.module:function' is"),
        (
            '"no_such_module:f"',
            "`function.run`: `run` is 'no_such_module:f', which cannot",
        ),
        ('"math:no"', "`function.run`: `run` is 'math:no'; the module math has no such function"),
        ('"math:pi"', "`function.run`: `run` is 'math:pi'; the module math has no such function"),
    ],
)
def test_a_function_is_found_by_its_name(write, named, said):
    path = write(f"{SPRINGS}[function]\nrun = {named}\n")
    with pytest.raises(FileFormatError) as error:
        Model.from_file(path)
    assert str(error.value).startswith(f"{path}: {said}")


@pytest.mark.parametrize("content", ["", "a" * 2_000_000, "[" * 100, "\0", "inputs = 3"])
def test_a_file_that_is_no_model(write, content):
    with pytest.raises(FileFormatError) as error:
        Model.from_file(write(content))
    assert len(str(error.value)) < 400
    with pytest.raises(FileFormatError, match="cannot be read"):
        Model.from_file(write(content).parent)


# From a terminal.


def ran(main, arguments, capsys):
    code = main([str(a) for a in arguments])
    printed = capsys.readouterr()
    return code, printed.out, printed.err


QUICK = ["--training-samples", 8, "--pop-size", 40, "--generations", 30, "--quiet"]


def test_a_search(write, tmp_path, capsys):
    path = write(SPRINGS + PROGRAM)
    asked = ["--model", path, *QUICK, "--workers", 2, "--keep", tmp_path / "runs", "--json"]
    code, first, err = ran(search.main, [*asked, "--out", tmp_path / "found"], capsys)
    assert (code, err) == (0, "")
    told = json.loads(first)
    assert told["counts"]["models_reused"] == 0
    assert told["parameters"][0] == {"k_1": 110.0, "k_2": 55.0}
    loaded = kneecore.load(tmp_path / "found")
    assert loaded.model.name == "two springs"
    code, again, _ = ran(search.main, asked, capsys)
    told_again = json.loads(again)
    assert told_again["counts"]["models_reused"] == told["counts"]["models_simulated"] == 11
    for key in ("seconds", "counts", "digest"):
        del told[key], told_again[key]
    assert told == told_again


def test_sampling_and_influence(write, tmp_path, capsys):
    path = write(SPRINGS + FUNCTION.replace("= {}", "= false"))
    options = ["--model", path, "--samples", 300, "--influence", "--base-samples", 32, "--quiet"]
    code, out, err = ran(uncertainty.main, options, capsys)
    assert (code, err) == (0, "")
    assert "Model: two springs." in out
    assert "k_2" in out


def test_a_quantile_box_and_correlated_inputs_from_a_terminal(write, capsys):
    path = write(AS_THEY_ARE + FUNCTION.replace("= {}", "= false"))
    code, out, err = ran(search.main, ["--model", path, "--quantile", 0.8, *QUICK], capsys)
    assert (code, err) == (0, "")
    assert "Bounds: the central 80 % of each distribution" in out
    options = ["--model", path, "--samples", 100, "--quiet"]
    code, out, err = ran(uncertainty.main, options, capsys)
    assert (code, err) == (0, "")
    told = "Inputs: 1 log-normal with bounds at 2 sd, 1 uniform, correlated."
    assert told in " ".join(out.split())
    code, out, err = ran(uncertainty.main, [*options, "--influence"], capsys)
    assert (code, out) == (2, "")
    assert "`correlation` of the model is given; Sobol' indices share the variance out" in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("main", "options"),
    [
        (search.main, [*QUICK]),
        (uncertainty.main, ["--samples", 5]),
    ],
    ids=["search", "uncertainty"],
)
def test_a_command_lets_go_of_its_runs(write, tmp_path, capsys, main, options):
    path = write(SPRINGS + FUNCTION.replace("= {}", "= false"))
    asked = [*options, "--model", path, "--keep", tmp_path / "runs", "--quiet"]
    gc.disable()  # which would let go of them some time
    try:
        assert [ran(main, asked, capsys)[0] for _ in range(2)] == [0, 0]
    finally:
        gc.enable()


@pytest.mark.parametrize(
    "sweep_of",
    [["training", "--sizes", 6, 8, "--seeds", 1], ["bound", "--bounds-mm", 0.5, 1.0]],
    ids=["training", "bound"],
)
def test_sweeps(write, capsys, sweep_of):
    path = write(SPRINGS + FUNCTION.replace("= {}", "= false"))
    code, out, err = ran(sweep.main, [*sweep_of, "--model", path, "--quiet"], capsys)
    assert (code, err) == (0, "")
    assert "two springs" in out


@pytest.mark.parametrize("main", [search.main, uncertainty.main])
@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            ["--case", "material"],
            "`--case` is 'material'; it is the knee's, and with",
        ),
        (["--solver", "equilibrium"], "`--solver` is 'equilibrium'; it is the knee's"),
        (["--workers", 0], "`--workers` is 0; a whole number from 1"),
        (
            ["--workers", 2, "--scheduler", "tcp://a:1"],
            "`--scheduler` is 'tcp://a:1'; it has",
        ),
        (["--timeout-s", 0], "`--timeout-s` is 0 s; above 0 is allowed"),
        (["--threads", 0], "`--threads` is 0; a whole number"),
    ],
)
def test_options_that_are_not_allowed(write, capsys, main, options, said):
    path = write(SPRINGS + PROGRAM)
    code, out, err = ran(main, ["--model", path, *options], capsys)
    assert (code, out) == (2, "")
    assert f": {said}" in err
    assert err.count("\n") == 1


def test_runs_of_the_knee_are_not_kept(tmp_path, capsys):
    code, _, err = ran(search.main, ["--keep", tmp_path / "runs"], capsys)
    assert code == 2
    assert "`--keep` is " in err
    assert not (tmp_path / "runs").exists()


def test_no_scheduler_is_one_line(write):
    path = write(SPRINGS + FUNCTION.replace("= {}", "= false"))
    command = [sys.executable, "-m", "kneecore.search", "--model", str(path), "--quiet"]
    done = subprocess.run(
        [*command, "--scheduler", "tcp://127.0.0.1:1"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    said = "python -m kneecore.search: no scheduler answers at tcp://127.0.0.1:1 (Connection refus"
    assert done.stderr.startswith(said)
    assert done.stderr.count("\n") == 1

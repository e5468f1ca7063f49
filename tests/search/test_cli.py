"""The command lines, as a user calls them: in a process of their own."""

import json
import os
import signal
import subprocess
import sys
import time

import jsonschema
import numpy as np
import pytest
from commands import called
from results import SCHEMA
from searches import searched

from kneecore import GeneticOptions, ParameterSpace, SearchResult, simulate
from kneecore._assets import asset_path
from kneecore.cli.search import main as search_main
from kneecore.cli.simulate import main as simulate_main
from kneecore.report.command import command_line

SMALL = ["--pop-size", "20", "--generations", "10"]


def run(module, *arguments, **options):
    return subprocess.run(
        [sys.executable, "-m", f"kneecore.{module}", *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        **options,
    )


def in_process(capsys, *arguments, module="search"):
    return called(capsys, search_main if module == "search" else simulate_main, *arguments)


def test_json_is_one_object_and_nothing_else():
    done = run("search", "--json", *SMALL)
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    jsonschema.validate(document, SCHEMA)
    assert document["seconds"].keys() >= {"compile", "sampling", "fit", "search"}
    assert "searching" in done.stderr
    assert done.stdout.count("\n") == 1


def test_quiet_says_nothing_on_stderr(capsys):
    code, out, err = in_process(capsys, "--quiet", *SMALL)
    assert code == 0
    assert err == ""
    assert "Difference in extension" in out


def test_what_is_printed_is_what_the_library_finds(capsys):
    code, out, _ = in_process(
        capsys, "--json", "--case", "geometry", "--geometry-bound-mm", "0.5", "--slope-bound-deg",
        "0.5", "--seed", "3", "--training-samples", "40", "--objective", "flexion",
        "--rest-length", "fixed", "--runs", "2", "--ga.blx-alpha", "0.3", "--threads", "1",
        "--space", "surrogate", *SMALL,
    )  # fmt: skip
    assert code == 0
    found = SearchResult.from_json(out)
    expected = searched(
        ParameterSpace("geometry", 0.5, 0.5),
        seed=3,
        training_samples=40,
        objective="flexion",
        rest_length="fixed",
        n_runs=2,
        options=GeneticOptions(blx_alpha=0.3),
        pop_size=20,
        n_generations=10,
    )
    np.testing.assert_array_equal(found.x, expected.x)
    assert command_line(found) == command_line(expected)
    assert "--ga.blx-alpha 0.3" in command_line(found)


def test_the_command_in_a_result_gives_that_result_again(capsys, tmp_path, monkeypatch):
    first = in_process(capsys, "--json", "--seed", "11", "--material-bound-percent", "5", *SMALL)[1]
    words = json.loads(first)["command"].split()
    assert words[:3] == ["python", "-m", "kneecore.search"]
    again = in_process(capsys, "--json", *words[3:])[1]
    one, two = json.loads(first), json.loads(again)
    for document in (one, two):
        del document["seconds"], document["digest"]  # of the times too
    assert one == two


def test_out_writes_everything_and_force_is_needed_to_overwrite(capsys, tmp_path):
    folder = tmp_path / "result"
    code, _, err = in_process(capsys, "--out", str(folder), *SMALL)
    assert code == 0
    assert "10 files written" in err
    assert SearchResult.load(folder).settings.pop_size == 20
    code, out, err = in_process(capsys, "--out", str(folder), *SMALL)
    assert (code, out) == (2, "")
    assert "holds a result.json already; another folder or --force is allowed" in err
    assert in_process(capsys, "--out", str(folder), "--force", "--quiet", *SMALL)[0] == 0


def test_a_knee_file_of_ones_own(capsys, tmp_path):
    text = asset_path("baseline.toml").read_text(encoding="utf-8")
    path = tmp_path / "mine.toml"
    path.write_text(text.replace("value = 32.1", "value = 31.0"), encoding="utf-8")
    code, out, _ = in_process(
        capsys, "--baseline", str(path), "--json", "--out", str(tmp_path / "o"), *SMALL
    )
    assert code == 0
    document = json.loads(out)
    assert document["baseline"]["parameters"]["condyle_radius"] == 0.031
    assert "--baseline knee.toml" in document["command"]
    again = in_process(capsys, "--baseline", str(tmp_path / "o" / "knee.toml"), "--json", *SMALL)[1]
    assert json.loads(again)["parameters"] == document["parameters"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--pop-size", "3"], "`--pop-size` is 3; at least 10 is allowed"),
        (["--generations", "0"], "`--generations` is 0"),
        (["--runs", "0"], "`--runs` is 0"),
        (["--training-samples", "10"], "`--training-samples` is 10; with 28 free parameters"),
        (["--geometry-bound-mm", "-1"], "`--geometry-bound-mm` is -1 mm"),
        (["--geometry-bound-mm", "nan"], "`--geometry-bound-mm` is nan mm"),
        (["--material-bound-percent", "150"], "a stiffness of at least 0 is allowed"),
        (["--case", "material", "--material-bound-percent", "0"], "zero width"),
        (["--seed", "-1"], "`--seed` is -1"),
        (["--threads", "0"], "`--threads` is 0"),
        (["--baseline", "none.toml"], "none.toml: cannot be read"),
        (["--out", "/dev/null/x"], "a writable folder is allowed"),
        (["--case", "bones"], "'bones'"),
        (["--pop-size", "many"], "--pop-size"),
        (["--sed", "3"], "--sed"),
        (["--ga.elite-fraction", "nan"], "three positive shares with sum 1"),
        (["--out", "x" * 300], "a writable folder is allowed"),
        (["--out", ""], "`--out` is empty"),
        (["--baseline", ""], "the name of a knee file is empty"),
        (["--slope-bound-deg", "100"], "less than 90 is allowed"),
        (["--geometry-bound-mm", "100"], "the bounds are too wide"),
        (["--ga.rank-eta-min", "2"], "`rank_eta_min` is 2; 0 to 1 is allowed"),
    ],
)
def test_a_users_mistake_gets_one_line_and_exit_code_2(capsys, arguments, said):
    code, out, err = in_process(capsys, *arguments)
    assert code == 2
    assert out == ""
    assert said in err
    assert len([line for line in err.splitlines() if not line.endswith("...")]) == 1
    assert "Traceback" not in err


def test_a_refused_command_leaves_no_folder(capsys, tmp_path):
    folder = tmp_path / "new"
    for wrong in (["--pop-size", "9"], ["--training-samples", "3"], ["--seed", "-1"]):
        assert in_process(capsys, *wrong, "--out", str(folder))[0] == 2
        assert not folder.exists()


def test_a_pair_that_fails_in_the_true_model_is_no_success(capsys):
    code, out, _ = in_process(capsys, "--geometry-bound-mm", "4", "--quiet", "--json")
    assert code == 1
    document = json.loads(out)
    assert document["objective_model"] is None
    assert "--space model" in document["summary"]


@pytest.mark.parametrize("module", ["search", "simulate"])
def test_a_full_stdout_is_one_line(module):
    arguments = SMALL if module == "search" else []
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", f"kneecore.{module}", *arguments],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 2
    assert "stdout cannot be written (No space left on device)" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_closed_stderr_does_not_spoil_stdout():
    command = f"{sys.executable} -m kneecore.search --json {' '.join(SMALL)} 2>&-"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    assert done.returncode == 0
    json.loads(done.stdout)


def test_a_terminal_without_unicode_gets_a_table():
    environment = os.environ | {"PYTHONIOENCODING": "ascii"}
    done = run("simulate", env=environment)
    assert done.returncode == 0, done.stderr
    assert "118.99" in done.stdout


def test_help_needs_none_of_the_heavy_libraries():
    code = (
        "import sys; from kneecore.cli import search as cli\n"
        "try: cli.main(['--help'])\n"
        "except SystemExit as stop: assert not stop.code\n"
        "heavy = {'numba', 'scipy', 'matplotlib', 'viser', 'trimesh'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "--geometry-bound-mm" in done.stdout


def test_importing_kneecore_loads_no_plotting_library():
    code = (
        "import sys, kneecore; kneecore.worst_case\n"
        "assert not {'matplotlib', 'viser', 'trimesh', 'kneeviz'} & set(sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def interrupted(tmp_path, *arguments):
    """Start a search that would take minutes, press Ctrl-C, and time how long it takes to end."""
    return press_ctrl_c_after("searching", tmp_path, "--generations", "100000", *arguments)


def press_ctrl_c_after(stage, folder, *arguments, **options):
    with subprocess.Popen(
        [sys.executable, "-m", "kneecore.search", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
        **options,
    ) as process:
        try:
            for line in process.stderr:
                if line.startswith(stage):
                    break
            time.sleep(0.3)
            process.send_signal(signal.SIGINT)
            start = time.monotonic()
            out, err = process.communicate(timeout=20)
            return process.returncode, out, err, time.monotonic() - start
        finally:
            process.kill()


@pytest.mark.parametrize("space", ["surrogate", "model"])
def test_ctrl_c_ends_cleanly_and_says_that_nothing_was_saved(tmp_path, space):
    code, out, err, seconds = interrupted(tmp_path, "--space", space)
    assert code == 130
    assert out == ""
    assert "interrupted after" in err
    assert "nothing was saved" in err
    assert "Traceback" not in err
    assert seconds < 5.0  # about 0.1 s; a hang is what must not be


def test_ctrl_c_saves_the_best_pair_so_far(tmp_path):
    code, _, err, _ = interrupted(tmp_path, "--space", "model", "--out", "kept")
    assert code == 130
    assert "the best pair until then is in kept" in err
    kept = SearchResult.load(tmp_path / "kept")
    assert kept.stop_reason == "cancelled"
    assert kept.objective_model > 0
    written = sorted(p.name for p in (tmp_path / "kept").iterdir())
    assert written == ["checkpoint", "curves.csv", "result.json"]


def test_ctrl_c_while_the_kernels_are_compiled(tmp_path):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "empty")}
    code, out, err, _ = press_ctrl_c_after("loading", tmp_path, "--out", "kept", env=environment)
    assert code == 130
    assert out == ""
    assert "interrupted; nothing was saved" in err
    assert not list((tmp_path / "kept").iterdir())


def without_times(text):
    """Return the bytes of a result's JSON but for how long it took, which its digest knows too."""
    document = json.loads(text)
    del document["seconds"], document["digest"]
    return json.dumps(document)


def test_the_answer_does_not_depend_on_the_kernels_cache(tmp_path, capsys):
    # The search with the fewest kernels; a second process compiles with the first.
    few = ["--json", "--method", "exact", "--solver", "equilibrium", "--case", "material"]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "empty")}
    cold = run("search", *few, env=environment)
    assert cold.returncode == 0, cold.stderr
    assert list(tmp_path.rglob("*.nbc"))
    code, warm, _ = in_process(capsys, *few)
    assert code == 0
    assert without_times(cold.stdout) == without_times(warm)


def test_a_reader_that_has_gone_is_no_error():
    done = subprocess.run(
        f"{sys.executable} -m kneecore.simulate | head -1; exit ${{PIPESTATUS[0]}}",
        shell=True,
        executable="/bin/bash",
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr


def test_bounds_around_a_current_knee_need_a_file(capsys):
    code, _, err = in_process(capsys, "--around", "current", *SMALL)
    assert code == 2
    assert "`--around` is 'current'; it needs a `--baseline` file" in err


def test_simulate_prints_the_baselines_table():
    done = run("simulate")
    assert done.returncode == 0
    assert "-3.72" in done.stdout
    assert "reconstruction" in done.stdout


def test_simulate_a_current_knee_as_json(capsys, tmp_path):
    current = 1.01 * ParameterSpace().baseline
    path = tmp_path / "knee.toml"
    path.write_text(ParameterSpace().to_toml(current), encoding="utf-8")
    code, out, _ = in_process(capsys, "--baseline", str(path), "--json", module="simulate")
    assert code == 0
    document = json.loads(out)
    schema = json.loads(asset_path("response.schema.json").read_text(encoding="utf-8"))
    jsonschema.validate(document, schema)
    assert set(document) == set(schema["properties"]) - {"half_step_change_deg"}  # not asked for
    expected = np.degrees(simulate(current).flexion)
    np.testing.assert_allclose(document["flexion_deg"], expected, atol=1e-9)
    assert document["status"] == "ok"


def test_simulate_a_knee_that_fails(capsys, tmp_path):
    x = ParameterSpace().baseline.copy()
    x[22:26] *= 1e5
    path = tmp_path / "knee.toml"
    path.write_text(ParameterSpace().to_toml(x), encoding="utf-8")
    code, out, _ = in_process(capsys, "--baseline", str(path), "--json", module="simulate")
    assert code == 1
    assert json.loads(out)["flexion_deg"] == [None] * 12

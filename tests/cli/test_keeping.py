"""Long commands lose nothing: stopped in any way, they go on to the same bytes."""

import errno
import json
import os
import random
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from commands import called

from kneecore.cli import keeping, paper, search, sweep, uncertainty
from kneecore.cli import run as cli_run
from kneecore.cli.progress import ProgressDisplay
from kneecore.files import checkpoint
from kneecore.files import folder as folders

COMMANDS = {
    "search in the model": (search, "--space", "model", "--pop-size", "20", "--generations", "30"),
    "two runs in the model": (
        *(search, "--space", "model", "--pop-size", "20", "--generations", "8", "--runs", "2"),
    ),
    "exact search": (search, "--method", "exact", "--case", "geometry"),
    "samples and influence": (
        *(uncertainty, "--samples", "8192", "--influence", "--base-samples", "64"),
        *("--no-intervals", "--sampling", "sobol"),
    ),
    "sweep of bounds": (
        *(sweep, "bound", "--bounds-mm", "0.5", "--tolerance-mm", "0.1"),
        *("--case", "geometry", "--solver", "equilibrium"),
    ),
    "sweep of training": (*(sweep, "training", "--sizes", "40", "50", "--seeds", "2"),),
    "paper": (paper, "--quick"),
}
# How long something took, and what is said or drawn of it.
TIMES = {"seconds", "versions", "digest", "why", "ours", "outcome"}


@pytest.fixture(autouse=True)
def at_once(monkeypatch):
    """Everything is kept at once, and a run that is stopped has time to see it."""
    monkeypatch.setattr(checkpoint, "INTERVAL_S", 0.0)
    monkeypatch.setattr(cli_run, "PATIENCE", 60.0)


@pytest.fixture(autouse=True)
def no_figures(monkeypatch):
    """Figures take most of the time, and follow from the numbers."""
    contents = folders.contents
    monkeypatch.setattr(
        folders, "contents", lambda result, form, *, figures: contents(result, form, figures=False)
    )


@pytest.fixture
def stop_at(monkeypatch):
    """Press Ctrl-C (or end politely) at a report of progress."""

    def stop(count, number=signal.SIGINT):
        seen = []

        def show(self, report):
            seen.append(report)
            if len(seen) == count:
                os.kill(os.getpid(), number)
                time.sleep(0.2)  # the main thread takes it
            return False

        monkeypatch.setattr(ProgressDisplay, "__call__", show)
        return seen

    return stop


def without_times(value):
    if isinstance(value, dict):
        return {k: without_times(v) for k, v in value.items() if k not in TIMES}
    return [without_times(v) for v in value] if isinstance(value, list) else value


def contents(folder):
    """Return the numbers in a folder's files, times apart; the text and pictures of times too."""
    found = {}
    for path in sorted(folder.iterdir()):
        if path.suffix == ".json":
            found[path.name] = without_times(json.loads(path.read_text(encoding="utf-8")))
        elif "training" in path.name or path.name.startswith("paper."):
            found[path.name] = None
        else:
            found[path.name] = path.read_bytes()
    return found


def run(capsys, command, folder, *more):
    module, *options = command
    code, _, err = called(
        capsys, module.main, *options, "--quiet", "--threads", "1", "--out", str(folder), *more
    )
    return code, err


@pytest.mark.parametrize("name", [name for name in COMMANDS if name != "paper"])
def test_a_stopped_run_goes_on_to_the_same_bytes(name, capsys, tmp_path, stop_at):
    seen = stop_at(0)
    assert run(capsys, COMMANDS[name], tmp_path / "whole")[0] == 0
    n = len(seen)
    for k, share in enumerate((0.35, 0.8)):
        stop_at(max(int(share * n), 2), signal.SIGTERM if k else signal.SIGINT)
        more = ["--resume"] if k else []
        code, err = run(capsys, COMMANDS[name], tmp_path / "cut", *more)
        if code == 0:  # it had less left than that
            break
        assert code == (143 if k else 130)
        assert err.strip().endswith("--resume")
        assert (tmp_path / "cut" / "checkpoint").is_dir()
    else:
        stop_at(0)
        assert run(capsys, COMMANDS[name], tmp_path / "cut", "--resume") == (0, "")
    assert contents(tmp_path / "cut") == contents(tmp_path / "whole")


def test_what_was_kept_is_not_computed_again(capsys, tmp_path, stop_at, monkeypatch):
    from kneecore.knee import model

    stop_at(4)
    command = COMMANDS["samples and influence"]
    assert run(capsys, command, tmp_path)[0] == 130
    stop_at(0)
    rows = []
    examine = model.Knee.examine
    monkeypatch.setattr(
        model.Knee,
        "examine",
        lambda self, x, **more: rows.append(len(x)) or examine(self, x, **more),
    )
    assert run(capsys, command, tmp_path, "--resume")[0] == 0
    whole = 8192 + 64 * 30
    assert 0 < sum(rows) < 0.8 * whole


CODE = """
import importlib, sys
from kneecore.files import checkpoint
from kneecore.files import folder as folders
checkpoint.INTERVAL_S = 0.0
sys.exit(importlib.import_module(sys.argv[1]).main(sys.argv[2:]))
"""


def started(command, folder, *more):
    module, *options = command
    words = [module.__name__, *options, "--quiet", "--threads", "1", "--out", str(folder), *more]
    return subprocess.Popen(
        [sys.executable, "-c", CODE, *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.parametrize("name", ["search in the model", "samples and influence"])
def test_a_killed_process_goes_on_to_the_same_bytes(name, capsys, tmp_path):
    assert run(capsys, COMMANDS[name], tmp_path / "whole")[0] == 0
    cut, chance = tmp_path / "cut", random.Random(name)
    for attempt in range(3):
        process = started(COMMANDS[name], cut, *(["--resume"] if attempt else []))
        deadline = time.monotonic() + 60.0
        while not (cut / "checkpoint").exists() and time.monotonic() < deadline:
            if process.poll() is not None:
                break
            time.sleep(0.01)
        time.sleep(chance.uniform(0.0, 0.5))
        process.kill()
        process.communicate()
        if (cut / "checkpoint").exists():
            continue
        break
    if (cut / "checkpoint").exists():
        assert run(capsys, COMMANDS[name], cut, "--resume") == (0, "")
    assert contents(cut) == contents(tmp_path / "whole")
    assert not list(cut.glob(".*"))


def stopped(capsys, folder, stop_at, name="search in the model"):
    stop_at(10)
    assert run(capsys, COMMANDS[name], folder)[0] == 130
    stop_at(0)
    assert (folder / "checkpoint").is_dir()


def test_what_was_stopped_is_not_lost_by_starting_again(capsys, tmp_path, stop_at):
    stopped(capsys, tmp_path, stop_at)
    code, err = run(capsys, COMMANDS["search in the model"], tmp_path)
    assert code == 2
    assert "holds the checkpoint of a run that was stopped; --resume to go on with it" in err
    assert run(capsys, COMMANDS["search in the model"], tmp_path, "--force")[0] == 0
    assert not (tmp_path / "checkpoint").exists()


@pytest.mark.parametrize(
    ("more", "what"),
    [
        (["--seed", "7"], "--seed"),
        (["--geometry-bound-mm", "0.5"], "--geometry-bound-mm"),
        (["--pop-size", "22"], "--pop-size"),
    ],
)
def test_other_options_do_not_go_on(more, what, capsys, tmp_path, stop_at):
    stopped(capsys, tmp_path, stop_at)
    command = (*COMMANDS["search in the model"], *more)
    code, err = run(capsys, command, tmp_path, "--resume")
    assert code == 2
    assert f"belongs to another run: its {what} is" in err
    assert err.count("\n") == 1


def test_another_command_does_not_go_on(capsys, tmp_path, stop_at):
    stopped(capsys, tmp_path, stop_at)
    code, err = run(capsys, COMMANDS["sweep of bounds"], tmp_path, "--resume")
    assert code == 2
    assert "belongs to another run" in err


def test_another_version_does_not_go_on(capsys, tmp_path, stop_at, monkeypatch):
    stopped(capsys, tmp_path, stop_at)
    monkeypatch.setattr("kneecore._version.versions", lambda: {"kneecore": "9.9"})
    code, err = run(capsys, COMMANDS["search in the model"], tmp_path, "--resume")
    assert code == 2
    assert "its versions is" in err


def test_nothing_to_go_on_with(capsys, tmp_path, stop_at):
    command = COMMANDS["search in the model"]
    code, err = called(capsys, search.main, "--resume")[::2]
    assert (code, err.count("\n")) == (2, 1)
    assert "`--resume` needs `--out`" in err
    assert run(capsys, command, tmp_path / "new", "--resume") == (0, "")  # killed before all
    code, err = run(capsys, command, tmp_path / "new", "--resume")
    assert code == 2
    assert "holds a finished result.json: nothing is left to go on with" in err


def test_a_damaged_checkpoint_costs_time_and_no_more(capsys, tmp_path, stop_at):
    command = COMMANDS["exact search"]
    assert run(capsys, command, tmp_path / "whole")[0] == 0
    chance = np.random.default_rng(0)
    for k in range(4):
        cut = tmp_path / f"cut {k}"
        stopped(capsys, cut, stop_at, "exact search")
        path = cut / "checkpoint" / "runs"
        content = bytearray(path.read_bytes())
        at = int(chance.integers(len(content)))
        if k % 2:
            del content[at:]
        else:
            content[at] ^= 0x55
        path.write_bytes(content)
        assert run(capsys, command, cut, "--resume") == (0, "")
        assert contents(cut) == contents(tmp_path / "whole")


def test_a_full_disk_costs_the_checkpoint_and_not_the_run(
    capsys, tmp_path, stop_at, monkeypatch, caplog
):
    command = COMMANDS["samples and influence"]
    stop_at(0)
    assert run(capsys, command, tmp_path / "whole")[0] == 0
    stop_at(4)
    assert run(capsys, command, tmp_path / "cut")[0] == 130

    def full(*_arguments):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    stop_at(0)
    with monkeypatch.context() as patched:
        patched.setattr(os, "replace", full)
        assert run(capsys, command, tmp_path / "cut", "--resume")[0] == 2  # nor are there files
    assert caplog.text.count("No space left on device") == 1
    assert run(capsys, command, tmp_path / "cut", "--resume") == (0, "")
    assert contents(tmp_path / "cut") == contents(tmp_path / "whole")


def test_no_more_than_a_limit_is_kept(capsys, tmp_path, stop_at, monkeypatch, caplog):
    monkeypatch.setattr(checkpoint, "LARGEST", 1000)
    assert run(capsys, COMMANDS["exact search"], tmp_path) == (0, "")
    assert caplog.text.count("no more can be kept") == 1


def test_two_writers_of_one_folder(capsys, tmp_path):
    pytest.importorskip("fcntl")
    other = started(COMMANDS["paper"], tmp_path)
    try:
        deadline = time.monotonic() + 60.0
        while not (tmp_path / "checkpoint").exists() and time.monotonic() < deadline:
            time.sleep(0.01)
        for more in ((), ("--resume",), ("--force",)):
            code, err = run(capsys, COMMANDS["search in the model"], tmp_path, *more)
            assert code == 2
            assert err.count("\n") == 1
        assert "to which another process is writing; another folder is allowed" in err
    finally:
        other.kill()
        other.communicate()
    assert run(capsys, COMMANDS["search in the model"], tmp_path, "--force") == (0, "")


def test_what_the_dead_left_is_removed(tmp_path, capsys):
    child = subprocess.Popen([sys.executable, "-c", ""])
    child.wait()
    dead = tmp_path / f".result.json.{child.pid}.tmp"
    alive = tmp_path / f".result.json.{os.getppid()}.tmp"
    mine = tmp_path / ".notes.tmp"
    for path in (dead, alive, mine):
        path.touch()
    assert run(capsys, COMMANDS["search in the model"], tmp_path) == (0, "")
    assert not dead.exists()
    assert alive.exists()
    assert mine.exists()


def test_a_polite_end_is_ctrl_c(tmp_path):
    process = started(COMMANDS["samples and influence"], tmp_path)
    deadline = time.monotonic() + 60.0
    while not (tmp_path / "checkpoint").exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    process.terminate()
    said = process.communicate()[1]
    assert process.returncode == 143
    assert "Traceback" not in said
    assert said.strip().endswith("--resume")


def test_the_words_to_go_on_are_a_command(capsys, tmp_path, stop_at):
    stop_at(10)
    folder = tmp_path / "a folder's name"
    err = run(capsys, COMMANDS["search in the model"], folder)[1]
    stop_at(0)
    words = err.split("to go on: ")[1]
    done = subprocess.run(
        ["sh", "-c", words.replace("python", sys.executable, 1)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert (folder / "result.json").exists()


def test_ctrl_c_while_files_are_written_loses_none(capsys, tmp_path, monkeypatch):
    from kneecore.search.result import SearchResult

    save = SearchResult.save

    def interrupted(self, *arguments, **options):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.05)
        return save(self, *arguments, **options)

    monkeypatch.setattr(SearchResult, "save", interrupted)
    code, err = run(capsys, COMMANDS["exact search"], tmp_path)
    assert code == 130
    assert "Traceback" not in err
    assert (tmp_path / "result.json").exists()
    assert not (tmp_path / "checkpoint").exists()


def test_processes_that_are_alive_are_known():
    assert keeping._is_alive(os.getpid())
    assert not keeping._is_alive(2**22 + 1)

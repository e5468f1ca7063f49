"""``python -m kneeviz`` as a user starts it."""

import contextlib
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from pathlib import Path
from types import SimpleNamespace

import pytest
from searches import searched

from kneecore import ParameterError, asset_path
from kneeviz import __main__ as command

REPOSITORY = Path(command.__file__).resolve().parents[1]


def run(*arguments, timeout=30):
    return subprocess.run(
        [sys.executable, "-m", "kneeviz", *arguments],
        cwd=REPOSITORY, capture_output=True, text=True, timeout=timeout, check=False,
    )  # fmt: skip


@contextlib.contextmanager
def started(*arguments, **environment):
    process = subprocess.Popen(
        [sys.executable, "-m", "kneeviz", "--no-browser", *arguments],
        cwd=REPOSITORY, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"} | environment,
    )  # fmt: skip
    said = ""
    try:
        for line in process.stdout:
            said += line
            if found := re.search(r"kneeviz: http://127\.0\.0\.1:(\d+)", line):
                yield process, int(found[1])
                return
        pytest.fail(f"no address was printed: {said}")
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def is_free(port):
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
        return True


def page(port):
    with urllib.request.urlopen(f"http://127.0.0.1:{port}", timeout=10) as answer:
        return answer.status


@pytest.fixture
def taken():
    with socket.socket() as holder:
        holder.bind(("127.0.0.1", 0))
        holder.listen()
        yield holder.getsockname()[1]


def test_help_is_quick_and_names_every_option():
    start = time.monotonic()
    done = run("--help")
    assert time.monotonic() - start < 20.0
    assert done.returncode == 0
    for option in (
        "--host", "--port", "--baseline", "--result", "--shared", "--per-visitor", "--no-browser",
        "--token", "--no-token", "--allow-host", "--model", "--knee", "--class",
    ):  # fmt: skip
        assert option in done.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--prot", "1"], "--prot"),
        (["--port", "x"], "port"),
        (["--port", "70000"], "70000"),
        (["--host", "no.such.host.invalid"], "no.such.host.invalid"),
        (["--baseline", "nowhere.toml"], "nowhere.toml"),
        (["--result", "nowhere.json"], "nowhere.json"),
        (["--model", "nowhere.toml"], "nowhere.toml"),
        (["--model", "pyproject.toml"], "no key of a model's file"),
        (["--model", "x.toml", "--baseline", "y.toml"], "`baseline` is 'y.toml'; it is the knee's"),
        (["--shared", "--per-visitor"], "only one"),
        (["--class", "--per-visitor"], "only one"),
        (["--knee", "no/link"], "the link holds other characters"),
        (["--knee", "x", "--state", "y.json"], "--knee is given with --baseline or --state"),
        (["--token", "--no-token"], "only one"),
        (["--allow-host", "http://x.org"], "http://x.org"),
    ],
)
def test_a_wrong_option_gives_one_line_and_exit_code_2(arguments, words):
    done = run(*arguments)
    assert done.returncode == 2
    assert len(done.stderr.strip().splitlines()) == 1
    assert words in done.stderr
    assert done.stdout == ""


def test_a_port_that_was_asked_for_and_is_taken(taken):
    done = run("--port", str(taken))
    assert done.returncode == 2
    assert done.stderr.strip().splitlines() == [
        f"python -m kneeviz: `port` {taken} is in use; another one is needed"
    ]


def test_it_prints_its_address_serves_and_frees_the_port_at_ctrl_c():
    with started("--port", "0") as (process, port):
        assert page(port) == 200
        process.send_signal(signal.SIGINT)
        assert process.wait(15) == 0
        assert is_free(port)


def children(pid):
    """Return the processes that a process has started, and whose they are meanwhile."""
    found = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, parent = path.read_text().rpartition(")")[2].split()[:2]
            if int(parent) == pid and state != "Z":
                found[int(path.parent.name)] = path.parent
    return found


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="no /proc")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_a_polite_end_is_143_and_no_end_leaves_a_process_behind(number, tmp_path):
    # Nothing is compiled yet, so that a second process helps.
    with started("--port", "0", NUMBA_CACHE_DIR=str(tmp_path)) as (process, port):
        begun = children(process.pid)
        process.send_signal(number)
        assert process.wait(15) == (143 if number == signal.SIGTERM else -number)
        assert is_free(port)
        assert "Traceback" not in process.stdout.read()
        end = time.monotonic() + 3.0
        while any(path.exists() for path in begun.values()) and time.monotonic() < end:
            time.sleep(0.05)
        assert not [path for path in begun.values() if path.exists()]
    if len(os.sched_getaffinity(0)) > 1:
        assert begun


def test_stopped_while_it_starts_it_serves_nobody(monkeypatch, capsys):
    ended = []

    class Started:
        def stop(self):
            ended.append(1)

    def start(_options):
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(0.05)
        return Started()

    monkeypatch.setattr(command, "start", start)
    monkeypatch.setattr(command.run, "_last_stop", signal.SIGINT)
    assert command.main(["--no-browser"]) == 143
    assert ended == [1]
    assert capsys.readouterr() == ("", "")


def test_without_a_port_the_next_free_one_is_taken(monkeypatch, taken):
    monkeypatch.setattr(command, "DEFAULT_PORT", taken)
    chosen = command.choose_port("127.0.0.1", None)
    assert taken < chosen < taken + 100
    assert is_free(chosen)


def test_choose_port_refuses_what_is_taken(taken):
    with pytest.raises(ParameterError, match="in use"):
        command.choose_port("127.0.0.1", taken)
    assert command.choose_port("127.0.0.1", 0) == 0


def test_the_files_of_the_options_are_opened(tmp_path):
    import kneecore

    knee = tmp_path / "mine.toml"
    text = asset_path("baseline.toml").read_text()
    knee.write_text(text.replace("value = 32.1", "value = 31.0"))
    result = searched(pop_size=20, n_generations=3, seed=9)
    result.save(tmp_path / "found", figures=False)
    options = command.Options(
        port=0, baseline=str(knee), result=str(tmp_path / "found"), no_browser=True
    )
    app = command.start(options)
    try:
        radius = kneecore.NAMES.index("condyle_radius")
        assert app.page.state.x[radius] == pytest.approx(31.0e-3)
        assert app.page.state.result.settings.seed == 9
        assert not app.page.view.files.result["result.json"].disabled
    finally:
        app.stop()


def test_a_class_gets_an_address_of_its_own(capsys):
    stop = threading.Event()
    stop.set()
    app = SimpleNamespace(warning=None, url="http://a/?token=t", class_url="http://a")
    command._serve(app, stop, browser=False)
    teachers, classs = capsys.readouterr().out.splitlines()
    assert teachers == "kneeviz: http://a/?token=t  (Ctrl-C ends it)"
    assert classs == "kneeviz: http://a  (for the class, which watches)"

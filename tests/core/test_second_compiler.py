"""The second process that compiles at the first start: a helper that may fail, and no more."""

import contextlib
import importlib
import re
import subprocess
import sys

import pytest
from imports import ROOT

from kneecore import _second_compiler as second

PLACES = sorted(
    {
        place
        for path in (ROOT / "kneecore").rglob("*.py")
        for place in re.findall(
            r'^[A-Z_]+ = "([\w.]+:\w+)"$', path.read_text(encoding="utf-8"), re.M
        )
    }
)


@pytest.fixture
def empty(tmp_path, monkeypatch):
    """An empty cache on a machine with two cores."""
    monkeypatch.setattr(second, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(second, "available_cores", lambda: 2)
    second._second_process.cache_clear()
    yield tmp_path
    second._second_process.cache_clear()


@pytest.fixture
def started(monkeypatch):
    """The processes that were started; they are ended after the test."""
    processes = []
    popen = subprocess.Popen

    def noted(*arguments, **options):
        processes.append(popen(*arguments, **options))
        return processes[-1]

    monkeypatch.setattr(second.subprocess, "Popen", noted)
    yield processes
    for process in processes:
        process.kill()
        process.wait()
        process.stdout.close()
        with contextlib.suppress(OSError):
            process.stdin.close()


def compiled_apart(place):
    second.compile_apart(place)
    second.wait_for(place)


def test_one_process_is_given_each_function_once(empty, started):
    for place in ("gc:collect", "os:getcwd", "gc:collect"):
        compiled_apart(place)
    assert len(started) == 1
    assert started[0].poll() is None
    assert list(second._second_process()._done) == ["gc:collect", "os:getcwd"]


def test_it_ends_with_this_process(empty, started):
    compiled_apart("os:getcwd")
    started[0].stdin.close()
    assert started[0].wait(20) == 0


def test_it_ends_in_the_middle_of_a_part(empty, started):
    second.compile_apart("os:getcwd")
    second.wait_for("os:getcwd")
    second.compile_apart("signal:pause")
    started[0].stdin.close()
    assert started[0].wait(5) == 0


@pytest.mark.parametrize("place", ["os:abort", "kneecore:nothing", "nowhere:at_all"])
def test_its_failure_is_nobodys(empty, started, place, capfd):
    compiled_apart(place)
    assert started[0].wait(20) != 0
    compiled_apart("os:getcwd")  # nobody is there any more
    assert len(started) == 1
    assert capfd.readouterr() == ("", "")


def test_one_that_hangs_is_not_waited_for_long(empty, started, monkeypatch):
    monkeypatch.setattr(second, "_PATIENCE_S", 0.1)
    compiled_apart("signal:pause")
    assert started[0].poll() is None


def test_what_it_was_never_given_is_not_waited_for(empty, started):
    second.wait_for("os:getcwd")


def test_none_where_it_cannot_be_started(empty, monkeypatch):
    def refuse(*_arguments, **_options):
        raise OSError

    monkeypatch.setattr(second.subprocess, "Popen", refuse)
    compiled_apart("os:getcwd")


@pytest.mark.parametrize("why", ["compiled already", "one core", "no cache", "no compiler"])
def test_none_where_it_is_of_no_use(empty, started, monkeypatch, why):
    if why == "compiled already":
        (empty / "physics").mkdir()
        (empty / "physics" / "one.nbi").touch()
    elif why == "one core":
        monkeypatch.setattr(second, "available_cores", lambda: 1)
    elif why == "no cache":
        monkeypatch.setattr(second, "cache_folder", lambda: None)
    else:
        monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    compiled_apart("os:getcwd")
    assert not started


def test_none_in_a_program_that_only_embeds_python(empty, started, monkeypatch):
    monkeypatch.setattr(sys, "executable", "/opt/a program/with python inside")
    compiled_apart("os:getcwd")
    assert not started


def test_the_kernels_folders_alone_are_an_empty_cache(empty, started):
    (empty / "physics").mkdir()
    compiled_apart("os:getcwd")
    assert len(started) == 1


@pytest.mark.parametrize("place", PLACES)
def test_each_part_does_compile(place):
    module, function = place.split(":")
    getattr(importlib.import_module(module), function)()


def test_the_parts_are_found():
    assert len(PLACES) == 3

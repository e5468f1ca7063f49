"""Processes that are really killed, disks that really fill up; ``run.py`` does it for minutes."""

import json
import random
import signal

import pytest
from hardening.killed import KINDS, Tally, contents, ended, killed_and_gone_on, started, until
from hardening.rows_killed import filled_and_gone_on, fought_over

SEARCH = ["kneecore.cli.search", "--space", "model", "--pop-size", "20", "--generations", "60"]
SAMPLES = ["kneecore.cli.uncertainty", "--samples", "8192", "--sampling", "sobol"]
HOW = {"interval": 0.0, "what": "numbers"}


def test_a_killed_process_goes_on_to_the_same_bytes(tmp_path):
    tally = Tally()
    killed_and_gone_on("search", SEARCH, tmp_path, KINDS, random.Random(3), tally, **HOW)
    assert tally.wrong == []
    assert tally.kills > 0


def test_a_polite_end_is_ctrl_c_and_what_was_kept_is_used(tmp_path):
    cut, told = tmp_path / "cut", tmp_path / "told"
    many = [*SAMPLES, "--influence", "--base-samples", "256", "--no-intervals"]
    process = started(many, cut, tmp_path / "none", **HOW)
    until((cut / "checkpoint" / "runs").exists, process)
    process.send_signal(signal.SIGTERM)
    code, _, said = ended(process)
    assert code == 143
    assert "Traceback" not in said
    assert said.strip().endswith("--resume")
    assert ended(started(many, cut, told, "--resume", **HOW))[0] == 0
    assert told.exists()


def test_a_full_disk_costs_no_more_than_room(tmp_path):
    tally = Tally()
    assert ended(started(SAMPLES, tmp_path / "whole", tmp_path / "none", **HOW))[0] == 0
    filled_and_gone_on("samples", SAMPLES, tmp_path, 12_000, tally, **HOW)
    assert tally.wrong == []
    assert tally.kills == 1


def test_of_several_writers_of_one_folder_one_writes(tmp_path):
    pytest.importorskip("fcntl")
    tally = Tally()
    assert ended(started(SEARCH, tmp_path / "whole", tmp_path / "none", **HOW))[0] == 0
    fought_over("search", SEARCH, tmp_path, 1, tally, **HOW)
    assert tally.wrong == []
    assert tally.kills == 2


def test_what_differs_is_seen(tmp_path):
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    for folder in (whole, cut):
        folder.mkdir()
        (folder / "result.json").write_text(json.dumps({"f": 1.0, "seconds": 2, "digest": "a"}))
    (cut / "result.json").write_text(json.dumps({"f": 1.0, "seconds": 3, "digest": "b"}))
    assert contents(cut) == contents(whole)
    (cut / ".result.json.1.tmp").touch()
    assert contents(cut) != contents(whole)
    (cut / ".result.json.1.tmp").unlink()
    (cut / "result.json").write_text(json.dumps({"f": 1.0000001, "seconds": 2}))
    assert contents(cut) != contents(whole)

"""The runner that writes the table."""

import subprocess
import sys
from pathlib import Path

from hardening.rows import ROWS, SHORT, Outcome, row, table

RUN = Path(__file__).with_name("run.py")


def test_a_row_is_run_by_its_name_and_fills_the_table():
    done = subprocess.run(
        [sys.executable, str(RUN), "--short", "--only", "other sites"],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].startswith("| what we try to break |")
    assert "100 refused with 403" in lines[2]


def test_what_is_not_sound_is_said_and_fails(monkeypatch):
    monkeypatch.setattr("hardening.rows.ROWS", {})
    wrong = Outcome(injected="1|2", happened="it fell", sound=False)
    assert "| **not sound:** it fell |" in table({"a": wrong})
    assert "1\\|2" in table({"a": wrong})


def test_rows_are_added_by_decoration():
    @row("a row of this test")
    def attack(scale):
        return Outcome(injected=str(scale.count(100)), happened="nothing", sound=True)

    try:
        assert ROWS["a row of this test"](SHORT).injected == "10"
    finally:
        del ROWS["a row of this test"]

"""The runner that writes the table."""

import subprocess
import sys
from pathlib import Path

import pytest
from hardening import guards, run
from hardening.rows import GUARDS, ROWS, SHORT, Guard, Outcome, row, table

RUN = Path(__file__).with_name("run.py")


GUARD = Guard(file="kneecore/a.py", function="f", line="if x:", instead="if 0:", test="t.py")


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
    monkeypatch.setattr("hardening.rows.GUARDS", {"a": GUARD})
    wrong = Outcome(injected="1|2", happened="it fell", sound=False)
    assert "| **not sound:** it fell |" in table({"a": wrong})
    assert "1\\|2" in table({"a": wrong})


def test_rows_are_added_by_decoration():
    @row("a row of this test", GUARD)
    def attack(scale):
        return Outcome(injected=str(scale.count(100)), happened="nothing", sound=True)

    try:
        assert ROWS["a row of this test"](SHORT).injected == "10"
    finally:
        del ROWS["a row of this test"], GUARDS["a row of this test"]


def test_every_row_has_a_guard_that_stands_and_a_test_that_is_there():
    run.load_rows()
    assert ROWS.keys() == GUARDS.keys()
    assert len(ROWS) >= 14
    for guard in GUARDS.values():
        text = (guards.ROOT / guard.file).read_text()
        assert guards.without(text, guard) != text
        assert (guards.ROOT / guard.test.split()[0]).exists()
    with pytest.raises(ValueError, match="has no"):
        guards.without("def f():\n    pass", GUARD)


def test_the_table_goes_between_the_marks_and_other_rows_stay(tmp_path, monkeypatch):
    monkeypatch.setattr(run, "ROWS", {"a": None, "b": None})
    monkeypatch.setattr("hardening.rows.GUARDS", {"a": GUARD, "b": GUARD})
    path = tmp_path / "README.md"
    path.write_text(f"before {run.BEGIN}\n| b | 5 | old | |\n{run.END} after")
    run.write(path, {"a": Outcome(injected="1", happened="nothing", sound=True)})
    lines = path.read_text().splitlines()
    assert lines[0] == f"before {run.BEGIN}"
    assert lines[3] == "| a | 1 | nothing | `kneecore/a.py`, `f`: `if x:` |"
    assert lines[4:] == ["| b | 5 | old | |", f"{run.END} after"]
    path.write_text("no marks")
    with pytest.raises(ValueError, match="is allowed"):
        run.between_marks(path)

"""A script under tests that is run by hand finds all that it imports, started from anywhere."""

import subprocess
import sys

import pytest
from imports import ROOT

SCRIPTS = sorted(
    path
    for folder in ("benchmarks", "hardening", "e2e", ".")
    for path in (ROOT / "tests" / folder).glob("*.py")
    if '__name__ == "__main__"' in path.read_text(encoding="utf-8")
)


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_a_script_finds_what_it_imports(path, tmp_path):
    code = f"import runpy; runpy.run_path({str(path)!r}, run_name='looked_at')"
    start = [sys.executable, "-c", f"import sys; sys.path[0] = {str(path.parent)!r}; {code}"]
    done = subprocess.run(start, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr


def test_the_scripts_are_found():
    assert {"table.py", "step_rule.py", "run.py"} <= {path.name for path in SCRIPTS}

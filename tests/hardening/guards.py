"""Take each row's guard out, in a copy of the repository, and see its test fail::

    python tests/hardening/guards.py --only disk

The exit code is 1 if a test passes without its guard.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE.parent), str(ROOT)]

from hardening.rows import GUARDS, Guard  # noqa: E402
from hardening.run import load_rows  # noqa: E402


def without(text: str, guard: Guard) -> str:
    """Return a file's text without the guard's line, the first of its kind in its function."""
    name = guard.function.rpartition(".")[2]
    before, start, inside = text.partition(f"def {name}(")
    if not start or guard.line not in inside:
        raise ValueError(f"{guard.file} has no {guard.line!r} in {guard.function}")
    return before + start + inside.replace(guard.line, guard.instead, 1)


def fails_without(guard: Guard) -> bool:
    """Tell whether the guard's test fails in a copy without it."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        for name in ("kneecore", "kneeviz", "assets", "tests"):
            shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "pyproject.toml", copy)
        path = copy / guard.file
        path.write_text(without(path.read_text(encoding="utf-8"), guard), encoding="utf-8")
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider",
             *guard.test.split()],
            cwd=copy, env=os.environ | {"PYTHONPATH": folder},
            capture_output=True, text=True, check=False,
        )  # fmt: skip
    print(done.stdout.splitlines()[-1] if done.stdout else done.stderr, file=sys.stderr)
    return done.returncode == 1


def main() -> int:
    """Take the guards out one by one, and tell which tests fail."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", metavar="WORD", help="rows whose name has this word")
    word, held = parser.parse_args().only.lower(), True
    load_rows()
    for name, guard in GUARDS.items():
        if word in name.lower():
            fails = fails_without(guard)
            held = held and fails
            print(f"{'fails' if fails else 'PASSES'} without its guard: {name}", flush=True)
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())

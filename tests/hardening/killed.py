"""Long commands that are stopped in any way, and what they must have in common with a whole run."""

import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

from kneecore.files import checkpoint

WITNESS = Path(__file__).with_name("witnessed.py")
INTERVAL_S = 0.1
"""How often a checkpoint is written here, so that a short run has many."""
_TASKS = {
    "search in the model": "search --space model --pop-size 100 --generations 150",
    "exact search, 2 mm": "search --method exact --geometry-bound-mm 2",
    "samples and influence": "uncertainty --samples 20000 --influence --base-samples 128 "
    "--no-intervals",
    "sweep of bounds": "sweep bound --bounds-mm 0.5 1 --tolerance-mm 0.9 --largest-mm 1",
    "sweep of training": "sweep training --sizes 40 60 80 --seeds 4",
    "paper": "paper --quick",
}
_TIMED = ("time_", "orders_of_magnitude", "more_training_slower")
"""What the ids of the paper's claims on times begin with."""
COMMANDS = {name: f"kneecore.cli.{task}".split() for name, task in _TASKS.items()}
"""Each takes some seconds."""
KINDS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)


def without_times(value):
    """Return JSON's values without how long something took, and what is said of that."""
    if isinstance(value, list):
        return [without_times(v) for v in value]
    if not isinstance(value, dict):
        return value
    told = str(value.get("id", ""))  # a claim of the paper
    left_out = {"seconds", "digest"}  # the digest is of the times too
    if told.startswith(_TIMED):
        left_out |= {"ours", "why", "outcome"}
    return {k: without_times(v) for k, v in value.items() if k not in left_out}


def contents(folder):
    """Return all that is in a folder: bytes, times apart; of texts and pictures of times, names."""
    found = {}
    for path in sorted(p for p in folder.rglob("*") if not p.is_dir()):
        name = str(path.relative_to(folder))
        if path.suffix == ".json":
            found[name] = without_times(json.loads(path.read_text(encoding="utf-8")))
        elif "training" in path.name or path.name.startswith("paper."):
            found[name] = None
        else:
            found[name] = path.read_bytes()
    return found


def holds_work(folder):
    """Tell whether a run that was stopped has left something to go on with."""
    for path in (folder / checkpoint.FOLDER).glob("*"):
        if path.suffix == ".tmp":
            continue
        content = memoryview(path.read_bytes())
        first = checkpoint._unpacked(content, 0)
        if first is not None and checkpoint._unpacked(content, first[2]) is not None:
            return True
    return False


def started(command, folder, told, *more, interval=INTERVAL_S, what="all"):
    """Start a command that writes to `folder`, and to `told` when it takes what was kept."""
    return subprocess.Popen(
        [sys.executable, str(WITNESS), str(told), str(interval), what, *command, "--quiet",
         "--threads", "1", "--out", str(folder), *more],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        # Other folders come first when a script is run.
        env=os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
    )  # fmt: skip


def ended(process):
    """Wait for a process; return its exit code and what it printed and said."""
    try:
        printed, said = process.communicate(timeout=240)
    finally:
        process.kill()
    return process.returncode, printed, said


@dataclass(kw_only=True)
class Tally:
    """What became of the runs that were stopped."""

    kills: int = 0
    runs: int = 0
    went_on: int = 0
    """Runs that took something from a checkpoint."""
    wrong: list[str] = field(default_factory=list)

    def check(self, is_right: object, what: str) -> None:
        """Note what is wrong."""
        if not is_right:
            self.wrong.append(what)


def killed_and_gone_on(name, command, place, kinds, dice, tally, **how):
    """Run a command once whole, then stop it by each signal in turn and let it end.

    Compares the two folders; `place` is an empty one for both. `how` goes to `started`.
    """
    whole, cut = place / "whole", place / f"cut {tally.runs}"
    start = time.monotonic()
    if not whole.exists():
        code, _, said = ended(started(command, whole, place / "none", **how))
        tally.check(code == 0, f"{name}: {code} {said}")
        (place / "seconds").write_text(str(time.monotonic() - start))
    usual = float((place / "seconds").read_text())
    for number, kind in enumerate((*kinds, None)):
        if cut.exists() and contents(cut).keys() == contents(whole).keys():
            break  # stopped behind its last line
        to_go_on, told = holds_work(cut), place / f"told {tally.runs}.{number}"
        more = ["--resume"] if cut.exists() else []
        process = started(command, cut, told, *more, **how)
        if kind is not None:
            until(Path(f"{told}.begun").exists, process)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(dice.uniform(0.1, 0.6) * usual)
            tally.kills += process.poll() is None
            process.send_signal(kind)
        code, _, said = ended(process)
        allowed = {0} if kind is None else {0, -kind, 128 + kind}
        tally.check(code in allowed and "Traceback" not in said, f"{name}: {code} {said}")
        if code == 0:
            tally.check(told.exists() or not to_go_on, f"{name}: nothing was taken")
            tally.went_on += told.exists()
            break
    tally.runs += 1
    tally.check(contents(cut) == contents(whole), f"{name}: other files")
    tally.check(not (cut / checkpoint.FOLDER).exists(), f"{name}: a checkpoint is left")


def until(is_so, process):
    """Wait until something is so, or the process has ended."""
    end = time.monotonic() + 60.0
    while not is_so() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.01)


def shuffled(dice: random.Random) -> tuple[signal.Signals, ...]:
    """Return the signals in a random order."""
    return tuple(dice.sample(KINDS, len(KINDS)))

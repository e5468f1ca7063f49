"""Rows of long work: ended by force, on a disk that fills up, in a folder that others write to."""

import contextlib
import os
import random
import resource
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

from hardening.killed import (
    COMMANDS,
    Tally,
    contents,
    ended,
    holds_work,
    killed_and_gone_on,
    shuffled,
    started,
    until,
)
from hardening.rows import Guard, Outcome, Scale, row

_SHORT = ("search in the model", "samples and influence")
"""What the short form takes: a step whose state is kept, and runs that are."""


@row(
    "Processes killed",
    Guard(
        file="kneecore/cli/keeping.py",
        function="Keeping.done",
        line="self.checkpoint.remove()",
        instead="pass",
        test="tests/hardening/test_killed.py -k killed_process",
    ),
)
def kill_processes(scale: Scale) -> Outcome:
    """Kill every long command at random times and hold what it ends with against a whole run."""
    names = list(COMMANDS) if scale.share == 1.0 else _SHORT
    dice, tally = random.Random(10), Tally()
    for name in names:
        with tempfile.TemporaryDirectory() as place:
            for _ in range(scale.count(4)):
                killed_and_gone_on(name, COMMANDS[name], Path(place), shuffled(dice), dice, tally)
    tally.check(tally.went_on > 0, "none went on from a checkpoint")
    return Outcome(
        injected=f"{tally.kills} kills (kill -9, SIGTERM, Ctrl-C) at random times of "
        f"{len(names)} commands",
        happened=f"{tally.runs} runs, gone on with --resume ({tally.went_on} from a checkpoint), "
        + ("; ".join(tally.wrong) or "ended with the same bytes; nothing lost, nothing left over"),
        sound=not tally.wrong and tally.kills > 0,
    )


class Disk:
    """A small disk: a real one where mounting is allowed, else a limit on what a file may hold."""

    def __init__(self, folder: Path, size: int) -> None:
        self.folder, self._size = folder, size
        folder.mkdir()
        options = ["-o", f"size={size},mode=700"]
        mounted = subprocess.run(
            ["mount", "-t", "tmpfs", *options, "tmpfs", str(folder)],
            capture_output=True, check=False,
        ) if os.name == "posix" and os.geteuid() == 0 else None  # fmt: skip
        self.is_real = mounted is not None and mounted.returncode == 0
        self._limit: int | None = None if self.is_real else size

    @contextlib.contextmanager
    def in_force(self) -> Iterator[None]:
        """Let processes that are started within find the disk as small as it is."""
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        if self._limit is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (self._limit, before[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)

    def make_room(self) -> None:
        """Give it all the room that is needed."""
        self._limit = None
        if self.is_real:
            options = ["-o", "remount,size=200m"]
            subprocess.run(["mount", *options, str(self.folder)], check=True)

    def close(self) -> None:
        """Take it away."""
        if self.is_real:
            subprocess.run(["umount", "-l", str(self.folder)], check=True)


@contextlib.contextmanager
def small_disk(folder: Path, size: int) -> Iterator[Disk]:
    """Give a disk of that many bytes for a while."""
    disk = Disk(folder, size)
    try:
        yield disk
    finally:
        disk.close()


def filled_and_gone_on(
    name: str, command: list[str], place: Path, size: int, tally: Tally, **how: object
) -> bool:
    """Run a command on a disk of that size, then with room; tell whether the disk was real.

    `place` holds what a whole run leaves, in ``whole``.
    """
    told = place / f"told {size}"
    with small_disk(place / f"disk {size}", size) as disk:
        cut = disk.folder / "results"
        with disk.in_force():
            process = started(command, cut, place / "none", **how)
        code, printed, said = ended(process)
        if code != 0:
            tally.kills += 1
            words = "No space left on device" if disk.is_real else "File too large"
            tally.check(code == 2 and words in said, f"{name}: {code} {said}")
            tally.check(printed.strip(), f"{name}: its numbers were not printed")
            tally.check(len(said.splitlines()) <= 2, f"{name}: more than a line: {said}")
            to_go_on = holds_work(cut)
            disk.make_room()
            code, _, said = ended(started(command, cut, told, "--resume", **how))
            tally.check(code == 0, f"{name}: {code} {said}")
            tally.check(told.exists() or not to_go_on, f"{name}: nothing was taken")
            tally.went_on += told.exists()
        tally.runs += 1
        tally.check(contents(cut) == contents(place / "whole"), f"{name}: other files")
        return disk.is_real


@row(
    "A full disk",
    Guard(
        file="kneecore/files/checkpoint.py",
        function="Checkpoint._careful",
        line="except OSError as error:",
        instead="except ZeroDivisionError as error:",
        test="tests/hardening/test_killed.py -k full_disk",
    ),
)
def fill_disk(scale: Scale) -> Outcome:
    """Let the disk fill up while a command writes its checkpoint or its files; then make room."""
    name = "samples and influence"
    tally, real = Tally(), False
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        ended(started(COMMANDS[name], place / "whole", place / "none"))
        most = sum(path.stat().st_size for path in (place / "whole").iterdir())
        dice = random.Random(11)
        for number in range(scale.count(20)):
            # From almost nothing to a little less than the results take.
            size = int(8192 + dice.uniform(0.0, 0.8) ** (2 if number % 2 else 1) * most)
            real = filled_and_gone_on(name, COMMANDS[name], place, size, tally)
    tally.check(tally.kills > 0, "no disk was full")
    return Outcome(
        injected=f"{tally.kills} disks that fill up"
        + ("" if real else " (files that may not grow)"),
        happened=f"{tally.runs} runs printed their numbers and told of the disk in a line, and "
        f"with room --resume went on ({tally.went_on} from a checkpoint) to "
        + ("; ".join(tally.wrong) or "the same bytes"),
        sound=not tally.wrong,
    )


def fought_over(
    name: str, command: list[str], place: Path, others: int, tally: Tally, **how: object
) -> None:
    """Let others write to the folder of a command that runs, and start one at the same time."""
    whole, cut = place / "whole", place / f"cut {tally.runs}"
    told = place / f"told {tally.runs}"
    both = [started(command, cut, told, **how) for _ in range(2)]
    until(Path(f"{told}.begun").exists, both[0])
    ways = ((), ("--resume",), ("--force",))
    more = [started(command, cut, place / "none", *ways[n % 3], **how) for n in range(others)]
    ends = [ended(process) for process in (*both, *more)]
    tally.runs += 1
    winners = [code for code, _, _ in ends if code == 0]
    tally.kills += len(ends) - len(winners)
    tally.check(len(winners) == 1, f"{name}: {len(winners)} wrote")
    for code, printed, said in ends:
        refused = code == 2 and len(said.splitlines()) == 1 and not printed
        tally.check(code == 0 or refused, f"{name}: {code} {said}")
    tally.check(contents(cut) == contents(whole), f"{name}: other files")


@row(
    "Two writers of one folder",
    Guard(
        file="kneecore/_locks.py",
        function="lock",
        line="_fcntl.flock(handle, _fcntl.LOCK_EX | _fcntl.LOCK_NB)",
        instead="pass",
        test="tests/hardening/test_killed.py -k writers",
    ),
)
def write_twice(scale: Scale) -> Outcome:
    """Start several commands on one folder at the same time, and others while one runs."""
    name = "samples and influence"
    tally, command = Tally(), COMMANDS[name]
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        ended(started(command, place / "whole", place / "none"))
        for _ in range(scale.count(10)):
            fought_over(name, command, place, 3, tally)
    return Outcome(
        injected=f"{tally.runs} times one folder with five writers at once",
        happened=f"{tally.kills} refused in a line before they computed, "
        + ("; ".join(tally.wrong) or "one wrote the same bytes as alone"),
        sound=not tally.wrong and tally.kills == 4 * tally.runs,
    )

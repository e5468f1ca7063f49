"""Progress on stderr: a bar on a terminal, a line a stage elsewhere."""

import sys
import time
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar

from kneecore.progress import Progress

_TOLD = {
    "compile": "loading the kernels (the first run compiles)",
    "sampling": "sampling the true model",
    "fit": "fitting the surrogate",
    "search": "searching",
    "repair": "repairing the surrogate",
    "bound": "bounding f by sampled slopes",
    "verify": "computing the best pair again",
}


QUIET_S = 30.0
"""Seconds between two lines on what slow runs will take, where there is no terminal."""


def told_left(seconds: float | None) -> str:
    """Return what is left to wait for, in words; nothing where it is unknown or soon over."""
    if seconds is None or seconds < 1.0:
        return ""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 1.5 * size:
            return f"at most {seconds / size:.0f} {unit} left"
    return f"at most {seconds:.0f} s left"


class ProgressDisplay:
    """Shows the reports it is called with, and never cancels.

    Parameters
    ----------
    quiet : bool
        Whether to show nothing.
    """

    def __init__(self, *, quiet: bool) -> None:
        self.unit = "deg"
        """Unit of the best f until now."""
        self._told: set[str] = set()
        self._told_at = time.monotonic()
        self._quiet = quiet
        self._bar: Bar | None = None
        console = Console(stderr=True)
        if console.is_terminal and not quiet:
            self._bar = Bar(
                TextColumn("{task.description}"),
                BarColumn(bar_width=20),
                TextColumn("{task.fields[best]}"),
                TextColumn("{task.fields[left]}"),
                TimeElapsedColumn(),
                console=console,
                transient=True,
            )
            self._task = self._bar.add_task("starting", total=None, best="", left="")

    def __enter__(self) -> Self:
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Take the bar away and give the cursor back."""
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, report: Progress) -> bool:
        """Show a report; a stage without words of its own is its own description."""
        told = _TOLD.get(report.stage, report.stage)
        if self._bar is not None:
            best = "" if report.best is None else f"f {report.best:.6g} {self.unit}"
            # A stage of unknown length pulses.
            total = report.total if report.total > 1 else None
            self._bar.update(
                self._task,
                description=told,
                completed=report.done,
                total=total,
                best=best,
                left=told_left(report.seconds_left),
            )
        elif not self._quiet:
            self._tell(report, told)
        return False

    def _tell(self, report: Progress, told: str) -> None:
        """Print a line for a new stage, and now and then for slow runs."""
        left, now = told_left(report.seconds_left), time.monotonic()
        if report.stage not in self._told:
            self._told.add(report.stage)
            print(f"{told} ...", file=sys.stderr, flush=True)
        elif left and now - self._told_at >= QUIET_S:
            many = f"{report.done:,} of {report.total:,} runs"
            print(f"{told}: {many}, {left}", file=sys.stderr, flush=True)
        else:
            return
        self._told_at = now

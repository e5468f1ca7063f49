"""Progress of a search on stderr: a bar on a terminal, a line a stage elsewhere."""

import contextlib
import sys
from collections.abc import Iterator

from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar

from kneecore.search.progress import Callback, Progress

_TOLD = {
    "compile": "compiling or loading the kernels (the first run takes some seconds)",
    "sampling": "sampling the true model",
    "fit": "fitting the surrogate",
    "search": "searching",
    "verify": "computing the best pair in the true model",
}


def _lines(report: Progress, told: set[str]) -> None:
    if report.stage not in told:
        told.add(report.stage)
        print(f"{_TOLD[report.stage]} ...", file=sys.stderr, flush=True)


@contextlib.contextmanager
def shown_progress(*, quiet: bool) -> Iterator[Callback]:
    """Give a callback that shows the reports it gets and never cancels."""
    if quiet:
        yield lambda _: None
        return
    console = Console(stderr=True)
    if not console.is_terminal:
        told: set[str] = set()
        yield lambda report: _lines(report, told)
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TextColumn("{task.fields[best]}"),
        TimeElapsedColumn(),
    )
    with Bar(*columns, console=console, transient=True) as bar:
        task = bar.add_task("starting", total=None, best="")

        def show(report: Progress) -> None:
            best = "" if report.best is None else f"best f {report.best:.2f} deg"
            # A stage of unknown length pulses.
            total = report.total if report.total > 1 else None
            bar.update(
                task,
                description=_TOLD[report.stage],
                completed=report.done,
                total=total,
                best=best,
            )

        yield show

"""`python -m kneecore.paper`: redo the paper from a terminal and judge it claim by claim."""

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from kneecore.cli import run
from kneecore.cli.keeping import Keeping
from kneecore.cli.knee_options import Count, File, Folder
from kneecore.errors import KneecoreError

if TYPE_CHECKING:
    from kneecore.paper.result import PaperReport
    from kneecore.progress import Callback

COMMAND = "python -m kneecore.paper"


@dataclass(frozen=True, kw_only=True)
class Options:
    """Redo the paper of Ciszkiewicz & Dumas 2024 and judge it claim by claim.

    Three cases, repeated searches in the surrogate and in the true model, 10,000 samples; then each
    claim beside our value: agrees, differs, or cannot be compared. The packaged baseline is a
    reconstruction: the paper's parameter table is not available.
    """

    quick: bool = False
    """Smaller searches and fewer samples: a preview in seconds."""
    baseline: File = None
    """A knee file (TOML) of your own: values, units, half-ranges, sources."""
    seed: int = 0
    """The same seed gives the same verdicts, on any number of threads (those on times apart)."""
    threads: Count = None
    """Threads for the true model. Unset: all cores."""
    out: Folder = None
    """Write the report (paper.md, paper.html), its figures (PNG, SVG), the searches and samples
    (JSON) and paper.json to this folder."""
    force: bool = False
    """Overwrite a report that is in the folder already."""
    resume: bool = False
    """Go on where a run with the same options and the same folder was stopped."""
    json: bool = False
    """Print one JSON object and nothing else on stdout."""
    quiet: bool = False
    """Show no progress."""


def _redo(
    options: Options, keeping: Keeping, stop: threading.Event, show: "Callback"
) -> "PaperReport":
    from kneecore.files.paper import FORMAT
    from kneecore.knee.model import Knee
    from kneecore.knee.space import ParameterSpace
    from kneecore.paper.redo import redo_paper

    space = None if options.baseline is None else ParameterSpace.from_file(options.baseline)
    with keeping.opened(FORMAT.file):
        return redo_paper(
            Knee(space, threads=options.threads),
            quick=options.quick,
            seed=options.seed,
            callback=lambda progress: show(progress) or stop.is_set(),
        )


def _save(options: Options, report: "PaperReport", show: "Callback") -> tuple[int, bool]:
    """Write the report; return the number of files, and whether Ctrl-C was pressed meanwhile."""
    from kneecore.progress import Progress

    assert options.out is not None
    show(Progress(stage="drawing the figures", done=0, total=1))
    with run.undisturbed() as stop:
        n_files = len(report.save(options.out, force=True))
    return n_files, stop.is_set()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    options = run.parse(Options, arguments, COMMAND)
    with Keeping(COMMAND, options, arguments) as keeping:
        return _run(options, keeping)


def _run(options: Options, keeping: Keeping) -> int:
    from kneecore.cli.progress import ProgressDisplay
    from kneecore.progress import Cancelled

    saved = "nothing was saved"
    try:
        with ProgressDisplay(quiet=options.quiet) as show:
            report, interrupted = run.run_cancellable(
                lambda stop: _redo(options, keeping, stop, show),
                COMMAND,
                show.close,
                keeping.way_on,
            )
        # Printed first: a folder that cannot be written takes nothing away.
        run.put(report.to_json().rstrip() if options.json else str(report))
        if interrupted:  # after the last step
            raise Cancelled
        if options.out is not None:
            with ProgressDisplay(quiet=options.quiet) as show:
                n_files, stopped = _save(options, report, show)
            keeping.done()
            saved = f"{n_files} files written to {options.out}"
            if stopped:
                raise Cancelled
            if not options.quiet:
                run.say(COMMAND, saved)
    except KneecoreError as error:
        return run.fail(COMMAND, error, options, {"folder": "--out"})
    except (Cancelled, KeyboardInterrupt):
        return run.interrupted(COMMAND, f"interrupted; {saved}{keeping.way_on()}")
    return run.DONE

"""`python -m kneecore.search`: find the two most different knees from a terminal."""

import contextlib
import sys
import threading
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Literal

from kneecore.cli import run as _cli
from kneecore.cli.space_options import Folder, SpaceOptions
from kneecore.errors import KneecoreError
from kneecore.numerics.genetic_options import GeneticOptions

if TYPE_CHECKING:
    from kneecore.knee.space import ParameterSpace
    from kneecore.progress import Callback, Progress
    from kneecore.search.result import SearchResult

COMMAND = "python -m kneecore.search"
# The library's names for arguments that the command line calls otherwise.
_NAMES = {
    "n_generations": "--generations",
    "n_runs": "--runs",
    "search_space": "--space",
    "folder": "--out",
    **{f.name: f"--ga.{f.name.replace('_', '-')}" for f in fields(GeneticOptions)},
}


@dataclass(frozen=True, kw_only=True)
class Options(SpaceOptions):
    """Find the two most different knees within the uncertainty of the parameters.

    A genetic algorithm searches the pair in a surrogate trained on a few runs of the model (or in
    the model itself), or climbs with exact gradients do; the best pair is always computed again in
    the true model. The packaged
    baseline is a reconstruction of the knee of Ciszkiewicz & Dumas 2024, whose parameter table is
    not available.
    """

    method: Literal["ga", "exact"] = "ga"
    """The paper's genetic algorithm, or climbs with exact gradients (no pop-size, generations, runs
    or ga options)."""
    space: Literal["surrogate", "model"] | None = None
    """Where to search: in the surrogate, or in the true model (slower with the genetic algorithm,
    exact values). Unset: the surrogate with ga or --repair, the model with exact."""
    repair: bool = False
    """Repair the surrogate where it is trusted most: compute its optimum in the true model, add it
    to the samples, fit again, search again; then try one input at a time at its other bound."""
    repair_gap_percent: float = 1.0
    """Gap between surrogate and model at the optimum below which the surrogate counts as repaired,
    per cent."""
    repair_models: int = 40
    """Model runs that a repair may add."""
    solver: Literal["dynamics", "equilibrium"] = "dynamics"
    """The response of the true model: its motion over 23 s, or the knee at rest under each load."""
    training_samples: int = 50
    """Model runs that the surrogate is fitted to; at least one more than free parameters."""
    pop_size: int = 200
    """Pairs in a generation."""
    generations: int = 800
    """Generations."""
    runs: int = 1
    """Independent runs of the search; the best is kept and the spread shown."""
    objective: Literal["all", "extension", "flexion"] = "all"
    """Which of the 12 loads count."""
    compare: bool = False
    """Search by all methods too (genetic algorithm in surrogate and model, exact gradients, the
    repaired surrogate), and show by how much each falls short of the best f that any has found."""
    out: Folder = None
    """Write result.json, curves.csv and Figures 1-4 (PNG, SVG) to this folder."""
    force: bool = False
    """Overwrite a result that is in the folder already."""
    json: bool = False
    """Print the result as one JSON object and nothing else on stdout."""
    quiet: bool = False
    """Show no progress."""
    ga: GeneticOptions = field(default_factory=GeneticOptions)
    """Constants of the genetic algorithm."""


def _search(options: Options, space: "ParameterSpace", callback: "Callback") -> "SearchResult":
    from kneecore.search.worst_case import worst_case

    return worst_case(
        space,
        method=options.method,
        search_space=options.space,
        training_samples=options.training_samples,
        pop_size=options.pop_size,
        n_generations=options.generations,
        n_runs=options.runs,
        objective=options.objective,
        seed=options.seed,
        rest_length=options.rest_length,
        solver=options.solver,
        repair=options.repair,
        repair_gap_percent=options.repair_gap_percent,
        repair_models=options.repair_models,
        threads=options.threads,
        options=options.ga,
        callback=callback,
    )


def _find(options: Options) -> tuple["SearchResult", bool]:
    """Check everything, search with progress, and tell whether Ctrl-C was pressed."""
    from kneecore.cli.progress import ProgressDisplay
    from kneecore.progress import Cancelled

    def work(stop: threading.Event) -> "SearchResult":
        space = options.knees()
        _check(options, space)

        def callback(report: "Progress") -> object:
            return show(report) or stop.is_set()

        result = _search(options, space, callback)
        if options.compare and not stop.is_set():
            from kneecore.search.compare import with_rivals

            # Interrupted meanwhile: the result is there and is worth keeping.
            with contextlib.suppress(Cancelled):
                result = with_rivals(result, callback)
        return result

    with ProgressDisplay(quiet=options.quiet) as show:
        return _cli.run_cancellable(work, COMMAND, show.close)


def _check(options: Options, space: "ParameterSpace") -> None:
    """Refuse what can be refused before anything is computed or written."""
    from kneecore._threads import thread_count
    from kneecore.files.folder import prepare_folder
    from kneecore.search.settings import PairSettings, default_space

    settings = PairSettings(
        method=options.method,
        search_space=options.space or default_space(options.method, repair=options.repair),
        training_samples=options.training_samples,
        pop_size=options.pop_size,
        n_generations=options.generations,
        n_runs=options.runs,
        options=options.ga,
        seed=options.seed,
        repair=options.repair,
        repair_gap_percent=options.repair_gap_percent,
        repair_models=options.repair_models,
    )
    settings.check_training(space.n_free)
    thread_count(options.threads)
    if options.out is not None:
        prepare_folder(options.out, force=options.force)


def _save(options: Options, result: "SearchResult", *, interrupted: bool) -> tuple[int, bool]:
    """Write the files that were asked for; return how many, and whether Ctrl-C was pressed."""
    if options.out is None:
        return 0, interrupted
    try:
        written = result.save(options.out, force=options.force, figures=not interrupted)
    except KeyboardInterrupt:
        interrupted = True
        written = result.save(options.out, force=True, figures=False)
    return len(written), interrupted


def _tell_interrupted(options: Options, result: "SearchResult", n_files: int) -> int:
    kept = "nothing was saved"
    if n_files:
        kept = f"the best pair until then is in {options.out} (result.json, curves.csv)"
    when = f"after {result.counts['pairs_evaluated']:,} pairs"
    if result.stop_reason != "cancelled":
        when = "after the search"
    print(f"{COMMAND}: interrupted {when}; {kept}", file=sys.stderr)
    return _cli.INTERRUPTED


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    options = _cli.parse(Options, arguments, COMMAND)
    from kneecore.progress import Cancelled

    n_files = 0
    try:
        result, interrupted = _find(options)
        if not interrupted:  # before the files: a full disk then costs no result
            _cli.put(result.to_json().rstrip("\n") if options.json else str(result))
        n_files, interrupted = _save(options, result, interrupted=interrupted)
        if interrupted:
            return _tell_interrupted(options, result, n_files)
        if n_files and not options.quiet:
            print(f"{COMMAND}: {n_files} files written to {options.out}", file=sys.stderr)
    except KneecoreError as error:
        return _cli.fail(COMMAND, error, options, _NAMES)
    except (Cancelled, KeyboardInterrupt):
        kept = f"{n_files} files are in {options.out}" if n_files else "nothing was saved"
        print(f"{COMMAND}: interrupted; {kept}", file=sys.stderr)
        return _cli.INTERRUPTED
    return _cli.DONE if result.objective_model is not None else _cli.NO_ANSWER

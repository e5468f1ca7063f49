"""`python -m kneecore.search`: find the two most different knees from a terminal."""

import contextlib
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from kneecore.cli import run
from kneecore.cli.flags import flag_names, settings_from, with_flags
from kneecore.cli.keeping import Keeping
from kneecore.cli.knee_options import OutputOptions
from kneecore.cli.model_options import ModelOptions
from kneecore.errors import KneecoreError, ParameterError
from kneecore.search.settings import SearchSettings

if TYPE_CHECKING:
    from kneecore.model import Model
    from kneecore.progress import Progress
    from kneecore.search.result import SearchResult

COMMAND = "python -m kneecore.search"


@dataclass(frozen=True, kw_only=True)
class _Options(OutputOptions, ModelOptions):
    """Find the two most different knees, or models of your own, within their uncertainty.

    A genetic algorithm searches the pair in a surrogate trained on a few runs of the model (or in
    the model itself), or climbs with exact gradients do; the best pair is always computed again in
    the true model. The packaged baseline is a reconstruction of the knee of Ciszkiewicz & Dumas
    2024, whose parameter table is not available.
    """

    compare: bool = False
    """Search by all methods too (genetic algorithm in surrogate and model, exact gradients, the
    repaired surrogate), and show by how much each falls short of the best f that any has found."""
    check_step: bool = False
    """Simulate baseline and pair once more with half the time step, and tell by how much that
    moves an angle."""


Options = with_flags(_Options, SearchSettings)


def _checked(options: _Options) -> tuple["Model", SearchSettings]:
    """Refuse what can be refused before anything is computed or written."""
    from kneecore.cli.budget import tell_budget
    from kneecore.search.budget import search_budget

    model = options.subject()
    if options.model is None:
        run.check_step_check(options.check_step, options.solver)
    elif options.check_step:
        raise ParameterError(
            "`check_step` is True; it is the knee's, and with `model` there is none"
        )
    settings = settings_from(SearchSettings, options).of(model)
    budgets = [search_budget(settings, model)]
    if options.compare:
        from kneecore.search.compare import comparison_budgets

        budgets += comparison_budgets(model, settings)
    tell_budget(COMMAND, model, *budgets, quiet=options.quiet or options.json)
    return model, settings


def _audited(result: "SearchResult") -> "SearchResult":
    """Return the result with what half the time step does to its three knees."""
    from dataclasses import replace

    from kneecore.knee.model import Knee
    from kneecore.knee.step_check import with_half_step

    knee = result.model
    assert isinstance(knee, Knee)
    own = {"baseline": knee.space.baseline, "rest_length": knee.rest_length}
    knees = zip(result.responses.items(), (knee.nominal, *result.x), strict=True)
    audited = {name: with_half_step(r, x, **own) for (name, r), x in knees}
    return replace(result, responses=audited)


def _find(options: _Options, keeping: Keeping) -> tuple["SearchResult", bool]:
    """Search with progress, and tell whether Ctrl-C was pressed."""
    from kneecore.cli.progress import ProgressDisplay
    from kneecore.files.folder import RESULT_FILE
    from kneecore.progress import Cancelled
    from kneecore.search.compare import with_methods
    from kneecore.search.worst_case import worst_case

    def work(stop: threading.Event) -> "SearchResult":
        model, settings = _checked(options)
        show.unit = model.objective_unit

        def callback(report: "Progress") -> object:
            return show(report) or stop.is_set()

        with contextlib.closing(model), keeping.opened(RESULT_FILE):
            result = worst_case(model, settings, callback=callback)
            if options.compare and not stop.is_set():
                # Interrupted meanwhile: the result is there and is worth keeping.
                with contextlib.suppress(Cancelled):
                    result = with_methods(result, callback)
        return _audited(result) if options.check_step and not stop.is_set() else result

    with ProgressDisplay(quiet=options.quiet) as show:
        return run.run_cancellable(work, COMMAND, show.close, keeping.way_on)


def _save(options: _Options, result: "SearchResult", *, interrupted: bool) -> tuple[int, bool]:
    """Write the files that were asked for; return how many, and whether Ctrl-C was pressed."""
    if options.out is None:
        return 0, interrupted
    with run.undisturbed() as stop:
        # Whether something there may be overwritten was asked before the search.
        written = result.save(options.out, force=True, figures=not interrupted)
    return len(written), interrupted or stop.is_set()


def _tell_interrupted(options: _Options, result: "SearchResult", n_files: int, way_on: str) -> int:
    kept = "nothing was saved"
    if n_files:
        kept = f"the best pair until then is in {options.out}"
    when = f"after {result.counts['pairs_evaluated']:,} pairs"
    if result.stop_reason != "cancelled":
        when = "after the search"
    return run.interrupted(COMMAND, f"interrupted {when}; {kept}{way_on}")


def _compile_ahead(options: _Options) -> None:
    """Have another process compile, at a first start, while numba and the rest are loaded here."""
    from kneecore._second_compiler import compile_apart
    from kneecore.knee.ahead import AT_REST
    from kneecore.search.ahead import GENERATIONS

    with contextlib.suppress(ParameterError):  # it is told in its turn
        settings, knees = settings_from(SearchSettings, options), options.model is None
        usual = settings.usual(in_corners=knees, gradient=knees, n_free=0)
        if (settings.search_space or usual["search_space"]) == "surrogate":
            compile_apart(GENERATIONS)
        elif settings.method == "exact" and knees:
            compile_apart(AT_REST)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    options = run.parse(Options, arguments, COMMAND)
    _compile_ahead(options)
    with Keeping(COMMAND, options, arguments) as keeping:
        return _run(options, keeping)


def _run(options: _Options, keeping: Keeping) -> int:
    from kneecore.progress import Cancelled

    n_files = 0
    try:
        result, interrupted = _find(options, keeping)
        if not interrupted:  # before the files: a full disk then costs no result
            run.put(result.to_json().rstrip("\n") if options.json else str(result))
        n_files, stopped = _save(options, result, interrupted=interrupted)
        if not interrupted:
            keeping.done()
        if stopped:
            return _tell_interrupted(options, result, n_files, keeping.way_on())
        if n_files and not options.quiet:
            run.say(COMMAND, f"{n_files} files written to {options.out}")
    except KneecoreError as error:
        return run.fail(COMMAND, error, options, flag_names(SearchSettings) | {"folder": "--out"})
    except (Cancelled, KeyboardInterrupt):
        kept = f"{n_files} files are in {options.out}" if n_files else "nothing was saved"
        return run.interrupted(COMMAND, f"interrupted; {kept}{keeping.way_on()}")
    return run.DONE if result.objective_model is not None else run.NO_ANSWER

"""`python -m kneecore.uncertainty`: sampling and influence from a terminal."""

import contextlib
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from kneecore.cli import run
from kneecore.cli.flags import flag_names, settings_from, with_flags
from kneecore.cli.keeping import Keeping
from kneecore.cli.knee_options import File, OutputOptions
from kneecore.cli.model_options import ModelOptions
from kneecore.errors import KneecoreError
from kneecore.study.settings import InfluenceSettings, SamplingSettings

if TYPE_CHECKING:
    from kneecore.files.study import Study
    from kneecore.model import Model
    from kneecore.progress import Callback, Progress
    from kneecore.search.result import SearchResult

COMMAND = "python -m kneecore.uncertainty"


@dataclass(frozen=True, kw_only=True)
class _Options(OutputOptions, ModelOptions):
    """Sample the knees, or a model of your own, within its uncertainty, and tell what decides.

    The packaged baseline is a reconstruction: the parameter table of Ciszkiewicz & Dumas 2024 is
    not available.
    """

    influence: bool = False
    """Compute Sobol' indices of the outputs (the 12 angles) as well."""
    result: File = None
    """A result.json of a search with the same bounds, to be held against the samples."""


Options = with_flags(with_flags(_Options, InfluenceSettings), SamplingSettings)


def _checked(options: _Options) -> tuple["Model", "SearchResult | None"]:
    """Refuse what can be refused before anything is computed."""
    from kneecore.cli.budget import tell_budget
    from kneecore.search.result import SearchResult
    from kneecore.study.budget import study_budget
    from kneecore.study.comparison import check_comparable
    from kneecore.study.influence import check_independent

    model = options.subject()
    worst = None if options.result is None else SearchResult.load(options.result)
    asked = [settings_from(kind, options) for kind in (SamplingSettings, InfluenceSettings)]
    budgets = [study_budget(settings, model) for settings in asked[: 1 + options.influence]]
    if options.influence:
        check_independent(model)
    if worst is not None:
        check_comparable(worst, model)
    tell_budget(COMMAND, model, *budgets, quiet=options.quiet or options.json)
    return model, worst


def _study(options: _Options, keeping: Keeping, stop: threading.Event, show: "Callback") -> "Study":
    from kneecore.files.study import STUDY_FILE

    model, worst = _checked(options)
    with contextlib.closing(model), keeping.opened(STUDY_FILE):
        return _computed(options, model, worst, stop, show)


def _computed(
    options: _Options,
    model: "Model",
    worst: "SearchResult | None",
    stop: threading.Event,
    show: "Callback",
) -> "Study":
    from kneecore.files.study import Study
    from kneecore.study.comparison import compare_with_sampling
    from kneecore.study.monte_carlo import monte_carlo

    def callback(report: "Progress") -> object:
        return show(report) or stop.is_set()

    sampled = monte_carlo(
        model,
        settings_from(SamplingSettings, options),
        marks=None if worst is None else worst.y,
        callback=callback,
    )
    study = Study(sampled=sampled, worst=worst)
    if worst is not None:
        study.comparison = compare_with_sampling(worst, sampled)
    if options.influence and not stop.is_set():
        _add_influence(study, settings_from(InfluenceSettings, options), callback)
    return study


def _add_influence(study: "Study", settings: InfluenceSettings, callback: Any) -> None:
    """Add what decides; cancelled or failed meanwhile, the samples are worth keeping."""
    from kneecore.progress import Cancelled
    from kneecore.study.influence import influence

    try:
        study.influence = influence(study.sampled.model, settings, callback=callback)
    except Cancelled:
        pass
    except KneecoreError as error:
        study.fault = error


def _save(options: _Options, study: "Study", *, figures: bool) -> bool:
    """Write the files that were asked for; return whether Ctrl-C was pressed meanwhile."""
    if options.out is None:
        return False
    from pathlib import Path

    from kneecore.files.folder import contents, write_all
    from kneecore.files.study import FORMAT

    with run.undisturbed() as stop:
        write_all(Path(options.out), contents(study, FORMAT, figures=figures))
    return stop.is_set()


def _told(options: _Options, study: "Study") -> str:
    from kneecore.files.folder import to_json

    return to_json(study.to_dict()).rstrip("\n") if options.json else study.report()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    options = run.parse(Options, arguments, COMMAND)
    with Keeping(COMMAND, options, arguments) as keeping:
        return _run(options, keeping)


def _run(options: _Options, keeping: Keeping) -> int:
    from kneecore.cli.progress import ProgressDisplay
    from kneecore.progress import Cancelled

    try:
        with ProgressDisplay(quiet=options.quiet) as show:
            study, interrupted = run.run_cancellable(
                lambda stop: _study(options, keeping, stop, show),
                COMMAND,
                show.close,
                keeping.way_on,
            )
        if not interrupted:  # before the files: a full disk then costs no result
            run.put(_told(options, study))
        stopped = _save(options, study, figures=not interrupted)
        if study.fault is not None:
            raise study.fault
    except KneecoreError as error:
        names = flag_names(SamplingSettings, InfluenceSettings) | {"folder": "--out"}
        return run.fail(COMMAND, error, options, names)
    except Cancelled:
        told = "interrupted before there were two samples; nothing was saved"
        return run.interrupted(COMMAND, told + keeping.way_on())
    except KeyboardInterrupt:
        way_on = keeping.way_on()
        return run.interrupted(COMMAND, f"interrupted while writing; nothing was saved{way_on}")
    if interrupted:
        kept = "nothing was saved" if options.out is None else f"it is in {options.out}"
        told = f"interrupted after {study.sampled.n_samples:,} samples; {kept}"
        return run.interrupted(COMMAND, told + keeping.way_on())
    keeping.done()
    if stopped:
        return run.interrupted(COMMAND, f"interrupted; all files are in {options.out}")
    return run.DONE

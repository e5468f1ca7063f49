"""`python -m kneecore.sweep`: what training runs and accuracy buy, from a terminal."""

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from kneecore.cli import run
from kneecore.cli.flags import flag_names, settings_from, with_flags
from kneecore.cli.keeping import Keeping
from kneecore.cli.knee_options import OutputOptions
from kneecore.cli.model_options import ModelOptions
from kneecore.errors import KneecoreError
from kneecore.study.settings import (
    BoundSweepSettings,
    NeededAccuracySettings,
    TrainingSweepSettings,
)

if TYPE_CHECKING:
    from kneecore.files.bound_study import BoundStudy
    from kneecore.model import Model
    from kneecore.progress import Callback
    from kneecore.study.training_sweep import TrainingSweep

COMMAND = "python -m kneecore.sweep"


@dataclass(frozen=True, kw_only=True)
class _Training(OutputOptions, ModelOptions):
    """Tell how many runs a surrogate should learn from.

    Trains surrogates on more and more runs, searches for the worst case in each, and holds gap,
    ranking and time side by side. The packaged baseline is a reconstruction of the knee of
    Ciszkiewicz & Dumas 2024, whose parameter table is not available.
    """


@dataclass(frozen=True, kw_only=True)
class _Bound(OutputOptions, ModelOptions):
    """Tell how accurately the geometry, or the inputs of a model of your own, must be known.

    Finds the exact worst case for each bound on the geometry, and the largest bound with which
    every knee still extends far enough. The slope's bound changes in proportion; the material's
    stays. The packaged baseline is a reconstruction of the knee of Ciszkiewicz & Dumas 2024, whose
    parameter table is not available.
    """


Training = with_flags(_Training, TrainingSweepSettings)
Bound = with_flags(with_flags(_Bound, NeededAccuracySettings), BoundSweepSettings)


def _sweep_training(
    options: _Training, model: "Model", callback: "Callback"
) -> "TrainingSweep | None":
    from kneecore.cli.budget import tell_budget
    from kneecore.progress import Cancelled
    from kneecore.study.budget import study_budget
    from kneecore.study.training_sweep import training_sweep

    settings = settings_from(TrainingSweepSettings, options)
    budget = study_budget(settings, model)
    tell_budget(COMMAND, model, budget, quiet=options.quiet or options.json)
    try:
        return training_sweep(model, settings, callback=callback)
    except Cancelled:
        return None


def _sweep_bounds(options: _Bound, model: "Model", callback: "Callback") -> "BoundStudy | None":
    from dataclasses import replace

    from kneecore.files.bound_study import BoundStudy
    from kneecore.progress import Cancelled
    from kneecore.study.bound_sweep import bound_sweep
    from kneecore.study.needed_accuracy import needed_accuracy

    settings = settings_from(BoundSweepSettings, options)
    asked = settings_from(NeededAccuracySettings, options)
    if asked.largest is None:
        asked = replace(asked, largest=max(*model.sizes, *(settings.sizes or ())))
    study = None
    try:
        study = BoundStudy(sweep=bound_sweep(model, settings, callback=callback))
        # Nobody has said of a model of one's own what is good enough, unless asked with --within.
        if asked.within is not None or model.goal is not None:
            study.need = needed_accuracy(model, asked, callback=callback)
    except Cancelled:
        pass
    return study


def _file(options: _Training | _Bound) -> str:
    return "training_sweep.json" if isinstance(options, _Training) else "bound_sweep.json"


def _sweep(
    options: _Training | _Bound, keeping: Keeping, stop: threading.Event, show: "Callback"
) -> Any:
    """Return what has been computed, or None."""
    model = options.subject()

    def callback(report: Any) -> object:
        return show(report) or stop.is_set()

    with keeping.opened(_file(options)):
        if isinstance(options, _Training):
            return _sweep_training(options, model, callback)
        return _sweep_bounds(options, model, callback)


def _save(options: _Training | _Bound, done: Any) -> bool:
    """Write the files that were asked for; return whether Ctrl-C was pressed meanwhile."""
    if options.out is None or done is None:
        return False
    from pathlib import Path

    from kneecore.files.bound_study import FORMAT, BoundStudy
    from kneecore.files.folder import contents, write_all

    with run.undisturbed() as stop:
        study = isinstance(done, BoundStudy)
        files = contents(done, FORMAT, figures=True) if study else done.files()
        write_all(Path(options.out), files)
    return stop.is_set()


def _told(options: _Training | _Bound, done: Any) -> str:
    from kneecore.files.folder import to_json

    return to_json(done.to_dict()).rstrip("\n") if options.json else str(done)


def _options(arguments: Sequence[str] | None) -> _Training | _Bound:
    chosen: Any = (
        Annotated[Training, tyro.conf.subcommand("training")]
        | Annotated[Bound, tyro.conf.subcommand("bound")]
    )
    options: _Training | _Bound = run.parse(chosen, arguments, COMMAND)
    return options


def _names(options: _Training | _Bound) -> dict[str, str]:
    kinds: tuple[type[Any], ...] = (BoundSweepSettings, NeededAccuracySettings)
    if isinstance(options, _Training):
        kinds = (TrainingSweepSettings,)
    return flag_names(*kinds) | {"folder": "--out"}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    options = _options(arguments)
    with Keeping(COMMAND, options, arguments) as keeping:
        return _run(options, keeping)


def _run(options: _Training | _Bound, keeping: Keeping) -> int:
    from kneecore.cli.progress import ProgressDisplay

    try:
        with ProgressDisplay(quiet=options.quiet) as show:
            done, interrupted = run.run_cancellable(
                lambda stop: _sweep(options, keeping, stop, show),
                COMMAND,
                show.close,
                keeping.way_on,
            )
        if not interrupted:  # before the files: a full disk then costs no result
            run.put(_told(options, done))
        stopped = _save(options, done)
    except KneecoreError as error:
        return run.fail(COMMAND, error, options, _names(options))
    except KeyboardInterrupt:
        way_on = keeping.way_on()
        return run.interrupted(COMMAND, f"interrupted while writing; nothing was saved{way_on}")
    if interrupted:
        kept = f"what was done is in {options.out}" if options.out and done else "nothing kept"
        return run.interrupted(COMMAND, f"interrupted; {kept}{keeping.way_on()}")
    keeping.done()
    if stopped:
        return run.interrupted(COMMAND, f"interrupted; all files are in {options.out}")
    return run.DONE

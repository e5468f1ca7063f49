"""`python -m kneecore.sweep`: what training runs and accuracy buy, from a terminal."""

import json
import sys
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from kneecore.cli import run as _cli
from kneecore.cli.space_options import Folder, SpaceOptions
from kneecore.errors import KneecoreError
from kneecore.study.defaults import BOUNDS_MM, SIZES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from kneecore.progress import Callback
    from kneecore.study.bound_sweep import BoundSweep
    from kneecore.study.needed_accuracy import NeededAccuracy
    from kneecore.study.training_sweep import TrainingSweep

COMMAND = "python -m kneecore.sweep"
_NAMES = {"folder": "--out", "n_seeds": "--seeds"}


@dataclass(frozen=True, kw_only=True)
class _Shared(SpaceOptions):
    solver: Literal["dynamics", "equilibrium"] = "dynamics"
    """The response of the true model: its motion over 23 s, or the knee at rest under each load."""
    out: Folder = None
    """Write the numbers (JSON) and a figure (PNG, SVG) to this folder."""
    force: bool = False
    """Overwrite a sweep that is in the folder already."""
    json: bool = False
    """Print one JSON object and nothing else on stdout."""
    quiet: bool = False
    """Show no progress."""


@dataclass(frozen=True, kw_only=True)
class Training(_Shared):
    """Tell how many runs a surrogate should learn from.

    Trains surrogates on more and more runs, searches for the worst case in each, and holds gap,
    ranking and time side by side. The packaged baseline is a reconstruction of the knee of
    Ciszkiewicz & Dumas 2024, whose parameter table is not available.
    """

    sizes: tuple[int, ...] = SIZES
    """Training samples; at least one more than free parameters."""
    seeds: int = 5
    """Repetitions with other training samples."""
    method: Literal["ga", "exact"] = "ga"
    """How each surrogate is searched: the paper's main run, or exactly."""


@dataclass(frozen=True, kw_only=True)
class Bound(_Shared):
    """Tell how accurately the geometry must be known.

    Finds the exact worst case for each bound on the geometry, and the largest bound with which
    every knee still extends far enough. The slope's bound changes in proportion; the material's
    stays. The packaged baseline is a reconstruction of the knee of Ciszkiewicz & Dumas 2024, whose
    parameter table is not available.
    """

    bounds_mm: Annotated[tuple[float, ...], tyro.conf.arg(metavar="MM [MM ...]")] = BOUNDS_MM
    """Half-ranges of every length and coordinate, mm."""
    within_deg: float = 5.0
    """Flexion that may be left at +5 N m, deg, for the answer the other way round."""


@dataclass(kw_only=True)
class _Done:
    """What has been computed so far."""

    training: "TrainingSweep | None" = None
    bound: "BoundSweep | None" = None
    need: "NeededAccuracy | None" = None

    @property
    def parts(self) -> list[Any]:
        return [part for part in (self.training, self.bound, self.need) if part is not None]

    def to_dict(self) -> dict[str, Any]:
        document: dict[str, Any] = self.parts[0].to_dict()
        if self.need is not None:
            document["needed_accuracy"] = self.need.to_dict()
        return document

    def figures(self) -> "dict[str, Figure]":
        from kneecore.figures.sweep import bound_figure, training_figure

        if self.training is not None:
            return {"figure_training": training_figure(self.training)}
        assert self.bound is not None
        return {"figure_bound": bound_figure(self.bound, self.need)}


def _file(options: _Shared) -> str:
    return "training_sweep.json" if isinstance(options, Training) else "bound_sweep.json"


def _sweep(options: Training | Bound, stop: threading.Event, show: "Callback") -> _Done:
    from kneecore.files.folder import prepare_folder
    from kneecore.progress import Cancelled
    from kneecore.study.bound_sweep import bound_sweep
    from kneecore.study.needed_accuracy import needed_accuracy
    from kneecore.study.training_sweep import training_sweep

    done = _Done()
    space = options.knees()
    shared: dict[str, Any] = {
        "solver": options.solver,
        "rest_length": options.rest_length,
        "seed": options.seed,
        "threads": options.threads,
        "callback": lambda report: show(report) or stop.is_set(),
    }
    if options.out is not None:
        prepare_folder(options.out, force=options.force, holds=_file(options))
    try:
        if isinstance(options, Training):
            done.training = training_sweep(
                space,
                sizes=options.sizes,
                n_seeds=options.seeds,
                method=options.method,
                **shared,
            )
        else:
            done.bound = bound_sweep(space, bounds_mm=options.bounds_mm, **shared)
            largest = max(*BOUNDS_MM, *options.bounds_mm)
            done.need = needed_accuracy(
                space, within_deg=options.within_deg, largest_mm=largest, **shared
            )
    except Cancelled:
        pass
    return done


def _files(options: Training | Bound, done: _Done) -> Iterator[tuple[str, bytes]]:
    from kneecore.figures.search import render

    yield from render(done.figures())
    yield _file(options), (json.dumps(done.to_dict(), allow_nan=False) + "\n").encode()


def _save(options: Training | Bound, done: _Done) -> None:
    from kneecore.files.folder import write_all

    if options.out is not None and done.parts:
        write_all(Path(options.out), _files(options, done))


def _options(arguments: Sequence[str] | None) -> Training | Bound:
    chosen: Any = (
        Annotated[Training, tyro.conf.subcommand("training")]
        | Annotated[Bound, tyro.conf.subcommand("bound")]
    )
    options: Training | Bound = _cli.parse(chosen, arguments, COMMAND)
    return options


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    options = _options(arguments)
    from kneecore.cli.progress import ProgressDisplay

    try:
        with ProgressDisplay(quiet=options.quiet) as show:
            done, interrupted = _cli.run_cancellable(
                lambda stop: _sweep(options, stop, show), COMMAND, show.close
            )
        if not interrupted:  # before the files: a full disk then costs no result
            told = json.dumps(done.to_dict(), allow_nan=False) if options.json else None
            _cli.put(told or "\n\n".join(str(part) for part in done.parts))
        _save(options, done)
    except KneecoreError as error:
        return _cli.fail(COMMAND, error, options, _NAMES)
    except KeyboardInterrupt:
        print(f"{COMMAND}: interrupted while writing; nothing was saved", file=sys.stderr)
        return _cli.INTERRUPTED
    if interrupted:
        kept = (
            f"what was done is in {options.out}" if options.out and done.parts else "nothing kept"
        )
        print(f"{COMMAND}: interrupted; {kept}", file=sys.stderr)
        return _cli.INTERRUPTED
    return _cli.DONE

"""`python -m kneecore.uncertainty`: sampling and influence from a terminal."""

import json
import sys
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from kneecore.cli import run as _cli
from kneecore.cli.space_options import File, Folder, SpaceOptions
from kneecore.errors import KneecoreError
from kneecore.files.study import INFLUENCE_FILE, STUDY_FILE, Study

if TYPE_CHECKING:
    from kneecore.progress import Callback

COMMAND = "python -m kneecore.uncertainty"


@dataclass(frozen=True, kw_only=True)
class Options(SpaceOptions):
    """Sample the true model within the uncertainty of the parameters, and tell which decide.

    The packaged baseline is a reconstruction: the parameter table of Ciszkiewicz & Dumas 2024 is
    not available.
    """

    samples: int = 10_000
    """Monte-Carlo samples; Sobol' sampling rounds up to a power of two."""
    sampling: Literal["uniform", "latin-hypercube", "sobol"] = "uniform"
    """How the samples are drawn."""
    solver: Literal["dynamics", "equilibrium"] = "dynamics"
    """The response of the true model: its motion over 23 s, or the knee at rest under each load."""
    influence: bool = False
    """Compute Sobol' indices of the 12 angles as well."""
    base_samples: int = 1024
    """Base rows of the indices, a power of two; the model is run for each free parameter and
    twice more."""
    result: File = None
    """A result.json of a search with the same bounds, to be held against the samples."""
    out: Folder = None
    """Write uncertainty.json and figures (PNG, SVG) to this folder."""
    force: bool = False
    """Overwrite a study that is in the folder already."""
    json: bool = False
    """Print one JSON object and nothing else on stdout."""
    quiet: bool = False
    """Show no progress."""


def _check(options: Options) -> None:
    """Refuse what can be refused before anything is computed."""
    from kneecore._threads import thread_count
    from kneecore.files.folder import prepare_folder
    from kneecore.numerics.sampling import check_count, check_seed

    check_count("samples", options.samples)
    check_count("base_samples", options.base_samples)
    check_seed(options.seed)
    thread_count(options.threads)
    if options.out is not None:
        prepare_folder(options.out, force=options.force, holds=STUDY_FILE)


def _study(options: Options, stop: threading.Event, show: "Callback") -> Study:
    import numpy as np

    from kneecore.progress import Cancelled
    from kneecore.search.result import SearchResult
    from kneecore.study.comparison import check_comparable, compare_with_sampling
    from kneecore.study.influence import influence
    from kneecore.study.monte_carlo import monte_carlo

    space = options.knees()
    worst = None if options.result is None else SearchResult.load(options.result)
    _check(options)
    angles = None
    if worst is not None:
        check_comparable(worst, space, options.rest_length, options.solver)
        angles = np.degrees([worst.model_1.flexion, worst.model_2.flexion])

    def callback(report: Any) -> object:
        return show(report) or stop.is_set()

    sampled = monte_carlo(
        space,
        n_samples=options.samples,
        sampling=options.sampling,
        seed=options.seed,
        rest_length=options.rest_length,
        solver=options.solver,
        threads=options.threads,
        angles_deg=angles,
        callback=callback,
    )
    study = Study(sampled=sampled, worst=worst)
    if worst is not None:
        study.comparison = compare_with_sampling(worst, sampled)
    if options.influence and not stop.is_set():
        # Cancelled or failed meanwhile: the samples are there and are worth keeping.
        try:
            study.influence = influence(
                space,
                n_base=options.base_samples,
                seed=options.seed,
                rest_length=options.rest_length,
                solver=options.solver,
                threads=options.threads,
                callback=callback,
            )
        except Cancelled:
            pass
        except KneecoreError as error:
            study.fault = error
    return study


def _files(study: Study, *, figures: bool) -> Iterator[tuple[str, bytes]]:
    if figures:
        from kneecore.figures.study import render_study

        yield from render_study(study.sampled, study.influence, study.worst)
    if study.influence is not None:
        yield INFLUENCE_FILE, study.influence.to_csv().encode()
    yield STUDY_FILE, (json.dumps(study.to_dict(), allow_nan=False) + "\n").encode()


def _save(options: Options, study: Study, *, figures: bool) -> None:
    if options.out is None:
        return
    from pathlib import Path

    from kneecore.files.folder import write_all

    write_all(Path(options.out), _files(study, figures=figures))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    options = _cli.parse(Options, arguments, COMMAND)
    from kneecore.cli.progress import ProgressDisplay

    try:
        with ProgressDisplay(quiet=options.quiet) as show:
            study, interrupted = _cli.run_cancellable(
                lambda stop: _study(options, stop, show), COMMAND, show.close
            )
        if not interrupted:  # before the files: a full disk then costs no result
            document = study.to_dict()
            _cli.put(json.dumps(document, allow_nan=False) if options.json else study.report())
        _save(options, study, figures=not interrupted)
        if study.fault is not None:
            raise study.fault
    except KneecoreError as error:
        return _cli.fail(COMMAND, error, options, {"folder": "--out"})
    except KeyboardInterrupt:
        print(f"{COMMAND}: interrupted while writing; {STUDY_FILE} was not saved", file=sys.stderr)
        return _cli.INTERRUPTED
    if interrupted:
        kept = "nothing was saved" if options.out is None else f"it is in {options.out}"
        told = f"interrupted after {study.sampled.n_samples:,} samples; {kept}"
        print(f"{COMMAND}: {told}", file=sys.stderr)
        return _cli.INTERRUPTED
    return _cli.DONE

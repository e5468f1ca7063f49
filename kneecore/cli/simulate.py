"""`python -m kneecore.simulate`: one knee through the load programme."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import tyro

from kneecore.cli import run
from kneecore.errors import KneecoreError

COMMAND = "python -m kneecore.simulate"


@dataclass(frozen=True, kw_only=True)
class Options:
    """Simulate one knee at the 12 loads and print its response.

    The packaged baseline is a reconstruction: the parameter table of Ciszkiewicz & Dumas 2024 is
    not available.
    """

    baseline: Annotated[str | None, tyro.conf.arg(metavar="FILE")] = None
    """A knee file (TOML). If it holds a current knee, that one is simulated, in the load-free pose
    that the file's baseline fixes. Unset: the packaged baseline."""
    rest_length: Literal["recomputed", "fixed"] = "recomputed"
    """Ligaments strain-free in the knee's own load-free pose, or as long as the baseline's."""
    solver: Literal["dynamics", "equilibrium"] = "dynamics"
    """The motion over 23 s, as in the paper, or the knee at rest under each load. Where an angle
    of the motion is not within 0.1 deg of it, the angle at rest is shown too."""
    check_step: bool = False
    """Simulate once more with half the time step, and tell by how much that moves an angle."""
    json: bool = False
    """Print one JSON object instead of the table."""


def _run(options: Options) -> int:
    run.check_step_check(options.check_step, options.solver)
    from kneecore.files.folder import to_json
    from kneecore.files.response import to_dict
    from kneecore.knee.file import packaged_knee, read_knee
    from kneecore.knee.response import simulate
    from kneecore.knee.step_check import with_half_step
    from kneecore.report.response import response_table

    knee = packaged_knee() if options.baseline is None else read_knee(options.baseline)
    x = knee.baseline if knee.current is None else knee.current
    response = simulate(
        x, baseline=knee.baseline, rest_length=options.rest_length, solver=options.solver
    )
    if options.check_step:
        response = with_half_step(
            response, x, baseline=knee.baseline, rest_length=options.rest_length
        )
    at_rest = None
    if options.solver == "dynamics" and (response.n_unsettled or response.n_not_at_rest):
        at_rest = simulate(
            x, baseline=knee.baseline, rest_length=options.rest_length, solver="equilibrium"
        )
    which = knee.title if knee.current is None else f"{knee.title}, current knee"
    if options.json:
        run.put(to_json(to_dict(response, at_rest, which)).rstrip("\n"))
    else:
        run.put(f"{which}. {knee.note or ''}".rstrip())
        run.put(response_table(response, at_rest))
    return run.DONE if response.status != "failed" else run.NO_ANSWER


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    options = run.parse(Options, arguments, COMMAND)
    try:
        return _run(options)
    except KneecoreError as error:
        return run.fail(COMMAND, error)
    except KeyboardInterrupt:
        return run.interrupted(COMMAND, "interrupted")

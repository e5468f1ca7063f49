"""`python -m kneecore.simulate`: one knee through the load programme."""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from kneecore.cli import run as _cli
from kneecore.errors import KneecoreError

if TYPE_CHECKING:
    from kneecore.knee.response import Response

COMMAND = "python -m kneecore.simulate"
SCHEMA = "kneecore.response/1"


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
    """The motion over 23 s, as in the paper, or the knee at rest under each load. Where the motion
    has not come to rest, the angle at rest is shown too."""
    json: bool = False
    """Print one JSON object instead of the table."""


def _document(response: "Response", at_rest: "Response | None", title: str) -> dict[str, Any]:
    from kneecore.numbers import plain

    return {
        "schema": SCHEMA,
        "title": title,
        "status": response.status,
        "refinements": response.refinements,
        "lost_at_nm": plain(response.lost_at),
        "moment_nm": response.moment.tolist(),
        "flexion_deg": plain(response.flexion, 180.0 / math.pi),
        "tension_n": plain(response.tension),
        "contact_force_n": plain(response.contact_force),
        "indentation_mm": plain(response.indentation, 1e3),
        "ap_position_mm": plain(response.ap_position, 1e3),
        "settled": response.settled.tolist(),
        "flexion_at_rest_deg": at_rest and plain(at_rest.flexion, 180.0 / math.pi),
        "ligament_rest_length_mm": plain(response.rest_length, 1e3),
    }


def _run(options: Options) -> int:
    from kneecore.knee.file import packaged_knee, read_knee
    from kneecore.knee.response import simulate
    from kneecore.report.tables import response_table

    knee = packaged_knee() if options.baseline is None else read_knee(options.baseline)
    x = knee.baseline if knee.current is None else knee.current
    response = simulate(
        x, baseline=knee.baseline, rest_length=options.rest_length, solver=options.solver
    )
    at_rest = None
    if options.solver == "dynamics" and response.n_unsettled:
        at_rest = simulate(
            x, baseline=knee.baseline, rest_length=options.rest_length, solver="equilibrium"
        )
    which = knee.title if knee.current is None else f"{knee.title}, current knee"
    if options.json:
        _cli.put(
            json.dumps(_document(response, at_rest, which), allow_nan=False, ensure_ascii=False)
        )
    else:
        _cli.put(f"{which}. {knee.note or ''}".rstrip())
        _cli.put(response_table(response, at_rest))
    return _cli.DONE if response.status != "failed" else _cli.NO_ANSWER


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    options = _cli.parse(Options, arguments, COMMAND)
    try:
        return _run(options)
    except KneecoreError as error:
        return _cli.fail(COMMAND, error)
    except KeyboardInterrupt:
        return _cli.INTERRUPTED

"""Worst cases over bounds of several sizes, for people."""

from collections.abc import Sequence

import numpy as np
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from kneecore.knee.model import Knee
from kneecore.knee.physics.dynamics import TURN_LIMIT
from kneecore.knee.physics.forces import THETA_0
from kneecore.knee.readings import deficit_deg, over_extension_deg
from kneecore.presented import Words
from kneecore.report.marks import counted_by_row
from kneecore.report.outputs import NO_PROOF, label, origin, shown
from kneecore.report.search import objective_text
from kneecore.report.tables import render, table, with_unit
from kneecore.study.bound_sweep import BoundSweep

__all__ = ["WORDS", "how_searched"]


def how_searched(*, in_model: bool) -> str:
    """Return what the searches of a sweep were, and what they prove."""
    return (
        NO_PROOF
        if in_model
        else (
            "Searches in surrogates that were repaired, with values of the true model: the worst "
            "found, which is no proof of the worst."
        )
    )


def summary(sweep: BoundSweep) -> str:
    """Return how f changes with the size, in one sentence."""
    model = sweep.model
    first, last = (objective_text(model, v) for v in (sweep.objective[0], sweep.objective[-1]))
    if len(sweep.size) == 1:
        return f"f of the worst pair is {first} where the {model.size_name} is {_size(sweep, 0)}."
    return (
        f"f of the worst pair goes from {first} to {last} while the {model.size_name} goes from "
        f"{_size(sweep, 0)} to {_size(sweep, -1)}."
    )


def _size(sweep: BoundSweep, k: int) -> str:
    return with_unit(f"{sweep.size[k]:g}", sweep.model.size_unit)


def _knee_rows(sweep: BoundSweep) -> Table:
    rows = table(
        "Worst case by the geometry's bound",
        "bound mm",
        "f deg",
        "deficit deg",
        "over-extension deg",
        "least deg",
        "largest deg",
        "s",
    )
    columns = (
        sweep.objective,
        deficit_deg(sweep.pair),
        over_extension_deg(sweep.pair),
        *sweep.extremes.T,
        sweep.seconds,
    )
    for k, bound in enumerate(sweep.size):
        rows.add_row(f"{bound:g}", *(f"{column[k]:.2f}" for column in columns))
    return rows


def _knee_footer(sweep: BoundSweep, knee: Knee) -> str:
    ends = np.degrees(THETA_0 - TURN_LIMIT)
    at_the_end = (
        f"At {ends:.1f} deg the model's range ends: such a knee has come apart. "
        if (sweep.extremes < ends + 1.0).any()
        else ""
    )
    return (
        "Deficit (of extension) and over-extension: of the two knees with the largest f, at the "
        f"largest extension moment. {at_the_end}Least and largest: angles of any knee within the "
        f"bound there. {counted_by_row(sweep.marks, 'these knees')}"
        f"The slope's bound changes in proportion; true model, solver: {knee.solver}, seed "
        f"{sweep.settings.seed}. {NO_PROOF}\n{origin(knee)}"
    )


def _rows(sweep: BoundSweep) -> Table:
    model = sweep.model
    rows = table(
        f"Worst case by the {model.size_name}",
        with_unit("size", model.size_unit),
        with_unit("f", model.objective_unit),
        "pair, lower",
        "pair, higher",
        "least",
        "largest",
        "s",
    )
    for k in range(len(sweep.size)):
        values = (sweep.objective[k], *sweep.pair[k], *sweep.extremes[k])
        rows.add_row(
            f"{sweep.size[k]:g}", *(shown(model, v) for v in values), f"{sweep.seconds[k]:.2f}"
        )
    return rows


def _footer(sweep: BoundSweep) -> str:
    return (
        f"Pair, least and largest: {label(sweep.model, sweep.column)}; of the two models with the "
        "largest f, and of any model within the bounds. "
        f"{counted_by_row(sweep.marks, 'these models')}"
        f"{how_searched(in_model=sweep.in_model)} Seed {sweep.settings.seed}.\n"
        f"{origin(sweep.model)}"
    )


def _parts(sweep: BoundSweep) -> Sequence[RenderableType]:
    if isinstance(sweep.model, Knee):
        return [_knee_rows(sweep), Text(_knee_footer(sweep, sweep.model))]
    return [_rows(sweep), Text(_footer(sweep))]


WORDS = Words(
    summary=summary,
    text=lambda sweep: render(_parts(sweep)),
    html=lambda sweep: render(_parts(sweep), html=True),
)

"""What decides the outputs, for people."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from kneecore.knee.model import Knee
from kneecore.model import Model
from kneecore.presented import Words
from kneecore.report.marks import counted
from kneecore.report.outputs import drawn_line, heading, label, origin
from kneecore.report.tables import render, table
from kneecore.study.influence import InfluenceResult

__all__ = ["WORDS", "answer", "gaps"]

FloatArray = NDArray[np.float64]
_COUNT = 10
_MOST_GAPS = 5


def _subject(model: Model, column: int) -> tuple[str, str]:
    """Return where an output is looked at, and what it is called there."""
    one = model.columns[column]
    return (f"At {one.label} ", "the angle") if isinstance(model, Knee) else ("", one.title)


def answer(
    found: InfluenceResult, column: int | None = None, *, called: Callable[[str], str] = str
) -> str:
    """Return in one sentence what decides an output.

    Parameters
    ----------
    found : InfluenceResult
    column : int, optional
        Which of the m numbers that the model returns; the one that is watched for None.
    called : callable
        Gives the inputs other names.
    """
    column = found.model.watched if column is None else column
    names = found.deciding(column)
    where, what = _subject(found.model, column)
    if found.indices.constant[column]:
        return f"{where}{what} does not vary."
    if found.indices.unknown[column]:
        return f"{where}{what} failed too often to tell what decides it."
    told = [called(name) for name in names]
    if len(told) == 1:
        return f"{where}{told[0]} alone varies, and decides {what}."
    share = sum(found.indices.first_order[column, found.names.index(n)] for n in names)
    return (
        f"{where}{', '.join(told[:-1])} and {told[-1]} decide {what}: alone they explain "
        f"{100.0 * share:.0f} % of its variance."
    )


def _index(values: FloatArray, interval: FloatArray | None, column: int, k: int) -> str:
    if not np.isfinite(values[column, k]):
        return "-"
    told = f"{values[column, k]:.3f}"
    if interval is None:
        return told
    low, high = interval[:, column, k]
    return f"{told} ({low:.3f} to {high:.3f})"


def _largest(found: InfluenceResult, column: int) -> Table:
    """Return the largest indices in one output."""
    one, used = found.model.columns[column], found.indices
    where = f"at {one.label}" if isinstance(found.model, Knee) else f"of {one.title}"
    interval = "" if used.total_order_interval is None else " (95 % interval)"
    rows = table(f"Sobol' indices {where}{interval}", "parameter", "first order", "total")
    for name in found.deciding(column, _COUNT):
        k = found.names.index(name)
        rows.add_row(
            name,
            _index(used.first_order, used.first_order_interval, column, k),
            _index(used.total_order, used.total_order_interval, column, k),
        )
    return rows


def _groups(found: InfluenceResult) -> list[Table]:
    if not found.groups:
        return []
    model = found.model
    rows = table("First-order indices summed by group", heading(model), *found.groups)
    for k in model.order:
        rows.add_row(label(model, k), *(f"{v[k]:.3f}" for v in found.groups.values()))
    return [rows]


def _footer(found: InfluenceResult) -> str:
    used = found.indices
    became = [f"{used.n_failed_rows} rows replaced since a model failed", *counted(found.counts)]
    drawn = "".join(f"{line}\n" for line in (*gaps(found), *drawn_line(found.model)))
    return (
        f"{used.n_base} base rows (a power of two), {used.n_evaluations:,} models: "
        f"{', '.join(became)}; {found.seconds['total']:.2f} s.\n{drawn}{origin(found.model)}"
    )


def gaps(found: InfluenceResult) -> Sequence[str]:
    """Return which outputs have fewer base rows than others, since they failed, in one line."""
    n_used = found.indices.n_used
    if n_used is None:
        return []
    short = [k for k in np.argsort(n_used, kind="stable") if n_used[k] < found.indices.n_base]
    told = [f"{found.model.columns[k].title} {n_used[k]}" for k in short[:_MOST_GAPS]]
    more = f" and {len(short) - _MOST_GAPS} outputs more" if len(short) > _MOST_GAPS else ""
    return [f"Base rows of outputs that failed in some runs: {', '.join(told)}{more}."]


def _parts(found: InfluenceResult) -> Sequence[RenderableType]:
    shown = found.told_alone
    return [
        *(Text(answer(found, k)) for k in shown),
        Text(""),
        *(_largest(found, k) for k in shown),
        *_groups(found),
        Text(_footer(found)),
    ]


WORDS = Words(
    summary=answer,
    text=lambda found: render(_parts(found)),
    html=lambda found: render(_parts(found), html=True),
)

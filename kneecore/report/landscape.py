"""A slice of a model for people."""

from collections.abc import Sequence

import numpy as np
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from kneecore.presented import Words
from kneecore.report.marks import counted
from kneecore.report.outputs import heading, label, origin, shown
from kneecore.report.tables import render, table, with_unit
from kneecore.study.landscape import Landscape

__all__ = ["WORDS"]


def _ends(found: Landscape, column: int) -> tuple[float, float]:
    known = found.y[..., column][np.isfinite(found.y[..., column])]
    return (float(known.min()), float(known.max())) if len(known) else (np.nan, np.nan)


def summary(found: Landscape) -> str:
    """Return how far the watched output goes over the slice, in one sentence."""
    model = found.model
    column = model.columns[model.watched]
    low, high = (shown(model, v) for v in _ends(found, model.watched))
    one, two = found.names
    return (
        f"Over {one} and {two} {column.title} goes from {low} to "
        f"{with_unit(high, column.output.unit)}."
    )


def _rows(found: Landscape) -> Table:
    model, error = found.model, found.error
    more = () if error is None else ("surrogate's largest error",)
    rows = table("Outputs over the slice", heading(model), "least", "largest", *more)
    for k in model.order:
        cells = [shown(model, v) for v in _ends(found, k)]
        if error is not None:
            off = np.abs(error[..., k])
            cells.append(shown(model, float(np.nanmax(off)) if np.isfinite(off).any() else np.nan))
        rows.add_row(label(model, k), *cells)
    return rows


def _footer(found: Landscape) -> str:
    model = found.model
    between = []
    for name in found.names:
        one = model.inputs[model.names.index(name)]
        low, high = (f"{one.shown(v):.6g}" for v in one.box)
        between.append(f"{name} from {low} to {with_unit(high, one.label)}")
    became = ", ".join([f"{found.n_failed} failed", *counted(found.counts)])
    return (
        f"{' and '.join(between)}; the others are held. {found.n_models:,} models: {became}.\n"
        f"{origin(model)}"
    )


def _parts(found: Landscape) -> Sequence[RenderableType]:
    return [Text(summary(found)), Text(""), _rows(found), Text(_footer(found))]


WORDS = Words(
    summary=summary,
    text=lambda found: render(_parts(found)),
    html=lambda found: render(_parts(found), html=True),
)

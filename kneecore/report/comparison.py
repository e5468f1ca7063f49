"""A worst case beside samples, for people."""

from collections.abc import Sequence

import numpy as np
from rich.console import RenderableType

from kneecore.knee.model import Knee
from kneecore.presented import Words
from kneecore.report.outputs import heading, label, shown
from kneecore.report.tables import render, table
from kneecore.study.comparison import Comparison

__all__ = ["WORDS"]


def summary(found: Comparison) -> str:
    """Return at how many outputs the two models lie outside, in one sentence."""
    one, two = np.count_nonzero(found.excess > 0.0, axis=1)
    what = "loads" if isinstance(found.model, Knee) else "outputs"
    return (
        f"Model 1 lies outside of the 99.7 % band of the samples at {one} of "
        f"{found.model.n_outputs} {what}, model 2 at {two}."
    )


def _cell(found: Comparison, model: int, column: int) -> str:
    excess = shown(found.model, found.excess[model, column])
    share = found.excess_share[model, column]
    return f"{excess} ({100.0 * share:.0f} %)" if np.isfinite(share) else excess


def _parts(found: Comparison) -> Sequence[RenderableType]:
    unit = ", deg" if isinstance(found.model, Knee) else ""
    rows = table(
        "Worst case outside of the 99.7 % band",
        heading(found.model),
        *(f"model {m}{unit} (of its width)" for m in (1, 2)),
    )
    for k in found.model.order:
        rows.add_row(label(found.model, k), _cell(found, 0, k), _cell(found, 1, k))
    return [rows]


WORDS = Words(
    summary=summary,
    text=lambda found: render(_parts(found)),
    html=lambda found: render(_parts(found), html=True),
)

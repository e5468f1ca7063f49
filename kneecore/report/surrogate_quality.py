"""How far a surrogate can be trusted, for people."""

from collections.abc import Sequence

import numpy as np
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from kneecore.presented import Words
from kneecore.report.marks import counted
from kneecore.report.outputs import heading, label, origin, shown, solver
from kneecore.report.tables import render, table
from kneecore.study.surrogate_quality import SurrogateQuality

__all__ = ["WORDS"]


def summary(quality: SurrogateQuality) -> str:
    """Return how well pairs are ranked and outputs explained, in one sentence."""
    known = quality.explained[np.isfinite(quality.explained)]
    least = f"{100.0 * known.min():.1f} %" if len(known) else "nothing"
    return (
        f"From {quality.settings.training_samples} runs the surrogate ranks new pairs by f with a "
        f"correlation of {quality.rank_f:.3f}, and explains at least {least} of the variance of "
        "each output."
    )


def _rows(quality: SurrogateQuality) -> Table:
    model, told = quality.model, quality.judgement
    rows = table(
        "The surrogate at points that are new to it",
        heading(model),
        "leave-one-out error",
        "error",
        "rank",
        "variance explained %",
    )
    for k in model.order:
        loo = quality.loo_rms[k]
        rows.add_row(
            label(model, k),
            shown(model, loo, 3) if np.isfinite(loo) else "unknown",
            shown(model, told.rms[k], 3),
            f"{told.rank[k]:.3f}" if np.isfinite(told.rank[k]) else "-",
            f"{100.0 * told.explained[k]:.1f}" if np.isfinite(told.explained[k]) else "-",
        )
    return rows


def _footer(quality: SurrogateQuality) -> str:
    seconds = ", ".join(f"{name} {value:.3f}" for name, value in quality.seconds.items())
    became = counted(quality.counts)
    of_all = f" Of all that were run: {', '.join(became)}." if became else ""
    return (
        f"{quality.settings.training_samples} runs to learn from, {quality.n_failed} failed; "
        f"{quality.n_test} new points.{of_all} "
        "Errors: root mean squares; leave-one-out: at the runs themselves, each by the others. "
        "Rank: Spearman's correlation of surrogate and true model. "
        f"A worst case lies at the ends of the range: a surrogate that is right on average can be "
        f"wrong there.\nSeed {quality.settings.seed}{solver(quality.model)}. Seconds: "
        f"{seconds}.\n{origin(quality.model)}"
    )


def _parts(quality: SurrogateQuality) -> Sequence[RenderableType]:
    return [Text(summary(quality)), Text(""), _rows(quality), Text(_footer(quality))]


WORDS = Words(
    summary=summary,
    text=lambda quality: render(_parts(quality)),
    html=lambda quality: render(_parts(quality), html=True),
)

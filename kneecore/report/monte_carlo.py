"""A Monte-Carlo study for people."""

from collections.abc import Sequence

from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from kneecore.knee.model import Knee
from kneecore.presented import Words
from kneecore.report.marks import counted
from kneecore.report.outputs import drawn_line, failure_lines, heading, label, origin, shown
from kneecore.report.tables import render, table, with_unit
from kneecore.study.monte_carlo import MonteCarloResult

__all__ = ["WORDS"]

_COLUMNS = ("mean", "sd", "mean - 3 sd", "mean + 3 sd", "0.15 %", "99.85 %")


def summary(study: MonteCarloResult) -> str:
    """Return how the watched output is spread, in one sentence."""
    model, k = study.model, study.model.watched
    column = model.columns[k]
    mean, low, high = (
        shown(model, v[k])
        for v in (study.y.mean, study.y.percentile_lower, study.y.percentile_upper)
    )
    unit = column.output.unit
    return (
        f"{column.title}: {with_unit(mean, unit)} on average; 99.7 % of the samples lie from {low} "
        f"to {with_unit(high, unit)}."
    )


def _rows(study: MonteCarloResult) -> Table:
    model, y = study.model, study.y
    title = "Flexion angle, deg" if isinstance(model, Knee) else "Outputs of the samples"
    rows = table(title, heading(model), *_COLUMNS)
    columns = (
        y.mean,
        y.sd,
        y.sigma_lower,
        y.sigma_upper,
        y.percentile_lower,
        y.percentile_upper,
    )
    for k in model.order:
        rows.add_row(label(model, k), *(shown(model, column[k]) for column in columns))
    return rows


def _footer(study: MonteCarloResult) -> str:
    settings, counts = study.settings, study.counts
    cut = " (cancelled)" if study.stop_reason == "cancelled" else ""
    drawn: str = settings.sampling
    if drawn == "uniform" and study.model.drawn_as:
        drawn = "independent"
    told = f"{drawn}, rounded up to a power of two" if drawn == "sobol" else drawn
    became = [f"{study.n_failed} failed", *counted(counts)]
    lines = [
        f"{study.n_samples:,} samples{cut} ({told}, seed {settings.seed}): "
        f"{', '.join(became)}; {study.seconds['sampling']:.2f} s.",
        *drawn_line(study.model),
        *failure_lines(study.model),
        origin(study.model),
    ]
    return "\n".join(lines)


def _parts(study: MonteCarloResult) -> Sequence[RenderableType]:
    return [_rows(study), Text(_footer(study))]


WORDS = Words(
    summary=summary,
    text=lambda study: render(_parts(study)),
    html=lambda study: render(_parts(study), html=True),
)

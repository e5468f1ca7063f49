"""Surrogates by the runs they learned from, for people."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from kneecore.knee.model import Knee
from kneecore.presented import Words
from kneecore.report.marks import counted
from kneecore.report.outputs import origin, solver, spread
from kneecore.report.tables import render, table, with_unit
from kneecore.study.training_sweep import TrainingSweep

__all__ = ["WORDS"]

FloatArray = NDArray[np.float64]


def _middle(values: FloatArray, digits: int) -> str:
    """Return median and range over the seeds."""
    known = values[np.isfinite(values)]
    if len(known) == 0:
        return "failed"
    low, middle, high = (f"{v:.{digits}f}" for v in (known.min(), np.median(known), known.max()))
    return middle if len(values) == 1 else f"{middle} ({low} to {high})"


def summary(sweep: TrainingSweep) -> str:
    """Return the gap by the largest and the smallest number of runs, in one sentence."""
    first, last = (_middle(sweep.gap_percent[k], 1) for k in (0, -1))
    return (
        f"From {sweep.size[0]} runs the surrogate's optimum has a gap of {first} %, from "
        f"{sweep.size[-1]} runs of {last} %."
    )


def _rows(sweep: TrainingSweep) -> Table:
    model, unit = sweep.model, sweep.model.objective_unit
    each = "angles" if isinstance(model, Knee) else "outputs"
    rows = table(
        "Surrogates by the runs they learned from: median (range over the seeds)",
        "runs",
        "gap %",
        with_unit("f model", unit),
        "rank of f",
        f"rank of {each}",
        with_unit("error", unit),
        "s",
    )
    for k, size in enumerate(sweep.size):
        rows.add_row(
            str(size),
            _middle(sweep.gap_percent[k], 1),
            spread(model, sweep.objective_model[k], 0),
            _middle(sweep.rank_f[k], 2),
            _middle(sweep.rank_outputs[k], 2),
            spread(model, sweep.rms_error[k], 2),
            f"{np.median(sweep.seconds[k]):.2f}",
        )
    return rows


def _footer(sweep: TrainingSweep) -> str:
    models, at_worst, each = "models", "output that is ranked worst", "outputs"
    if isinstance(sweep.model, Knee):
        models, at_worst, each = "knees", "angles at the worst load", "angles"
    became = counted(sweep.counts)
    of_all = f" Of all {models} that were run: {', '.join(became)}." if became else ""
    return (
        f"Gap: what the true f of the best pair lacks of the surrogate's f. Ranks: Spearman's "
        f"correlation of surrogate and true model over {sweep.n_test} new {models}, of f over "
        f"pairs of them and of the {at_worst}; error: root mean square of the {each}. "
        f"Time: sampling, fit and search.\n"
        f"Method: {sweep.settings.method}{solver(sweep.model)}, {sweep.settings.n_seeds} seeds "
        f"from {sweep.settings.seed}; {int(sweep.n_failed.sum())} training samples failed and "
        f"were left out.{of_all}\n{origin(sweep.model)}"
    )


def _parts(sweep: TrainingSweep) -> Sequence[RenderableType]:
    return [_rows(sweep), Text(_footer(sweep))]


WORDS = Words(
    summary=summary,
    text=lambda sweep: render(_parts(sweep)),
    html=lambda sweep: render(_parts(sweep), html=True),
)

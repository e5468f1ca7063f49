"""Sweeps for people: tables for terminals and notebooks."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from rich.text import Text

from kneecore.knee.physics.dynamics import TURN_LIMIT
from kneecore.knee.physics.forces import THETA_0
from kneecore.report.tables import render, table

if TYPE_CHECKING:
    from kneecore.knee.space import ParameterSpace
    from kneecore.study.bound_sweep import BoundSweep
    from kneecore.study.needed_accuracy import NeededAccuracy
    from kneecore.study.training_sweep import TrainingSweep

NO_PROOF = "Exact searches: the worst found from many starts, which is no proof of the worst."


def _middle(values: NDArray[np.float64], digits: int) -> str:
    """Return median and range over the seeds as text."""
    known = values[np.isfinite(values)]
    if len(known) == 0:
        return "failed"
    low, middle, high = (f"{v:.{digits}f}" for v in (known.min(), np.median(known), known.max()))
    return middle if len(values) == 1 else f"{middle} ({low} to {high})"


def _baseline(space: "ParameterSpace") -> str:
    return f"Baseline: {space.title}. {space.note or ''}".rstrip()


def training_report(sweep: "TrainingSweep") -> str:
    """Return a sweep over training sizes as text."""
    rows = table(
        "Surrogates by the runs they learned from: median (range over the seeds)",
        "runs",
        "gap %",
        "f model deg",
        "rank of f",
        "rank of angles",
        "error deg",
        "s",
    )
    for k, size in enumerate(sweep.size):
        rows.add_row(
            str(size),
            _middle(sweep.gap_percent[k], 1),
            _middle(sweep.objective_model[k], 0),
            _middle(sweep.rank_correlation[k], 2),
            _middle(sweep.rank_correlation_angles[k], 2),
            _middle(sweep.rms_error_deg[k], 2),
            f"{np.median(sweep.seconds[k]):.2f}",
        )
    n_failed = int(sweep.n_failed.sum())
    footer = (
        f"Gap: what the true f of the best pair lacks of the surrogate's f. Ranks: Spearman's "
        f"correlation of surrogate and true model over {sweep.n_test} new knees, of f over pairs "
        f"of them and of the angles at the worst load; error: root mean square of the angles. "
        f"Time: sampling, fit and search.\n"
        f"Method: {sweep.method}, solver: {sweep.solver}, {sweep.n_failed.shape[1]} seeds from "
        f"{sweep.seed}; {n_failed} training samples failed and were left out.\n"
        f"{_baseline(sweep.space)}"
    )
    return render([rows, Text(footer)])


def bound_report(sweep: "BoundSweep") -> str:
    """Return a sweep over the geometry's bound as text."""
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
        sweep.extension_deficit_deg,
        sweep.over_extension_deg,
        *sweep.extremes_deg.T,
        sweep.seconds,
    )
    for k, bound in enumerate(sweep.bound_mm):
        rows.add_row(f"{bound:g}", *(f"{column[k]:.2f}" for column in columns))
    ends = np.degrees(THETA_0 - TURN_LIMIT)
    at_the_end = (
        f"At {ends:.1f} deg the model's range ends: such a knee has come apart. "
        if (sweep.extremes_deg < ends + 1.0).any()
        else ""
    )
    footer = (
        "Deficit (of extension) and over-extension: of the two knees with the largest f, at the "
        f"largest extension moment. {at_the_end}Least and largest: angles of any knee within the "
        "bound there. "
        f"The slope's bound changes in proportion; true model, solver: {sweep.solver}, seed "
        f"{sweep.seed}. {NO_PROOF}\n{_baseline(sweep.space)}"
    )
    return render([rows, Text(footer)])


def accuracy_report(need: "NeededAccuracy") -> str:
    """Return the needed accuracy as text."""
    lines = [need.answer()]
    if need.sampled_deg is not None:
        lines.append(
            f"{need.n_sampled:,} random knees within that bound all reach "
            f"{need.sampled_deg:.2f} deg: sampling would have passed a wider one."
        )
    lines += [
        f"{need.n_searches} exact searches at +5 N m, solver: {need.solver}, "
        f"{need.seconds:.2f} s. {NO_PROOF}",
        _baseline(need.space),
    ]
    return render([Text("\n".join(lines))])

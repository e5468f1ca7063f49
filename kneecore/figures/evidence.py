"""Figures of how good a result is: the repair of a surrogate, and all methods' ways to theirs."""

import numpy as np
from matplotlib.figure import Figure

from kneecore.figures.style import axis_label, styled
from kneecore.model import Model
from kneecore.search.result import METHOD_NAMES, Repair, SearchResult


def repair_figure(repair: Repair, model: Model) -> Figure:
    """Return how f by the surrogate and by the true model came together."""
    with styled():
        figure = Figure(figsize=(6.0, 5.0), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        n_models = [r.n_models for r in repair.rounds]
        for values, colour, marker, label in (
            ([r.objective_surrogate for r in repair.rounds], "#CC79A7", "s", "surrogate"),
            ([r.objective_model for r in repair.rounds], "#009E73", "o", "true model"),
        ):
            above.plot(
                n_models,
                [np.nan if v is None else v for v in values],
                color=colour,
                marker=marker,
                markersize=4,
                linewidth=1.4,
                label=label,
            )
        above.set_ylabel(axis_label("f of the surrogate's optimum", model.objective_unit))
        above.set_title("Repair of the surrogate")
        above.legend(loc="upper right")
        gaps = [np.nan if r.gap_percent is None else abs(r.gap_percent) for r in repair.rounds]
        below.plot(n_models, gaps, color="0.3", marker="o", markersize=4, linewidth=1.4)
        if np.nanmax([0.0, *gaps]) > 0.0:  # of a constant model there is nothing to close
            below.set_yscale("log")
        below.axhline(repair.goal_percent, color="#D55E00", linewidth=1.0, linestyle="--")
        below.annotate(
            f"goal: {repair.goal_percent:g} %",
            (1.0, repair.goal_percent),
            xycoords=("axes fraction", "data"),
            xytext=(-4, 4),
            textcoords="offset points",
            ha="right",
            color="#D55E00",
            fontsize=8,
        )
        below.set_ylabel("|gap|, %")
        below.set_xlabel("models added to the training samples")
        return figure


_METHODS = {  # colour and the mark at a line's end
    "ga_surrogate": ("#CC79A7", "s"),
    "repair": ("#009E73", "o"),
    "exact": ("#0072B2", "^"),
    "ga": ("#8c8c8c", "D"),
}


def convergence_figure(result: SearchResult) -> Figure:
    """Return each method's best f in the true model against the true models that it ran."""
    with styled():
        figure = Figure(figsize=(7.2, 4.4), layout="constrained")
        axes = figure.add_subplot()
        for trace in result.methods:
            if not trace.objective:
                continue
            colour, marker = _METHODS[trace.method]
            axes.step(trace.n_models, trace.objective, where="post", color=colour, linewidth=1.5)
            axes.plot(
                trace.n_models[-1],
                trace.objective[-1],
                color=colour,
                marker=marker,
                markersize=6,
                linestyle="none",
                label=METHOD_NAMES[trace.method],
            )
        best = result.best_of_all
        if best is not None:
            axes.axhline(best, color="0.5", linewidth=0.8, linestyle=":")
        axes.set_xscale("log")
        axes.set_xlabel("true models run (log scale)")
        axes.set_ylabel(axis_label("best f in the true model", result.model.objective_unit))
        axes.set_title("How the methods come to their worst case")
        figure.legend(loc="outside lower center", ncols=2, fontsize=8)
        return figure

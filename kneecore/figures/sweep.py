"""Figures of sweeps."""

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from kneecore.figures.search import COLOURS, STYLE

if TYPE_CHECKING:
    from kneecore.study.bound_sweep import BoundSweep
    from kneecore.study.needed_accuracy import NeededAccuracy
    from kneecore.study.training_sweep import TrainingSweep

FloatArray = NDArray[np.float64]
_PURPLE = "#CC79A7"  # the surrogate's colour
_PAPERS_SIZE = 50


def _spread(axes: Axes, size: NDArray[np.int64], values: FloatArray, label: str) -> None:
    axes.plot(size, values, "o", color="0.6", markersize=3, zorder=2)
    axes.plot(size, np.nanmedian(values, axis=1), color=_PURPLE, linewidth=1.8, zorder=3)
    axes.axvline(_PAPERS_SIZE, color="0.5", linewidth=0.8, linestyle=":")
    axes.set_xscale("log")
    axes.set_xticks(size, [str(n) for n in size], rotation=45)
    axes.minorticks_off()
    axes.set_xlabel("training runs")
    axes.set_ylabel(label)


def training_figure(sweep: "TrainingSweep") -> Figure:
    """Return gap, rank correlation and time against the training size: medians and all seeds."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10.5, 3.6), layout="constrained")
        left, middle, right = figure.subplots(1, 3)
        _spread(left, sweep.size, sweep.gap_percent, "gap at the best pair, %")
        left.axhline(0.0, color="0.5", linewidth=0.8)
        _spread(middle, sweep.size, sweep.rank_correlation, "rank correlation of f, new pairs")
        _spread(right, sweep.size, sweep.seconds, "sampling, fit and search, s")
        right.set_ylim(bottom=0.0)
        figure.suptitle(
            "What a surrogate gains from more runs (line: median; dotted: the paper's 50)",
            fontsize="medium",
        )
    return figure


def bound_figure(sweep: "BoundSweep", need: "NeededAccuracy | None" = None) -> Figure:
    """Return f and the angles at the largest extension moment against the bound."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.8), layout="constrained")
        left, right = figure.subplots(1, 2)
        left.plot(sweep.bound_mm, sweep.objective, "o-", color="0.2", markersize=4)
        left.set_ylabel("f of the worst pair, deg over 12 loads")
        left.set_ylim(bottom=0.0)
        for k, name in enumerate(("model_1", "model_2")):
            words = ("over-extends", "cannot extend")[k]
            right.plot(
                sweep.bound_mm,
                sweep.pair_deg[:, k],
                "o-",
                color=COLOURS[name],
                markersize=4,
                label=f"worst pair, the knee that {words}",
            )
            right.plot(
                sweep.bound_mm,
                sweep.extremes_deg[:, k],
                "--",
                color=COLOURS[name],
                linewidth=1.2,
                label=f"{('least', 'largest')[k]} angle of any knee",
            )
        right.axhline(0.0, color="0.5", linewidth=0.8, linestyle=":")
        right.set_ylabel("knee angle at +5 N m, deg (flexion > 0)")
        if need is not None and need.bound_mm is not None:
            right.axhline(need.within_deg, color="0.5", linewidth=0.8)
            right.plot(need.bound_mm, need.within_deg, "D", color="k", zorder=4, markersize=5)
            right.annotate(
                f"{need.bound_mm:.2f} mm: all within {need.within_deg:g} deg",
                (need.bound_mm, need.within_deg),
                xytext=(-14, 52),
                textcoords="offset points",
                fontsize="small",
                arrowprops={"arrowstyle": "-", "color": "0.4", "linewidth": 0.8},
            )
        for axes in (left, right):
            axes.set_xlim(left=0.0)
            axes.set_xlabel("bound on the geometry, ± mm")
        right.legend(fontsize="x-small")
    return figure

"""What a surrogate gains from more runs."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from kneecore.figures.style import SURROGATE, styled
from kneecore.study.training_sweep import TrainingSweep

__all__ = ["draw"]

FloatArray = NDArray[np.float64]
_PAPERS_SIZE = 50


def _spread(axes: Axes, size: NDArray[np.int64], values: FloatArray, label: str) -> None:
    known = np.isfinite(values).any(axis=1)
    axes.plot(size, values, "o", color="0.6", markersize=3, zorder=2)
    axes.plot(
        size[known],
        np.nanmedian(values[known], axis=1),
        color=SURROGATE,
        linewidth=1.8,
        zorder=3,
    )
    axes.axvline(_PAPERS_SIZE, color="0.5", linewidth=0.8, linestyle=":")
    axes.set_xscale("log")
    axes.set_xticks(size, [str(n) for n in size], rotation=45)
    axes.minorticks_off()
    axes.set_xlabel("training runs")
    axes.set_ylabel(label)


def draw(sweep: TrainingSweep) -> dict[str, Figure]:
    """Return gap, rank correlation and time against the training size: medians and all seeds."""
    with styled():
        figure = Figure(figsize=(10.5, 3.6), layout="constrained")
        left, middle, right = figure.subplots(1, 3)
        _spread(left, sweep.size, sweep.gap_percent, "gap at the best pair, %")
        left.axhline(0.0, color="0.5", linewidth=0.8)
        _spread(middle, sweep.size, sweep.rank_f, "rank correlation of f, new pairs")
        middle.ticklabel_format(axis="y", useOffset=False)
        _spread(right, sweep.size, sweep.seconds, "sampling, fit and search, s")
        right.set_ylim(bottom=0.0)
        figure.suptitle(
            "What a surrogate gains from more runs (line: median; dotted: the paper's 50)",
            fontsize="medium",
        )
    return {"figure_training": figure}

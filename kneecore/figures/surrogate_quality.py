"""How far a surrogate can be trusted: f of new pairs by both, and each output's error."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from kneecore.figures.columns import name_columns
from kneecore.figures.style import SURROGATE, axis_label, styled
from kneecore.study.surrogate_quality import SurrogateQuality

__all__ = ["draw"]


def draw(quality: SurrogateQuality) -> dict[str, Figure]:
    """Return the figures of a surrogate's quality by name."""
    with styled():
        figure = Figure(figsize=(9.0, 3.8), layout="constrained")
        left, right = figure.subplots(1, 2)
        _pairs(left, quality)
        _explained(right, quality)
        figure.suptitle(
            f"A surrogate of {quality.settings.training_samples} runs, at points that are new to "
            "it",
            fontsize="medium",
        )
    return {"figure_surrogate_quality": figure}


def _pairs(axes: Axes, quality: SurrogateQuality) -> None:
    told, unit = quality.judgement, quality.model.objective_unit
    axes.plot(told.f_model, told.f_surrogate, ".", color=SURROGATE, markersize=3)
    largest = float(max(told.f_model.max(), told.f_surrogate.max()))
    axes.plot([0.0, largest], [0.0, largest], color="0.5", linewidth=0.8)
    axes.set_xlabel(axis_label("f of new pairs, true model", unit))
    axes.set_ylabel(axis_label("f of new pairs, surrogate", unit))
    axes.set_title(f"rank correlation {told.rank_f:.3f}")


def _explained(axes: Axes, quality: SurrogateQuality) -> None:
    model = quality.model
    order = list(model.order)
    share = 100.0 * np.maximum(np.nan_to_num(quality.explained[order]), 0.0)
    axes.bar(range(len(order)), share, color="#0072B2", width=0.7)
    name_columns(axes, model)
    axes.set_ylim(0.0, 100.0)
    axes.set_ylabel("variance explained, %")

"""How far a worst case lies outside of the sampled band, output by output."""

import numpy as np
from matplotlib.figure import Figure

from kneecore.figures.columns import name_columns
from kneecore.figures.style import COLOURS, LABELS, styled
from kneecore.knee.model import Knee
from kneecore.search.result import MODELS
from kneecore.study.comparison import Comparison

__all__ = ["draw"]


def draw(found: Comparison) -> dict[str, Figure]:
    """Return a comparison's figures by name."""
    model = found.model
    order = list(model.order)
    at = np.arange(len(order))
    with styled():
        figure = Figure(
            figsize=(min(9.0, max(5.0, 0.55 * len(order) + 1.5)), 3.8), layout="constrained"
        )
        axes = figure.add_subplot()
        for k, name in enumerate(MODELS[1:]):
            axes.bar(
                at + 0.4 * k - 0.2,
                100.0 * np.nan_to_num(found.excess_share[k, order], posinf=0.0),
                width=0.4,
                color=COLOURS[name],
                label=LABELS[name],
            )
        name_columns(axes, model)
        axes.set_xlabel("external moment" if isinstance(model, Knee) else "output")
        axes.set_ylabel("outside of the 99.7 % band, % of its width")
        figure.legend(loc="outside upper center", ncols=2)
    return {"figure_comparison": figure}

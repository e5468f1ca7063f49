"""What decides the outputs: the largest indices as bars, all of them as a map."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from kneecore.figures.columns import name_columns
from kneecore.figures.style import styled
from kneecore.knee.model import Knee
from kneecore.model import Model
from kneecore.study.influence import InfluenceResult

__all__ = ["bars_figure", "draw", "map_figure"]


def draw(found: InfluenceResult) -> dict[str, Figure]:
    """Return the figures of influence by name."""
    return {"figure_influence": bars_figure(found), "figure_influence_map": map_figure(found)}


def bars_figure(found: InfluenceResult, count: int = 10) -> Figure:
    """Return sorted total indices, with intervals, of the outputs that are shown alone."""
    columns = found.told_alone
    with styled():
        figure = Figure(figsize=(0.6 + 3.5 * len(columns), 3.8), layout="constrained")
        grid = np.atleast_1d(figure.subplots(1, len(columns), sharex=True))
        for axes, column in zip(grid, columns, strict=True):
            _bars(axes, found, column, count)
        if found.model.drawn_as:
            figure.suptitle(f"inputs: {found.model.drawn_as}", fontsize="medium")
    return figure


def _bars(axes: Axes, found: InfluenceResult, column: int, count: int) -> None:
    names = found.deciding(column, count)[::-1]
    places = [found.names.index(name) for name in names]
    values = np.nan_to_num(found.indices.total_order[column, places])
    interval = found.indices.total_order_interval
    errors = None
    if interval is not None:
        errors = np.maximum(np.abs(np.nan_to_num(interval[:, column, places]) - values), 0.0)
    axes.barh(names, values, xerr=errors, color="#0072B2", height=0.7, ecolor="0.3")
    axes.set_xlabel("total Sobol' index")
    one = found.model.columns[column]
    axes.set_title(one.label if isinstance(found.model, Knee) else one.title)
    axes.grid(axis="y", visible=False)


def _what(model: Model) -> str:
    """Return what the outputs are, side by side."""
    if isinstance(model, Knee):
        return "external moment, N m (extension > 0)"
    return (model.outputs[0].axis_name if len(model.outputs) == 1 else "") or "output"


def map_figure(found: InfluenceResult) -> Figure:
    """Return total indices of all inputs in all outputs as a heat map."""
    model = found.model
    knee = isinstance(model, Knee)
    moments = [f"{model.columns[k].at:+g}" for k in model.order] if knee else None
    with styled():
        height = 6.4 if knee else max(3.0, 0.22 * len(found.names) + 1.6)
        figure = Figure(figsize=(6.4, height), layout="constrained")
        axes = figure.add_subplot()
        total = found.indices.total_order[list(model.order)].T
        image = axes.imshow(total, aspect="auto", cmap="Blues", vmin=0.0)
        name_columns(axes, model, moments)
        axes.set_yticks(range(len(found.names)), found.names)
        axes.set_xlabel(_what(model))
        axes.grid(visible=False)
        drawn = f"\n(inputs: {model.drawn_as})" if model.drawn_as else ""
        axes.set_title(f"Total Sobol' index of each {'parameter' if knee else 'input'}{drawn}")
        figure.colorbar(image, ax=axes, shrink=0.6, label="share of the variance")
    return figure

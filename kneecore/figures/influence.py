"""What decides the outputs: the largest indices as bars, all of them as a map."""

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from kneecore.figures.style import STYLE
from kneecore.knee.model import Knee
from kneecore.model import Model
from kneecore.study.influence import InfluenceResult

__all__ = ["bars_figure", "draw", "map_figure"]

_MANY = 24
"""Outputs; of more, only some are named under the map."""


def draw(found: InfluenceResult) -> dict[str, Figure]:
    """Return the figures of influence by name."""
    return {"figure_influence": bars_figure(found), "figure_influence_map": map_figure(found)}


def bars_figure(found: InfluenceResult, count: int = 10) -> Figure:
    """Return sorted total indices, with intervals, of the outputs that are shown alone."""
    columns = found.told_alone
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(0.6 + 3.5 * len(columns), 3.8), layout="constrained")
        grid = np.atleast_1d(figure.subplots(1, len(columns), sharex=True))
        for axes, column in zip(grid, columns, strict=True):
            _bars(axes, found, column, count)
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
    axes.set_title(found.model.columns[column].label)
    axes.grid(axis="y", visible=False)


def _ticks(model: Model) -> tuple[list[int], list[str], str]:
    """Return which places of the order are named, how, and what they are."""
    labels = [model.columns[k].label for k in model.order]
    if isinstance(model, Knee):
        moments = [model.columns[k].at for k in model.order]
        labels, what = [f"{m:+g}" for m in moments], "external moment, N m (extension > 0)"
    else:
        what = model.outputs[0].axis_name if len(model.outputs) == 1 else "output"
    step = -(-len(labels) // _MANY)
    return list(range(0, len(labels), step)), labels[::step], what


def map_figure(found: InfluenceResult) -> Figure:
    """Return total indices of all inputs in all outputs as a heat map."""
    places, labels, what = _ticks(found.model)
    knee = isinstance(found.model, Knee)
    with mpl.rc_context(STYLE):
        height = 6.4 if knee else max(3.0, 0.22 * len(found.names) + 1.6)
        figure = Figure(figsize=(6.4, height), layout="constrained")
        axes = figure.add_subplot()
        total = found.indices.total_order[list(found.model.order)].T
        image = axes.imshow(total, aspect="auto", cmap="Blues", vmin=0.0)
        long = max(map(len, labels)) > 5 and len(labels) > 3
        axes.set_xticks(places, labels, rotation=45 if long else 0)
        axes.set_yticks(range(len(found.names)), found.names)
        axes.set_xlabel(what)
        axes.grid(visible=False)
        axes.set_title(f"Total Sobol' index of each {'parameter' if knee else 'input'}")
        figure.colorbar(image, ax=axes, shrink=0.6, label="share of the variance")
    return figure

"""The sampled band: of knees as moment against angle, of any other model output by output."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from kneecore.figures.columns import grid_of
from kneecore.figures.style import (
    COLOURS,
    LABELS,
    SURROGATE,
    axis_label,
    curve,
    output_slices,
    styled,
)
from kneecore.knee.model import Knee
from kneecore.outputs import Output
from kneecore.search.result import MODELS, SearchResult
from kneecore.study.monte_carlo import MonteCarloResult

__all__ = ["band_figure", "draw"]

FloatArray = NDArray[np.float64]


def draw(study: MonteCarloResult, worst: SearchResult | None = None) -> dict[str, Figure]:
    """Return a study's figures by name, with a worst case if there is one."""
    return {"figure_band": band_figure(study, worst)}


def band_figure(study: MonteCarloResult, worst: SearchResult | None = None) -> Figure:
    """Return the 99.7 % band of the outputs, with a worst case in front of it."""
    with styled():
        if isinstance(study.model, Knee):
            return _knee_band(study, worst)
        return _outputs_band(study, worst)


def _title(study: MonteCarloResult) -> str:
    drawn = f"\n(inputs: {study.model.drawn_as})" if study.model.drawn_as else ""
    return f"{study.n_samples - study.n_failed:,} samples of the true model{drawn}"


def _knee_band(study: MonteCarloResult, worst: SearchResult | None) -> Figure:
    figure = Figure(figsize=(6.0, 4.2), layout="constrained")
    axes, spread, model = figure.add_subplot(), study.y, study.model
    lower, moments = curve(model, spread.percentile_lower)
    axes.fill_betweenx(
        moments,
        lower,
        curve(model, spread.percentile_upper)[0],
        color=SURROGATE,
        alpha=0.25,
        linewidth=0.0,
        label="99.7 % of the samples",
    )
    for k, bound in enumerate((spread.sigma_lower, spread.sigma_upper)):
        axes.plot(
            *curve(model, bound),
            color=SURROGATE,
            linewidth=0.9,
            linestyle="--",
            label="mean ± 3 sd" if k == 0 else None,
        )
    axes.plot(*curve(model, spread.mean), color="0.3", linewidth=1.4, label="mean")
    for name, y in _pair(worst):
        axes.plot(*curve(model, y), color=COLOURS[name], linewidth=1.6, label=LABELS[name])
    axes.axvline(0.0, color="0.5", linewidth=0.8, linestyle=":")
    axes.axhline(0.0, color="0.5", linewidth=0.8)
    axes.set_xlabel("knee angle, deg (flexion > 0)")
    axes.set_ylabel("external moment, N m (extension > 0)")
    axes.set_title(_title(study))
    axes.legend()
    return figure


def _pair(worst: SearchResult | None) -> list[tuple[str, FloatArray]]:
    return [] if worst is None else list(zip(MODELS[1:], worst.y, strict=True))


def _outputs_band(study: MonteCarloResult, worst: SearchResult | None) -> Figure:
    slices = output_slices(study.model)
    figure, grid = grid_of(len(slices))
    for axes, (output, columns) in zip(grid, slices, strict=True):
        if output.axis is None:
            _numbers(axes, study, output, columns, worst)
        else:
            _curves(axes, study, output, columns, worst)
    grid[0].legend()
    figure.suptitle(_title(study), fontsize="medium")
    return figure


def _curves(
    axes: Axes,
    study: MonteCarloResult,
    output: Output,
    columns: slice,
    worst: SearchResult | None,
) -> None:
    """Draw a band over an output's axis."""
    at, spread = np.array(output.axis), study.y
    axes.fill_between(
        at,
        spread.percentile_lower[columns],
        spread.percentile_upper[columns],
        color=SURROGATE,
        alpha=0.25,
        linewidth=0.0,
        label="99.7 % of the samples",
    )
    for k, bound in enumerate((spread.sigma_lower, spread.sigma_upper)):
        axes.plot(
            at,
            bound[columns],
            color=SURROGATE,
            linewidth=0.9,
            linestyle="--",
            label="mean ± 3 sd" if k == 0 else None,
        )
    axes.plot(at, spread.mean[columns], color="0.3", linewidth=1.4, label="mean")
    for name, y in _pair(worst):
        axes.plot(at, y[columns], color=COLOURS[name], linewidth=1.6, label=LABELS[name])
    axes.set_xlabel(axis_label(output.axis_name or "axis", output.axis_unit))
    axes.set_ylabel(axis_label(output.name, output.unit))


def _numbers(
    axes: Axes,
    study: MonteCarloResult,
    output: Output,
    columns: slice,
    worst: SearchResult | None,
) -> None:
    """Draw a band for a single number."""
    spread, k = study.y, columns.start
    low, high = spread.percentile_lower[k], spread.percentile_upper[k]
    axes.bar(
        [0.0],
        [high - low],
        bottom=low,
        width=0.6,
        color=SURROGATE,
        alpha=0.25,
        label="99.7 % of the samples",
    )
    ends = [spread.sigma_lower[k], spread.sigma_upper[k]]
    axes.hlines(
        ends, -0.3, 0.3, color=SURROGATE, linewidth=0.9, linestyles="--", label="mean ± 3 sd"
    )
    axes.hlines(spread.mean[k], -0.3, 0.3, color="0.3", linewidth=1.4, label="mean")
    for name, y in _pair(worst):
        axes.hlines(y[k], -0.4, 0.4, color=COLOURS[name], linewidth=2.0, label=LABELS[name])
    axes.set_xlim(-0.8, 0.8)
    axes.set_xticks([])
    axes.set_ylabel(axis_label(output.name, output.unit))

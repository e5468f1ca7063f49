"""Figures of a study: the sampled band, and what decides the angles."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from kneecore.figures.search import COLOURS, LABELS, STYLE, along, render, rests_unloaded
from kneecore.knee.response import MOMENT

if TYPE_CHECKING:
    from kneecore.search.result import SearchResult
    from kneecore.study.influence import InfluenceResult
    from kneecore.study.monte_carlo import MonteCarloResult

FloatArray = NDArray[np.float64]

_ORDER = np.argsort(-MOMENT)


def band_figure(study: "MonteCarloResult", worst: "SearchResult | None" = None) -> Figure:
    """Return the 99.7 % band of moment against angle, with a worst case in front of it."""
    through_rest = rests_unloaded(study.space, study.rest_length)
    moments = along(MOMENT, through_rest, 0.0)

    def curve(angles_deg: FloatArray) -> FloatArray:
        return along(angles_deg, through_rest)

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.0, 4.2), layout="constrained")
        axes = figure.add_subplot()
        spread = study.flexion_deg
        axes.fill_betweenx(
            moments,
            curve(spread.percentile_lower),
            curve(spread.percentile_upper),
            color="#CC79A7",
            alpha=0.25,
            linewidth=0.0,
            label="99.7 % of the samples",
        )
        for k, bound in enumerate((spread.sigma_lower, spread.sigma_upper)):
            axes.plot(
                curve(bound),
                moments,
                color="#CC79A7",
                linewidth=0.9,
                linestyle="--",
                label="mean ± 3 sd" if k == 0 else None,
            )
        axes.plot(curve(spread.mean), moments, color="0.3", linewidth=1.4, label="mean")
        if worst is not None:
            for name in ("model_1", "model_2"):
                axes.plot(
                    curve(np.degrees(worst.models[name].flexion)),
                    moments,
                    color=COLOURS[name],
                    linewidth=1.6,
                    label=LABELS[name],
                )
        axes.axvline(0.0, color="0.5", linewidth=0.8, linestyle=":")
        axes.axhline(0.0, color="0.5", linewidth=0.8)
        axes.set_xlabel("knee angle, deg (flexion > 0)")
        axes.set_ylabel("external moment, N m (extension > 0)")
        axes.set_title(f"{study.n_samples - study.n_failed:,} samples of the true model")
        axes.legend()
    return figure


def bars_figure(found: "InfluenceResult", count: int = 10) -> Figure:
    """Return sorted total indices, with intervals, at the largest moments."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.6, 3.8), layout="constrained")
        for axes, moment in zip(figure.subplots(1, 2, sharex=True), (5.0, -5.0), strict=True):
            names = found.deciding(moment, count)[::-1]
            load = int(np.argmin(np.abs(MOMENT - moment)))
            columns = [found.names.index(name) for name in names]
            values = found.indices.total_order[load, columns]
            interval = found.indices.total_order_interval
            errors = None
            if interval is not None:
                errors = np.maximum(np.abs(interval[:, load, columns] - values), 0.0)
            axes.barh(names, values, xerr=errors, color="#0072B2", height=0.7, ecolor="0.3")
            axes.set_xlabel("total Sobol' index")
            axes.set_title(f"{moment:+g} N m")
            axes.grid(axis="y", visible=False)
    return figure


def map_figure(found: "InfluenceResult") -> Figure:
    """Return total indices of all parameters at all loads as a heat map."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.4, 6.4), layout="constrained")
        axes = figure.add_subplot()
        image = axes.imshow(
            found.indices.total_order[_ORDER].T, aspect="auto", cmap="Blues", vmin=0.0
        )
        axes.set_xticks(range(len(MOMENT)), [f"{m:+g}" for m in MOMENT[_ORDER]])
        axes.set_yticks(range(len(found.names)), found.names)
        axes.set_xlabel("external moment, N m (extension > 0)")
        axes.grid(visible=False)
        axes.set_title("Total Sobol' index of each parameter")
        figure.colorbar(image, ax=axes, shrink=0.6, label="share of the variance")
    return figure


def render_study(
    study: "MonteCarloResult", found: "InfluenceResult | None", worst: "SearchResult | None"
) -> Iterator[tuple[str, bytes]]:
    """Yield (file name, content) of a study's figures as PNG and as SVG."""
    figures = {"figure_band": band_figure(study, worst)}
    if found is not None:
        figures |= {
            "figure_influence": bars_figure(found),
            "figure_influence_map": map_figure(found),
        }
    yield from render(figures)

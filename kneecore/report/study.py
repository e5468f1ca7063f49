"""Studies for people: tables for terminals and notebooks."""

from typing import TYPE_CHECKING

import numpy as np
from rich.text import Text

from kneecore.knee.response import MOMENT
from kneecore.report.tables import render, table

if TYPE_CHECKING:
    from kneecore.study.comparison import Comparison
    from kneecore.study.influence import InfluenceResult
    from kneecore.study.monte_carlo import MonteCarloResult

_ORDER = np.argsort(-MOMENT)


def monte_carlo_report(study: "MonteCarloResult") -> str:
    """Return a Monte-Carlo study as text."""
    rows = table(
        "Flexion angle, deg",
        "moment N m",
        "mean",
        "sd",
        "mean - 3 sd",
        "mean + 3 sd",
        "0.15 %",
        "99.85 %",
    )
    spread = study.flexion_deg
    columns = (
        spread.mean,
        spread.sd,
        spread.sigma_lower,
        spread.sigma_upper,
        spread.percentile_lower,
        spread.percentile_upper,
    )
    for k in _ORDER:
        rows.add_row(f"{MOMENT[k]:+g}", *(f"{column[k]:.2f}" for column in columns))
    cut = " (cancelled)" if study.stop_reason == "cancelled" else ""
    drawn = "sobol, rounded up to a power of two" if study.sampling == "sobol" else study.sampling
    footer = (
        f"{study.n_samples:,} samples{cut} ({drawn}, seed {study.seed}): "
        f"{study.n_failed} failed, {study.n_refined} refined, {study.n_unsettled} with an "
        f"unsettled load; {study.seconds['sampling']:.2f} s.\n"
        f"Baseline: {study.space.title}. {study.space.note or ''}"
    )
    return render([rows, Text(footer.rstrip())])


def influence_report(found: "InfluenceResult", count: int = 10) -> str:
    """Return the largest indices at the largest moments, and the groups, as text."""
    parts: list[object] = [Text(found.answer(5.0)), Text(found.answer(-5.0)), Text("")]
    for moment in (5.0, -5.0):
        load = int(np.argmin(np.abs(MOMENT - moment)))
        rows = table(
            f"Sobol' indices at {moment:+g} N m (95 % interval)",
            "parameter",
            "first order",
            "total",
        )
        for name in found.deciding(moment, count):
            k = found.names.index(name)
            rows.add_row(
                name,
                _with_interval(
                    found.indices.first_order, found.indices.first_order_interval, load, k
                ),
                _with_interval(
                    found.indices.total_order, found.indices.total_order_interval, load, k
                ),
            )
        parts.append(rows)
    groups = table("First-order indices summed by group", "moment N m", *found.groups)
    for k in _ORDER:
        groups.add_row(f"{MOMENT[k]:+g}", *(f"{v[k]:.3f}" for v in found.groups.values()))
    parts.append(groups)
    used = found.indices
    parts.append(
        Text(
            f"{used.n_base} base rows (a power of two), {used.n_evaluations:,} models, "
            f"{used.n_failed_rows} rows replaced since a model failed; "
            f"{found.seconds['total']:.2f} s.\n"
            f"Baseline: {found.space.title}. {found.space.note or ''}".rstrip()
        )
    )
    return render(parts)  # type: ignore[arg-type]


def _with_interval(values: object, interval: object, load: int, k: int) -> str:
    value = np.asarray(values)[load, k]
    if interval is None:
        return f"{value:.3f}"
    low, high = np.asarray(interval)[:, load, k]
    return f"{value:.3f} ({low:.3f} to {high:.3f})"


def comparison_report(found: "Comparison") -> str:
    """Return how far a worst case lies outside of the sampled band, as text."""
    rows = table(
        "Worst case outside of the 99.7 % band",
        "moment N m",
        "model 1, deg (of its width)",
        "model 2, deg (of its width)",
    )
    for k in _ORDER:
        cells = [
            f"{found.excess_deg[m, k]:.2f} ({100.0 * found.excess_share[m, k]:.0f} %)"
            for m in (0, 1)
        ]
        rows.add_row(f"{MOMENT[k]:+g}", *cells)
    return render([rows])

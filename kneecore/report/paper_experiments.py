"""What the report says of the computations themselves: searches, samples, figures, influence."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kneecore.figures.paper import CAPTIONS, INFLUENCE_FIGURE
from kneecore.knee.extension import extension_difference_percent
from kneecore.knee.parameters import LIGAMENTS
from kneecore.knee.response import LARGEST_EXTENSION, LARGEST_FLEXION, MOMENT
from kneecore.paper.experiments import Experiments
from kneecore.paper.geometry_changes import ATTACHMENTS, GeometryChange, geometry_changes
from kneecore.paper.measures.knees import ap_slopes
from kneecore.paper.verdict import shown
from kneecore.report.blocks import Block, Heading, Paragraph, Picture, Table
from kneecore.report.influence import answer
from kneecore.search.result import MODELS, SearchResult

__all__ = ["figures", "influence", "sampling", "searches"]


def _search_row(name: str, run: SearchResult) -> tuple[str, ...]:
    def text(value: float | None) -> str:
        return "-" if value is None else f"{value:.2f}"

    true = "failed" if run.objective_model is None else f"{run.objective_model:.2f}"
    exact = run.settings.method == "exact"
    return (
        name,
        "climbs" if exact else f"{run.settings.pop_size} x {run.settings.n_generations}",
        str(run.settings.seed),
        text(run.objective_surrogate),
        true,
        text(run.gap_percent),
        text(extension_difference_percent(run.responses)),
        str(run.counts["models_failed"]),
        f"{run.seconds['search']:.3g}",
    )


def searches(done: Experiments) -> list[Block]:
    """Return each search with its values."""
    rows = [_search_row(f"{case}, surrogate", run) for case, run in done.cases.items()]
    rows += [_search_row("both, surrogate, again", run) for run in done.repeats[1:]]
    rows += [_search_row("geometry, surrogate, again", run) for run in done.geometry_repeats[1:]]
    rows += [_search_row(f"{case}, exact, true model", run) for case, run in done.exact.items()]
    rows += [_search_row("both, surrogate, for comparison", run) for run in done.surrogate_runs]
    rows += [_search_row("both, true model", run) for run in done.model_runs]
    rows += [_search_row("both, surrogate, twice the knees", run) for run in done.larger_runs]
    columns = (
        "search",
        "pairs x generations",
        "seed",
        "f surrogate, deg",
        "f true model, deg",
        "gap, %",
        "extension difference, %",
        "failed models",
        "time, s",
    )
    return [Heading("Searches"), Table(columns, rows)]


def sampling(done: Experiments) -> list[Block]:
    """Return what the samples say."""
    drawn = done.sampling
    spread = drawn.y
    rows = [
        (f"{MOMENT[k]:+g}",)
        + tuple(
            f"{column[k]:.2f}"
            for column in (spread.mean, spread.sd, spread.sigma_lower, spread.sigma_upper)
        )
        for k in np.argsort(-MOMENT)
    ]
    columns = ("moment, N m", "mean, deg", "sd, deg", "mean - 3 sd, deg", "mean + 3 sd, deg")
    return [
        Heading("Sampling"),
        Paragraph(
            f"{drawn.n_samples:,} uniform samples of the true model: {drawn.n_failed} failed and "
            f"left out, {drawn.counts['refined']} with a smaller time step, "
            f"{drawn.counts['unsettled']:,} unsettled at some load."
        ),
        Table(columns, rows),
    ]


def figures(done: Experiments) -> list[Block]:
    """Return the figures but the last, each with its numbers."""
    blocks: list[Block] = [Heading("Figures")]
    for name, caption in CAPTIONS.items():
        if name == INFLUENCE_FIGURE:
            continue
        blocks.append(Picture(f"{name}.png", caption))
        if name == "figure_2_geometry":
            blocks += _figure_2(done)
        if name == "figure_4_ap_displacement":
            blocks += _figure_4(done.main)
    return blocks


def _figure_2(done: Experiments) -> list[Block]:
    blocks: list[Block] = [
        Heading("Figure 2 in numbers", level=3),
        Paragraph(
            "Each worst case less the baseline, in the load-free pose and in the femur's frame: "
            "shifts along the baseline's plateau (anterior > 0) and across it (proximal > 0). The "
            "tibia's attachments move with the tibia too, which moves until the circle just "
            "touches the plateau. Last, what becomes of f when one stiffness is turned round."
        ),
    ]
    named = (("The exact optimum.", done.exact["both"], 0), ("The surrogate's pair.", done.main, 1))
    for title, worst, pair in named:
        changes = geometry_changes(worst)
        blocks += [Paragraph(title), _shifts(changes), _lines(changes, done.turned_percent[pair])]
    return blocks


def _shifts(changes: Sequence[GeometryChange]) -> Table:
    rows = [
        (
            _attachment(name),
            *(f"{value:+.2f}" for c in changes for value in (c.along_mm[k], c.across_mm[k])),
        )
        for k, name in enumerate(ATTACHMENTS)
    ]
    circle = [f"{v:+.2f}" for c in changes for v in (c.circle_along_mm, c.circle_across_mm)]
    columns = (
        "place",
        "model 1 along, mm",
        "model 1 across, mm",
        "model 2 along, mm",
        "model 2 across, mm",
    )
    return Table(columns, [*rows, ("circle's centre", *circle)])


def _lines(changes: Sequence[GeometryChange], turned: NDArray[np.float64]) -> Table:
    rows = [
        (name.upper(), *_line_cells(changes, k), *(f"{value:+.2f}" for value in turned[:, k]))
        for k, name in enumerate(LIGAMENTS)
    ]
    slopes = [cell for change in changes for cell in (f"{change.slope_deg:+.2f}", "-")]
    columns = (
        "line",
        "model 1 turned by, deg",
        "model 1 stiffness, %",
        "model 2 turned by, deg",
        "model 2 stiffness, %",
        "f with model 1's turned round, %",
        "f with model 2's turned round, %",
    )
    return Table(columns, [*rows, ("plateau", *slopes, "-", "-")])


def _attachment(name: str) -> str:
    ligament, bone = name.split("_")
    return f"{ligament.upper()}, {bone}"


def _line_cells(changes: Sequence[GeometryChange], k: int) -> list[str]:
    return [
        text
        for change in changes
        for text in (f"{change.angle_deg[k]:+.2f}", f"{change.stiffness_percent[k]:+.1f}")
    ]


def _figure_4(worst: SearchResult) -> list[Block]:
    rows = []
    for name in MODELS:
        response = worst.responses[name]
        before, beyond = ap_slopes(response)
        if response.status == "failed":
            cells = ("failed", "failed", "-")
        else:
            cells = (f"{before:.3f}", f"{beyond:.3f}", shown(beyond / before))
        rows.append((name.replace("_", " "), *cells))
    columns = ("knee", "before 54.79 deg, mm/deg", "beyond, mm/deg", "ratio")
    return [Heading("Figure 4 in numbers", level=3), Table(columns, rows)]


def influence(done: Experiments) -> list[Block]:
    """Return which parameters decide."""
    found = done.influence
    return [
        Heading("Which parameters decide"),
        Paragraph(
            "A worst case does not tell which parameters matter most. Sobol' indices of the true "
            f"model do: {answer(found, LARGEST_EXTENSION)} {answer(found, LARGEST_FLEXION)} "
            f"({found.indices.n_evaluations:,} models.)"
        ),
        Picture(f"{INFLUENCE_FIGURE}.png", CAPTIONS[INFLUENCE_FIGURE]),
    ]

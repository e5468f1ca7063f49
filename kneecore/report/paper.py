"""What the report says: blocks made of verdicts and experiments."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kneecore.figures.paper import CAPTIONS, INFLUENCE_FIGURE
from kneecore.knee.parameters import LIGAMENTS
from kneecore.knee.space import ParameterSpace
from kneecore.paper.geometry_changes import ATTACHMENTS, GeometryChange, geometry_changes
from kneecore.paper.measures import ap_slopes
from kneecore.paper.verdict import Verdict, shown
from kneecore.report.blocks import Block, Heading, Paragraph, Picture, Table
from kneecore.search.result import SearchResult

if TYPE_CHECKING:
    from kneecore.paper.redo import PaperReport

__all__ = ["TIMES", "report_blocks", "verdict_sentences"]

TIMES = ("time_main", "time_surrogate", "time_model", "orders_of_magnitude", "time_sampling")
"""Claims about times: their values change from run to run."""
_COLUMNS = ("claim", "section", "the paper", "ours", "verdict", "evidence", "why")


def verdict_sentences(report: "PaperReport") -> tuple[str, str]:
    """Return how many claims hold, and how many of those the baseline was not fitted to."""
    n = {outcome: len(report.by_outcome(outcome)) for outcome in ("agrees", "differs")}
    total = len(report.verdicts)
    rest = total - n["agrees"] - n["differs"]
    free = [v for v in report.verdicts if v.claim.evidence == "not fitted"]
    agree = sum(v.outcome == "agrees" for v in free)
    differ = sum(v.outcome == "differs" for v in free)
    return (
        f"Of {total} claims {n['agrees']} agree, {n['differs']} differ and {rest} cannot be "
        "compared.",
        f"Of those that the packaged baseline was not fitted to, {agree} agree and {differ} "
        "differ; only these are evidence.",
    )


def report_blocks(report: "PaperReport") -> list[Block]:
    """Return the whole report."""
    return [
        *_opening(report),
        *_verdicts(report.verdicts),
        *_searches(report),
        *_times(report),
        *_sampling(report),
        *_figures(report),
        *_influence(report),
    ]


def _opening(report: "PaperReport") -> list[Block]:
    reference = report.paper.reference
    space = report.experiments.space
    blocks: list[Block] = [
        Heading("The paper, claim by claim", level=1),
        Paragraph(
            f"{reference['authors']}, {reference['title']}, {reference['journal']}, "
            f"doi {reference['doi']}, computed again by kneecore "
            f"{report.experiments.main.versions['kneecore']} (seed {report.experiments.seed}). "
            f"{_bounds(space)}"
        ),
        Paragraph(f"Baseline: {space.title}. {space.note or ''}".rstrip(), warning=True),
    ]
    if report.quick:
        blocks.append(
            Paragraph(
                "A quick run: smaller searches and fewer samples than the paper's. Its verdicts "
                "are a preview, and times of the paper's sizes are not measured; "
                "python -m kneecore.paper without --quick gives those that count.",
                warning=True,
            )
        )
    return [*blocks, Paragraph(" ".join(verdict_sentences(report)))]


def _bounds(space: ParameterSpace) -> str:
    """Return by how much the parameters vary."""
    if space.half_ranges is not None:
        return f"{space.n_free} parameters vary, by the half-ranges of their knee file."
    rest = ""
    if space.rest_length_bound_mm > 0.0:
        rest = f", the rest lengths by {space.rest_length_bound_mm:g} mm"
    elif space.rest_length_bound_percent > 0.0:
        rest = f", the rest lengths by {space.rest_length_bound_percent:g} %"
    return (
        f"{space.n_free} parameters vary: lengths and coordinates by "
        f"{space.geometry_bound_mm:g} mm, the plateau's slope by {space.slope_bound_deg:g} deg, "
        f"the material by {space.material_bound_percent:g} %{rest}."
    )


def _verdicts(verdicts: Sequence[Verdict]) -> list[Block]:
    rows = [
        (
            v.claim.statement,
            v.claim.section,
            v.claim.paper,
            v.ours,
            v.outcome,
            v.claim.evidence,
            v.why,
        )
        for v in verdicts
    ]
    return [
        Heading("Verdicts"),
        Table(_COLUMNS, rows, marked=_COLUMNS.index("verdict")),
        Paragraph(
            "Evidence: fitted - the packaged baseline was fitted to this claim, so that agreeing "
            "tells nothing; related - not a target of the fit, but close to one; not fitted - "
            "agreeing is evidence. All angles, forces and positions are the true model's; the "
            "surrogate's f stands only beside the true one. Model 1 is the knee that over-extends, "
            "model 2 the one that cannot extend."
        ),
    ]


def _search_row(name: str, run: SearchResult) -> tuple[str, ...]:
    def text(value: float | None) -> str:
        return "-" if value is None else f"{value:.2f}"

    true = "failed" if run.objective_model is None else f"{run.objective_model:.2f}"
    return (
        name,
        f"{run.pop_size} x {run.n_generations}",
        str(run.seed),
        text(run.objective_surrogate),
        true,
        text(run.gap_percent),
        text(run.extension_difference_percent),
        str(run.counts["models_failed"]),
        f"{run.seconds['search']:.3g}",
    )


def _searches(report: "PaperReport") -> list[Block]:
    done = report.experiments
    rows = [_search_row(f"{case}, surrogate", run) for case, run in done.cases.items()]
    rows += [_search_row("both, surrogate, again", run) for run in done.repeats[1:]]
    rows += [_search_row("both, surrogate, for comparison", run) for run in done.surrogate_runs]
    rows += [_search_row("both, true model", run) for run in done.model_runs]
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


def _times(report: "PaperReport") -> list[Block]:
    by_id = {v.claim.id: v for v in report.verdicts}
    rows = [(v.claim.statement, v.claim.paper, v.ours) for v in map(by_id.__getitem__, TIMES)]
    machine = report.paper.reference["machine"]
    return [
        Heading("Times"),
        Table(("what", f"the paper: {machine}", f"ours: {report.machine}"), rows),
        Paragraph(
            "Ours are the optimisation, or the sampling, alone: the median of the searches, "
            "compilation excluded. The whole run took "
            f"{report.seconds:.1f} s, compilation included. Machines and programs differ: "
            "the times are set side by side, not judged."
        ),
    ]


def _sampling(report: "PaperReport") -> list[Block]:
    drawn = report.experiments.sampling
    spread = drawn.flexion_deg
    order = np.argsort(-report.experiments.main.baseline.moment)
    rows = [
        (f"{report.experiments.main.baseline.moment[k]:+g}",)
        + tuple(
            f"{column[k]:.2f}"
            for column in (spread.mean, spread.sd, spread.sigma_lower, spread.sigma_upper)
        )
        for k in order
    ]
    columns = ("moment, N m", "mean, deg", "sd, deg", "mean - 3 sd, deg", "mean + 3 sd, deg")
    return [
        Heading("Sampling"),
        Paragraph(
            f"{drawn.n_samples:,} uniform samples of the true model: {drawn.n_failed} failed and "
            f"left out, {drawn.n_refined} with a smaller time step, {drawn.n_unsettled:,} not at "
            "rest at some load."
        ),
        Table(columns, rows),
    ]


def _figures(report: "PaperReport") -> list[Block]:
    blocks: list[Block] = [Heading("Figures")]
    for name, caption in CAPTIONS.items():
        if name == INFLUENCE_FIGURE:
            continue
        blocks.append(Picture(f"{name}.png", caption))
        if name == "figure_2_geometry":
            blocks += _figure_2(report.experiments.main)
        if name == "figure_4_ap_displacement":
            blocks += _figure_4(report.experiments.main)
    return blocks


def _figure_2(worst: SearchResult) -> list[Block]:
    changes = geometry_changes(worst)
    points = [
        (
            _attachment(name),
            *(f"{value:+.2f}" for c in changes for value in (c.along_mm[k], c.across_mm[k])),
        )
        for k, name in enumerate(ATTACHMENTS)
    ]
    lines = [(name.upper(), *_line_cells(changes, k)) for k, name in enumerate(LIGAMENTS)]
    return [
        Heading("Figure 2 in numbers", level=3),
        Paragraph(
            "Each worst case less the baseline, in the load-free pose and in the femur's frame: "
            "shifts along the baseline's plateau (anterior > 0) and across it (proximal > 0). The "
            "tibia's attachments move with the tibia too, which moves until the circle just "
            "touches the plateau."
        ),
        Table(
            (
                "attachment",
                "model 1 along, mm",
                "model 1 across, mm",
                "model 2 along, mm",
                "model 2 across, mm",
            ),
            points,
        ),
        Table(
            (
                "ligament",
                "model 1 turned by, deg",
                "model 1 stiffness, %",
                "model 2 turned by, deg",
                "model 2 stiffness, %",
            ),
            lines,
        ),
    ]


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
    for name, response in worst.models.items():
        before, beyond = ap_slopes(response)
        if response.status == "failed":
            cells = ("failed", "failed", "-")
        else:
            cells = (f"{before:.3f}", f"{beyond:.3f}", shown(beyond / before))
        rows.append((name.replace("_", " "), *cells))
    columns = ("knee", "before 54.79 deg, mm/deg", "beyond, mm/deg", "ratio")
    return [Heading("Figure 4 in numbers", level=3), Table(columns, rows)]


def _influence(report: "PaperReport") -> list[Block]:
    found = report.experiments.influence
    return [
        Heading("Which parameters decide"),
        Paragraph(
            "A worst case does not tell which parameters matter most. Sobol' indices of the true "
            f"model do: {found.answer(5.0)} {found.answer(-5.0)} "
            f"({found.indices.n_evaluations:,} models.)"
        ),
        Picture(f"{INFLUENCE_FIGURE}.png", CAPTIONS[INFLUENCE_FIGURE]),
    ]

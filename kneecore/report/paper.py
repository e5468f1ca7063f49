"""The paper claim by claim, for people: verdicts, times, and what was computed for them."""

from collections.abc import Mapping, Sequence

from rich.text import Text

from kneecore.figures.paper import draw
from kneecore.figures.style import render
from kneecore.knee.space import ParameterSpace
from kneecore.paper.claims import packaged_paper
from kneecore.paper.result import Documents, PaperReport
from kneecore.paper.verdict import OUTCOMES, Outcome, Verdict
from kneecore.report import paper_experiments as told
from kneecore.report import tables
from kneecore.report.blocks import (
    Block,
    Heading,
    Paragraph,
    Picture,
    Table,
    to_html,
    to_markdown,
)

__all__ = ["TIMES", "WORDS", "markdown", "page", "report_blocks"]

TIMES = (
    "time_main",
    "time_surrogate",
    "time_model",
    "orders_of_magnitude",
    "time_sampling",
    "more_training_slower",
)
"""Claims about times: their values change from run to run."""
_COLUMNS = ("claim", "section", "the paper", "ours", "verdict", "fit", "why")


def verdict_sentences(report: PaperReport) -> tuple[str, str]:
    """Return how many claims hold, and how many of those the baseline was not fitted to."""
    n = {outcome: len(report.by_outcome(outcome)) for outcome in OUTCOMES}
    free = report.not_fitted
    held = {outcome: sum(v.outcome == outcome for v in free) for outcome in OUTCOMES}
    return (
        f"Of {len(report.verdicts)} claims {_counted(n)} and {n['cannot be compared']} cannot be "
        "compared.",
        f"Of the {len(free)} that the packaged baseline was not fitted to and that can be "
        f"compared, {_counted(held, last=' and ')}; only these are evidence.",
    )


def _counted(n: Mapping[Outcome, int], *, last: str = ", ") -> str:
    """Return how many agree and differ, and how many are indifferent if any are."""
    parts = [f"{n['agrees']} agree", f"{n['differs']} differ"]
    if n["indifferent"]:
        parts.append(f"{n['indifferent']} {'is' if n['indifferent'] == 1 else 'are'} indifferent")
    return last.join([", ".join(parts[:-1]), parts[-1]])


def _other_list(report: PaperReport) -> str:
    """Say so if the report judges another list of claims than this version has; empty if not."""
    ours, theirs = len(packaged_paper().claims), len(report.verdicts)
    if {v.claim.id for v in report.verdicts} == {c.id for c in packaged_paper().claims}:
        return ""
    return (
        f"This report judges {theirs} claims by an older or newer list; this version of kneecore "
        f"has {ours}. Run python -m kneecore.paper again to judge those."
    )


def report_blocks(report: PaperReport, *, figures: bool = True) -> list[Block]:
    """Return the whole report; one that was read from a file is verdicts and times alone."""
    done = report.experiments
    blocks = [*_opening(report), *_verdicts(report.verdicts)]
    if done is None:
        return [*blocks, *_times(report)]
    blocks += [*told.searches(done), *_times(report), *told.sampling(done)]
    blocks += [*told.figures(done), *told.influence(done)]
    return [block for block in blocks if figures or not isinstance(block, Picture)]


def _opening(report: PaperReport) -> list[Block]:
    reference = report.paper.reference
    done = report.experiments
    bounds = "" if done is None else _bounds(done.knee.space)
    blocks: list[Block] = [
        Heading("The paper, claim by claim", level=1),
        Paragraph(
            f"{reference['authors']}, {reference['title']}, {reference['journal']}, "
            f"doi {reference['doi']}, computed again by kneecore "
            f"{report.versions['kneecore']} (seed {report.seed}). {bounds}".rstrip()
        ),
        Paragraph(_baseline(report), warning=True),
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
    if other := _other_list(report):
        blocks.append(Paragraph(other, warning=True))
    return [*blocks, Paragraph(" ".join(verdict_sentences(report)))]


def _baseline(report: PaperReport) -> str:
    return f"Baseline: {report.title}. {report.note or ''}".rstrip()


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
            v.claim.place,
            v.claim.paper,
            v.ours,
            v.outcome,
            v.claim.fit,
            v.why,
        )
        for v in verdicts
    ]
    return [
        Heading("Verdicts"),
        Table(_COLUMNS, rows, marked=_COLUMNS.index("verdict")),
        Paragraph(
            "Fit: fitted - the packaged baseline was fitted to this claim, so that agreeing tells "
            "nothing; related - not a target of the fit, but close to one; not fitted - agreeing "
            "is evidence. Indifferent - what speaks against the claim hardly moves f. Where "
            "worst-case pairs are looked at, a claim has to hold for that of the exact search and "
            "for those of more than half of the seeds. All angles, forces and positions are the "
            "true model's; the surrogate's f stands only beside the true one. Model 1 is the knee "
            "that over-extends, "
            "model 2 the one that cannot extend."
        ),
    ]


def _times(report: PaperReport) -> list[Block]:
    by_id = {v.claim.id: v for v in report.verdicts}
    found = [by_id[name] for name in TIMES if name in by_id]  # a file may tell of other claims
    rows = [(v.claim.statement, v.claim.paper, v.ours) for v in found]
    machine = report.paper.reference["machine"]
    return [
        Heading("Times"),
        Table(("what", f"the paper: {machine}", f"ours: {report.machine}"), rows),
        Paragraph(
            "Ours are the optimisation, or the sampling, alone: the median of the searches, "
            "compilation excluded. The whole run took "
            f"{report.seconds:.1f} s, compilation included. Machines and programs differ: "
            "seconds are set side by side, not judged."
        ),
    ]


def markdown(report: PaperReport, *, figures: bool = True) -> str:
    """Return the report as Markdown."""
    return to_markdown(report_blocks(report, figures=figures))


def page(report: PaperReport, pictures: Mapping[str, bytes]) -> str:
    """Return the report as one HTML page with these pictures, or without any, inside."""
    blocks = report_blocks(report, figures=bool(pictures))
    return to_html("The paper, claim by claim", blocks, pictures)


def _page(report: PaperReport) -> str:
    return page(report, dict(render(draw(report), ("png",))))


def _text(report: PaperReport, *, html: bool = False) -> str:
    rows = tables.table("The paper, claim by claim", "claim", "paper", "ours", "verdict", "fit")
    for column, width in zip(rows.columns, (30, 12, 16, 18, 10), strict=True):
        column.no_wrap, column.width = False, width
    rows.columns[3].justify = rows.columns[4].justify = "left"
    for v in report.verdicts:
        rows.add_row(v.claim.statement, v.claim.paper, v.ours, v.outcome, v.claim.fit)
    quick = "Quick: smaller searches and fewer samples than the paper's.\n" * report.quick
    below = (
        "\n".join(verdict_sentences(report))
        + f"\n{quick}{report.machine}; {report.seconds:.1f} s.\n"
        + _baseline(report)
        + f"\n{_other_list(report)}".rstrip()
    )
    return tables.render([rows, Text(below)], html=html)


def _html(report: PaperReport) -> str:
    return _text(report, html=True)


WORDS = Documents(
    summary=lambda report: " ".join(verdict_sentences(report)),
    text=_text,
    html=_html,
    markdown=markdown,
    page=_page,
)

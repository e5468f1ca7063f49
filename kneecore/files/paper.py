"""The paper's report as files: `paper.json`, and beside it all that a reader wants."""

from collections.abc import Iterator
from typing import Any, get_args

from kneecore._arguments import choice, flag, text
from kneecore.figures import paper as figures_of_paper
from kneecore.figures.style import render
from kneecore.files.folder import to_json
from kneecore.files.model import array, number_or_none
from kneecore.files.origin import read_versions
from kneecore.files.study import STUDY_FILE, Study
from kneecore.numbers import plain
from kneecore.numerics.sampling_options import check_seed
from kneecore.paper.claims import Claim, Fit, Paper, Rule
from kneecore.paper.experiments import Experiments
from kneecore.paper.result import PaperReport
from kneecore.paper.verdict import OUTCOMES, Verdict
from kneecore.presented import Format
from kneecore.report.paper import markdown, page
from kneecore.study.comparison import compare_with_sampling

__all__ = ["FORMAT"]

_REFERENCE = ("authors", "title", "journal", "doi", "machine")
_LONGEST = 10_000
"""Characters of a text that is read back."""
_COMPUTED = ("searches", "sampling")


def to_dict(report: PaperReport) -> dict[str, Any]:
    """Return the verdicts and what they rest on as JSON-ready values."""
    return {
        "schema": FORMAT.schema,
        "paper": dict(report.paper.reference),
        "quick": report.quick,
        "seed": report.seed,
        "baseline": {"title": report.title, "note": report.note},
        "claims": [_verdict_table(verdict) for verdict in report.verdicts],
        "n_failed": dict(report.n_failed),
        "versions": dict(report.versions),
        "machine": report.machine,
        "seconds": {"total": round(report.seconds, 6)},
    }


def _verdict_table(verdict: Verdict) -> dict[str, Any]:
    claim = verdict.claim
    return {
        "id": claim.id,
        "section": claim.section,
        # Earlier files name no figure; what they lack is not made up.
        **({"figure": claim.figure} if claim.figure else {}),
        "statement": claim.statement,
        "paper": claim.paper,
        "rule": claim.rule,
        "limit": claim.limit,
        "tolerance": claim.tolerance,
        "ours": plain(verdict.values),
        "unit": claim.unit,
        "outcome": verdict.outcome,
        "why": verdict.why,
        "evidence": claim.fit,
    }


def from_dict(document: dict[str, Any]) -> PaperReport:
    """Return the report that `to_dict` has told, without the experiments."""
    verdicts = tuple(_read_verdict(table) for table in document["claims"])
    reference = document["paper"]
    baseline = document["baseline"]
    versions = {"kneecore": str(document["versions"]["kneecore"])} | read_versions(document)
    return PaperReport(
        paper=Paper(
            reference={key: _text(reference, key) for key in _REFERENCE},
            claims=tuple(verdict.claim for verdict in verdicts),
        ),
        verdicts=verdicts,
        quick=flag("quick", document["quick"]),
        seed=check_seed(document["seed"]),
        title=_text(baseline, "title"),
        note=None if baseline["note"] is None else _text(baseline, "note"),
        n_failed={name: int(document["n_failed"][name]) for name in _COMPUTED},
        machine=_text(document, "machine"),
        seconds=float(document["seconds"]["total"]),
        versions=versions,
        experiments=None,
    )


def _text(table: dict[str, Any], key: str) -> str:
    return text(key, table[key], _LONGEST)


def _read_verdict(table: dict[str, Any]) -> Verdict:
    claim = Claim(
        id=_text(table, "id"),
        section=_text(table, "section"),
        figure=_text(table, "figure") if "figure" in table else "",
        statement=_text(table, "statement"),
        paper=_text(table, "paper"),
        measure="",
        unit=_text(table, "unit"),
        rule=choice("rule", table["rule"], get_args(Rule)),
        fit=choice("evidence", table["evidence"], get_args(Fit)),
        limit=number_or_none(table, "limit"),
        tolerance=number_or_none(table, "tolerance"),
    )
    return Verdict(
        claim=claim,
        values=array(table["ours"], (-1,), "ours"),
        outcome=choice("outcome", table["outcome"], OUTCOMES),
        why=_text(table, "why"),
    )


def others(report: PaperReport, figures: bool) -> Iterator[tuple[str, bytes]]:
    """Yield (file name, content) of all but `paper.json`."""
    drawn = figures_of_paper.draw(report) if figures else {}
    pictures = dict(render(drawn, ("png",)))
    yield "paper.md", markdown(report, figures=figures).encode()
    yield "paper.html", page(report, pictures).encode()
    yield from pictures.items()
    yield from render(drawn, ("svg",))
    if report.experiments is not None:
        yield from _experiments(report.experiments)


def _experiments(done: Experiments) -> Iterator[tuple[str, bytes]]:
    for case, run in done.cases.items():
        yield f"result_{case}.json", run.to_json().encode()
    study = Study(
        sampled=done.sampling,
        worst=done.main,
        comparison=compare_with_sampling(done.main, done.sampling),
        influence=done.influence,
    )
    yield STUDY_FILE, to_json(study.to_dict()).encode()


FORMAT = Format(
    schema="kneecore.paper/1",
    file="paper.json",
    to_dict=to_dict,
    from_dict=from_dict,
    others=others,
    stale=tuple(
        f"{name}.{ending}" for name in figures_of_paper.CAPTIONS for ending in ("png", "svg")
    ),
)

"""The paper's report as files: `paper.json`, and beside it all that a reader wants."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from kneecore.errors import FileFormatError
from kneecore.figures import paper as figures_of_paper
from kneecore.figures.style import render
from kneecore.files.folder import to_json
from kneecore.files.study import STUDY_FILE, Study
from kneecore.numbers import plain
from kneecore.paper.claims import Claim, Paper
from kneecore.paper.experiments import Experiments
from kneecore.paper.result import PaperReport
from kneecore.paper.verdict import OUTCOMES, Verdict
from kneecore.presented import Format
from kneecore.report.paper import markdown, page
from kneecore.study.comparison import compare_with_sampling

__all__ = ["FORMAT"]

_REFERENCE = ("authors", "title", "journal", "doi", "machine")
_SAID = ("id", "section", "statement", "paper", "rule", "limit", "tolerance", "unit", "evidence")
"""What is kept of a claim."""


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
        "statement": claim.statement,
        "paper": claim.paper,
        "rule": claim.rule,
        "limit": claim.limit,
        "tolerance": claim.tolerance,
        "ours": plain(verdict.values),
        "unit": claim.unit,
        "outcome": verdict.outcome,
        "why": verdict.why,
        "evidence": claim.evidence,
    }


def from_dict(document: dict[str, Any]) -> PaperReport:
    """Return the report that `to_dict` has told, without the experiments."""
    verdicts = tuple(_read_verdict(table) for table in document["claims"])
    return PaperReport(
        paper=Paper(
            reference={key: str(document["paper"][key]) for key in _REFERENCE},
            claims=tuple(verdict.claim for verdict in verdicts),
        ),
        verdicts=verdicts,
        quick=_true_or_false(document, "quick"),
        seed=int(document["seed"]),
        title=str(document["baseline"]["title"]),
        note=document["baseline"]["note"],
        n_failed={str(key): int(value) for key, value in document["n_failed"].items()},
        machine=str(document["machine"]),
        seconds=float(document["seconds"]["total"]),
        versions={
            "kneecore": str(document["versions"]["kneecore"]),
            **{str(key): str(value) for key, value in document["versions"].items()},
        },
        experiments=None,
    )


def _true_or_false(document: dict[str, Any], key: str) -> bool:
    value = document[key]
    if not isinstance(value, bool):
        raise FileFormatError(f"`{key}` is {value!r}; true or false is allowed")
    return value


def _read_verdict(table: dict[str, Any]) -> Verdict:
    if table["outcome"] not in OUTCOMES:
        raise FileFormatError(
            f"`outcome` is {table['outcome']!r}; {', '.join(OUTCOMES)} are allowed"
        )
    values = [np.nan if value is None else float(value) for value in table["ours"]]
    return Verdict(
        claim=Claim(measure="", **{name: table[name] for name in _SAID}),
        values=np.array(values),
        outcome=table["outcome"],
        why=str(table["why"]),
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

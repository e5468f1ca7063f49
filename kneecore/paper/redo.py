"""The paper redone: run it, judge it, and say it as Markdown, HTML, JSON or a table.

Examples
--------
>>> import kneecore
>>> report = kneecore.redo_paper(quick=True)
>>> {verdict.outcome for verdict in report.verdicts} <= {"agrees", "differs", "cannot be compared"}
True
"""

import json
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from matplotlib.figure import Figure
from rich.text import Text

from kneecore._threads import thread_count
from kneecore.errors import ParameterError
from kneecore.figures.paper import paper_figures
from kneecore.figures.search import render
from kneecore.files.study import STUDY_FILE, Study
from kneecore.knee.space import ParameterSpace
from kneecore.numerics.sampling import check_seed
from kneecore.paper.claims import Paper, packaged_paper
from kneecore.paper.experiments import (
    PAPER_BUDGET,
    QUICK_BUDGET,
    Experiments,
    run_experiments,
)
from kneecore.paper.machine import machine_name
from kneecore.paper.verdict import Outcome, Verdict, judge_all
from kneecore.progress import Callback
from kneecore.report import tables
from kneecore.report.blocks import Block, to_html, to_markdown
from kneecore.report.paper import report_blocks, verdict_sentences
from kneecore.study.comparison import compare_with_sampling

__all__ = ["REPORT_FILE", "PaperReport", "redo_paper"]

REPORT_FILE = "paper.json"
SCHEMA = "kneecore.paper/1"


@dataclass(frozen=True, kw_only=True, eq=False)
class PaperReport:
    """The paper's claims judged by a knee's own computations."""

    paper: Paper
    experiments: Experiments
    verdicts: tuple[Verdict, ...]
    """One for each claim, in the order of the list."""
    quick: bool
    """Whether the budgets were smaller than the paper's."""
    machine: str
    """Where it was computed."""
    seconds: float
    """Wall time of the whole computation."""

    def by_outcome(self, outcome: Outcome) -> tuple[Verdict, ...]:
        """Return the verdicts with an outcome."""
        return tuple(v for v in self.verdicts if v.outcome == outcome)

    @cached_property
    def blocks(self) -> list[Block]:
        """The report's content, the same for Markdown and HTML."""
        return report_blocks(self)

    @cached_property
    def figures(self) -> dict[str, Figure]:
        """The figures by file name without an ending; drawn when first asked for."""
        return paper_figures(self.experiments)

    @cached_property
    def pictures(self) -> dict[str, bytes]:
        """The figures as PNG by file name."""
        return dict(render(self.figures, ("png",)))

    def markdown(self) -> str:
        """Return the report as Markdown; its figures are files beside it."""
        return to_markdown(self.blocks)

    def html(self) -> str:
        """Return the report as one HTML page with its figures inside."""
        return to_html("The paper, claim by claim", self.blocks, self.pictures)

    def to_dict(self) -> dict[str, Any]:
        """Return verdicts and what they rest on as JSON-ready values."""
        done = self.experiments
        return {
            "schema": SCHEMA,
            "paper": dict(self.paper.reference),
            "quick": self.quick,
            "seed": done.seed,
            "baseline": {"title": done.space.title, "note": done.space.note},
            "claims": [verdict.to_dict() for verdict in self.verdicts],
            "n_failed": {
                "searches": sum(run.counts["models_failed"] for run in self._searches()),
                "sampling": done.sampling.n_failed,
            },
            "versions": dict(done.main.versions),
            "machine": self.machine,
            "seconds": {"total": round(self.seconds, 6)},
        }

    def _searches(self) -> tuple[Any, ...]:
        done = self.experiments
        others = tuple(run for case, run in done.cases.items() if case != "both")
        return (*done.repeats, *others, *done.surrogate_runs, *done.model_runs)

    def files(self) -> Iterator[tuple[str, bytes]]:
        """Yield (file name, content) of everything a folder gets, `paper.json` last."""
        yield "paper.md", self.markdown().encode()
        yield "paper.html", self.html().encode()
        yield from self.pictures.items()
        yield from render(self.figures, ("svg",))
        for case, run in self.experiments.cases.items():
            yield f"result_{case}.json", run.to_json().encode()
        yield STUDY_FILE, _json(self._study().to_dict())
        yield REPORT_FILE, _json(self.to_dict())

    def _study(self) -> Study:
        done = self.experiments
        return Study(
            sampled=done.sampling,
            worst=done.main,
            comparison=compare_with_sampling(done.main, done.sampling),
            influence=done.influence,
        )

    def __str__(self) -> str:
        rows = tables.table(
            "The paper, claim by claim", "claim", "paper", "ours", "verdict", "evidence"
        )
        for column, width in zip(rows.columns, (30, 12, 16, 18, 10), strict=True):
            column.no_wrap, column.width = False, width
        rows.columns[3].justify = rows.columns[4].justify = "left"
        for v in self.verdicts:
            rows.add_row(v.claim.statement, v.claim.paper, v.ours, v.outcome, v.claim.evidence)
        space = self.experiments.space
        quick = "Quick: smaller searches and fewer samples than the paper's.\n" * self.quick
        below = (
            "\n".join(verdict_sentences(self))
            + f"\n{quick}{self.machine}; {self.seconds:.1f} s.\n"
            + f"Baseline: {space.title}. {space.note or ''}".rstrip()
        )
        return tables.render([rows, Text(below)])


def _json(document: dict[str, Any]) -> bytes:
    return f"{json.dumps(document, allow_nan=False)}\n".encode()


def redo_paper(
    space: ParameterSpace | None = None,
    *,
    quick: bool = False,
    seed: int = 0,
    threads: int | None = None,
    callback: Callback | None = None,
) -> PaperReport:
    """Compute the whole paper again for a knee, and judge it claim by claim.

    Parameters
    ----------
    space : ParameterSpace, optional
        The packaged baseline with its default bounds for None; its case does not count, all three
        are computed.
    quick : bool
        Smaller searches and fewer samples: seconds, and a preview only.
    seed : int
        The same seed gives the same verdicts, those on times apart.
    threads : int, optional
        As for `simulate_batch`.
    callback : callable, optional
        Gets `Progress`, with a sentence for the stage; a true result cancels.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    ModelError
        If too many models failed to say anything.
    Cancelled
        If the callback cancelled.
    """
    if not isinstance(space, ParameterSpace | None):
        raise ParameterError(f"`space` is {space!r}; a ParameterSpace is allowed")
    check_seed(seed)
    n_threads = thread_count(threads)
    paper = packaged_paper()
    started = time.perf_counter()
    done = run_experiments(
        space or ParameterSpace(),
        QUICK_BUDGET if quick else PAPER_BUDGET,
        seed=seed,
        threads=n_threads,
        callback=callback,
    )
    return PaperReport(
        paper=paper,
        experiments=done,
        verdicts=judge_all(paper.claims, done),
        quick=quick,
        machine=machine_name(n_threads),
        seconds=time.perf_counter() - started,
    )

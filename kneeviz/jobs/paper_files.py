"""The paper redone for the bounds on screen, as files to take away."""

import io
import zipfile
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import kneecore
from kneecore import Knee
from kneeviz.jobs.job import Watch

if TYPE_CHECKING:  # its figures' library takes a second to load
    from kneecore import PaperReport
    from kneecore.paper.verdict import Outcome

_OUTCOMES: dict["Outcome", str] = {
    "agrees": "agree",
    "differs": "differ",
    "indifferent": "indifferent",
    "cannot be compared": "cannot be compared",
}


class ClaimRow(NamedTuple):
    """A claim of the paper and what became of it, for a table."""

    place: str
    """Section and figure."""
    statement: str
    paper: str
    """The paper's figure or word."""
    ours: str
    outcome: str
    fit: str
    """Whether the baseline was fitted to it: "fitted", "related" to what was, or "not fitted"."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PaperFiles:
    """A report's files and what it says in a line."""

    model: Knee
    words: str
    """How many of the paper's claims hold, those apart that the baseline was not fitted to."""
    claims: tuple[ClaimRow, ...]
    page: bytes
    """One HTML page with its figures inside."""
    everything: bytes
    """All of the report's files, as a ZIP."""


def redo(knee: Knee, *, quick: bool, seed: int, watch: Watch) -> PaperFiles:
    """Compute the paper again and draw its report.

    Raises
    ------
    KneecoreError, Cancelled
        As `kneecore.redo_paper`.
    """
    report = kneecore.redo_paper(knee, quick=quick, seed=seed, callback=watch)
    watch(kneecore.Progress(stage="drawing the figures", done=1, total=1))
    files = dict(report.files())
    return PaperFiles(
        model=knee,
        words=_words(report),
        claims=_rows(report),
        page=files["paper.html"],
        everything=_packed(files),
    )


def _rows(report: "PaperReport") -> tuple[ClaimRow, ...]:
    return tuple(
        ClaimRow(
            place=one.claim.place,
            statement=one.claim.statement,
            paper=one.claim.paper,
            ours=one.ours,
            outcome=one.outcome,
            fit=one.claim.fit,
        )
        for one in report.verdicts
    )


def _words(report: "PaperReport") -> str:
    n = {outcome: len(report.by_outcome(outcome)) for outcome in _OUTCOMES}
    counts = ", ".join(f"{n[outcome]} {word}" for outcome, word in _OUTCOMES.items())
    free = report.not_fitted
    held = sum(verdict.outcome == "agrees" for verdict in free)
    budget = (
        "quick: smaller searches, fewer samples" if report.quick else "the paper\u2019s budgets"
    )
    return (
        f"{held} of the {len(free)} statements that were not fitted hold. All "
        f"{len(report.verdicts)}: {counts} ({budget}; {report.seconds:.0f} s)."
    )


def _packed(files: dict[str, bytes]) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return packed.getvalue()

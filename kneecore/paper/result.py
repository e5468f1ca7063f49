"""The paper's claims beside a knee's own values: the report as data."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from kneecore.paper.claims import Paper
from kneecore.paper.experiments import Experiments
from kneecore.paper.verdict import Outcome, Verdict
from kneecore.presented import Presented, Words, words_of

__all__ = ["Documents", "PaperReport"]


@dataclass(frozen=True, kw_only=True)
class Documents(Words):
    """How the report is told: as other results are, and as a whole document."""

    markdown: Callable[[Any], str]
    """As Markdown that refers to its figures by file name."""
    page: Callable[[Any], str]
    """As one HTML page with its figures inside."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PaperReport(Presented):
    """The paper's claims judged by a knee's own computations."""

    paper: Paper
    verdicts: tuple[Verdict, ...]
    """One for each claim, in the order of the list."""
    quick: bool
    """Whether the budgets were smaller than the paper's."""
    seed: int
    title: str
    """The baseline's."""
    note: str | None
    """What the baseline's file says of it."""
    n_failed: Mapping[str, int]
    """Models that failed in all `searches`, and in the `sampling`."""
    machine: str
    """Where it was computed."""
    seconds: float
    """Wall time of the whole computation."""
    versions: Mapping[str, str]
    experiments: Experiments | None
    """Everything that the claims were judged by; None for a report that was read from a file, which
    holds the verdicts and their numbers."""

    def __repr__(self) -> str:
        return f"PaperReport({self.summary()!r})"

    def by_outcome(self, outcome: Outcome) -> tuple[Verdict, ...]:
        """Return the verdicts with an outcome."""
        return tuple(v for v in self.verdicts if v.outcome == outcome)

    @property
    def not_fitted(self) -> tuple[Verdict, ...]:
        """The verdicts that are evidence: not fitted, and there was something to compare."""
        return tuple(
            v
            for v in self.verdicts
            if v.claim.fit == "not fitted" and v.outcome != "cannot be compared"
        )

    def markdown(self) -> str:
        """Return the report as Markdown; its figures are files beside it."""
        return _documents().markdown(self)

    def html(self) -> str:
        """Return the report as one HTML page with its figures inside."""
        return _documents().page(self)


def _documents() -> Documents:
    words = words_of(PaperReport)
    assert isinstance(words, Documents)
    return words

"""What the paper claims: the list in `assets/paper.toml`."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

from kneecore._assets import asset_path

__all__ = ["Claim", "Paper", "packaged_paper"]

CLAIMS_FILE = "paper.toml"
Rule = Literal["among", "within", "above", "below", "at least", "at most", "none"]
Fit = Literal["fitted", "related", "not fitted"]


@dataclass(frozen=True, kw_only=True)
class Claim:
    """One claim of the paper, and how it is judged."""

    id: str
    section: str
    """Where the paper says so, as far as it is known here, such as 3.1."""
    statement: str
    """The claim, in our words."""
    paper: str
    """The paper's figure or word."""
    measure: str
    """Name of our quantity beside it, one of `MEASURES`; empty in a report read from a file."""
    unit: str
    """Unit of the measure and of `limit`."""
    rule: Rule
    """`among` our values, `within` a tolerance, `above`, `below`; `at least` or `at most` in the
    exact optimum and in more than half of the seeds; or `none`: nothing to judge."""
    fit: Fit
    """Whether the baseline was fitted to it: agreeing with what was fitted tells nothing."""
    figure: str = ""
    """The paper's figure that shows it, if one does."""
    limit: float | None = None
    """What our value is held against; None for the rule `none`."""
    tolerance: float | None = None
    """Half-width around `limit`, for the rule `within`."""
    note: str = ""
    """How words were made a number, or why there is nothing to judge."""

    @property
    def place(self) -> str:
        """Section and figure, as a reader looks them up."""
        return f"{self.section}, {self.figure}" if self.figure else self.section


@dataclass(frozen=True, kw_only=True)
class Paper:
    """The paper and its claims."""

    reference: Mapping[str, str]
    """authors, title, journal, doi, and the machine that its times were measured on."""
    claims: tuple[Claim, ...]


@lru_cache(maxsize=1)
def packaged_paper() -> Paper:
    """Return the packaged list of claims.

    Examples
    --------
    >>> packaged_paper().reference["doi"]
    '10.3389/fmech.2024.1392616'
    """
    document = tomllib.loads(asset_path(CLAIMS_FILE).read_text(encoding="utf-8"))
    return Paper(
        reference=document["paper"], claims=tuple(Claim(**entry) for entry in document["claim"])
    )

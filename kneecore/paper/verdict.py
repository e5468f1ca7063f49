"""One claim of the paper beside our values: agrees, differs, or cannot be compared."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore.paper.claims import Claim
from kneecore.paper.experiments import Experiments
from kneecore.paper.measures import MEASURES

__all__ = ["OUTCOMES", "Outcome", "Verdict", "judge", "judge_all", "shown"]

Outcome = Literal["agrees", "differs", "cannot be compared"]
OUTCOMES: tuple[Outcome, ...] = ("agrees", "differs", "cannot be compared")


@dataclass(frozen=True, kw_only=True, eq=False)
class Verdict:
    """What became of one claim."""

    claim: Claim
    values: NDArray[np.float64]
    """Our values: one, or one for each seed; NaN where a model failed."""
    outcome: Outcome
    why: str
    """The comparison in words, and how it was read."""

    @property
    def ours(self) -> str:
        """Our value with its unit; for several the middle one and the range."""
        known = self.values[np.isfinite(self.values)]
        if not len(known):
            return "no value"
        unit = f" {self.claim.unit}".rstrip()
        if len(self.values) == 1:
            return f"{shown(known[0])}{unit}"
        low, high = shown(known.min()), shown(known.max())
        return f"{shown(float(np.median(known)))}{unit} ({low} to {high}, {len(known)} seeds)"


def shown(value: float) -> str:
    """Return a number with three digits, and whole ones from 100 on."""
    text = f"{value:,.0f}" if abs(value) >= 100.0 else f"{value:.3g}"
    return "0" if text == "-0" else text


def judge(claim: Claim, values: ArrayLike) -> Verdict:
    """Hold our values against a claim by the claim's own rule.

    Values that are not finite are left out, and told of; with none left there is no verdict.
    """
    array = np.atleast_1d(np.asarray(values, dtype=np.float64))
    known = array[np.isfinite(array)]
    outcome: Outcome = "cannot be compared"
    if claim.rule == "none":
        why = claim.note
    elif not len(known):
        why = "No model gave an answer."
    else:
        holds, words = _held_against(claim, known)
        outcome = "agrees" if holds else "differs"
        missing = len(array) - len(known)
        told = f"{missing} of {len(array)} searches ended in a failed model. " if missing else ""
        why = f"{words} {told}{claim.note}".rstrip()
    return Verdict(claim=claim, values=array, outcome=outcome, why=why)


def _held_against(claim: Claim, known: NDArray[np.float64]) -> tuple[bool, str]:
    """Return whether the claim's rule holds, and the comparison in words."""
    limit = claim.limit
    assert limit is not None  # every rule but `none` has one
    unit = f" {claim.unit}".rstrip()
    low, high = float(known.min()), float(known.max())
    ours = shown(low) if low == high else f"{shown(low)} to {shown(high)}"
    if claim.rule == "among":
        holds = low <= limit <= high
        lies = "within" if holds else "outside of"
        return holds, f"{shown(limit)} lies {lies} our {ours}{unit}."
    if claim.rule == "within":
        tolerance = claim.tolerance or 0.0
        holds = abs(low - limit) <= tolerance and abs(high - limit) <= tolerance
        width = f" ± {shown(tolerance)}" if tolerance else ""
        words = f"{'within' if tolerance else 'equal to'} {shown(limit)}{width}"
    else:
        holds = low > limit if claim.rule == "above" else high < limit
        words = f"{claim.rule} {shown(limit)}"
    return holds, f"{ours}{unit} is {'' if holds else 'not '}{words}."


def judge_all(claims: tuple[Claim, ...], done: Experiments) -> tuple[Verdict, ...]:
    """Return the verdict on each claim."""
    return tuple(judge(claim, MEASURES[claim.measure](done)) for claim in claims)

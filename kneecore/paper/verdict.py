"""One claim of the paper beside our values: what became of it."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore.paper.claims import Claim
from kneecore.paper.experiments import Experiments
from kneecore.paper.finding import Finding
from kneecore.paper.measures import MEASURES

__all__ = ["OUTCOMES", "Outcome", "Verdict", "judge", "judge_all", "shown"]

Outcome = Literal["agrees", "differs", "indifferent", "cannot be compared"]
OUTCOMES: tuple[Outcome, ...] = ("agrees", "differs", "indifferent", "cannot be compared")
_BY_PAIR = ("at least", "at most")


@dataclass(frozen=True, kw_only=True, eq=False)
class Verdict:
    """What became of one claim."""

    claim: Claim
    values: NDArray[np.float64]
    """Our values: one, or one for each seed, for `at least` and `at most` with that of the exact
    optimum first; NaN where a model failed."""
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
        if self.claim.rule in _BY_PAIR:
            exact, seeds = self.values[0], self.values[1:]
            first = shown(float(exact)) + unit if np.isfinite(exact) else "failed"
            return f"exact: {first}; {_middle(seeds[np.isfinite(seeds)], '')}"
        return _middle(known, unit)


def _middle(known: NDArray[np.float64], unit: str) -> str:
    """Return the middle one of several seeds' values, and their range."""
    if not len(known):
        return "no seed"
    low, high = shown(float(known.min())), shown(float(known.max()))
    return f"{shown(float(np.median(known)))}{unit} ({low} to {high}, {len(known)} seeds)"


def shown(value: float) -> str:
    """Return a number with three digits, and whole ones from 100 on."""
    text = f"{value:,.0f}" if abs(value) >= 100.0 else f"{value:.3g}"
    return "0" if text == "-0" else text


def judge(claim: Claim, found: ArrayLike | Finding) -> Verdict:
    """Hold our values against a claim by the claim's own rule.

    Values that are not finite are left out, and told of; with none left, or without the exact
    optimum's where it is asked for, there is no verdict.
    """
    finding = found if isinstance(found, Finding) else Finding(values=np.asarray(found))
    array = np.atleast_1d(np.asarray(finding.values, dtype=np.float64))
    known = array[np.isfinite(array)]
    outcome: Outcome = "cannot be compared"
    if claim.rule == "none":
        why = claim.note
    elif not len(known) or (claim.rule in _BY_PAIR and not np.isfinite(array[0])):
        why = "No model gave an answer."
    else:
        holds, words = _held_against(claim, known)
        outcome = "agrees" if holds else ("indifferent" if finding.indifferent else "differs")
        missing = len(array) - len(known)
        if missing:
            words += f" {missing} of {len(array)} searches ended in a failed model."
        why = " ".join(part for part in (words, finding.told, claim.note) if part)
    return Verdict(claim=claim, values=array, outcome=outcome, why=why)


def _held_against(claim: Claim, known: NDArray[np.float64]) -> tuple[bool, str]:
    """Return whether the claim's rule holds, and the comparison in words."""
    limit = claim.limit
    assert limit is not None  # every rule but `none` has one
    unit = f" {claim.unit}".rstrip()
    low, high = float(known.min()), float(known.max())
    ours = shown(low) if low == high else f"{shown(low)} to {shown(high)}"
    if claim.rule in _BY_PAIR:
        return _held_by_pairs(claim, limit, known)
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


def _held_by_pairs(claim: Claim, limit: float, known: NDArray[np.float64]) -> tuple[bool, str]:
    """Return whether the exact optimum and more than half of the seeds fulfil a claim."""
    fulfils = known >= limit if claim.rule == "at least" else known <= limit
    exact, n, total = bool(fulfils[0]), int(np.count_nonzero(fulfils[1:])), len(known) - 1
    wanted = f"{claim.rule} {shown(limit)} {claim.unit}".rstrip()
    words = f"{wanted[0].upper()}{wanted[1:]}: {'' if exact else 'not '}in the exact optimum"
    holds = exact and 2 * n > total
    return holds, f"{words}, and in {n} of {total} seeds."


def judge_all(claims: tuple[Claim, ...], done: Experiments) -> tuple[Verdict, ...]:
    """Return the verdict on each claim."""
    return tuple(judge(claim, MEASURES[claim.measure](done)) for claim in claims)

"""What the study says, as HTML: the sampling's numbers, and the paper's claims in a line."""

from collections.abc import Sequence

from kneecore import MOMENT, MonteCarloResult
from kneeviz.state import results
from kneeviz.views.html import marks
from kneeviz.views.html.pieces import box, faint, number, plain, table


def sampling(found: MonteCarloResult) -> str:
    """Return what a Monte-Carlo study found at the largest moments, failures counted."""
    spread = found.y
    rows = [
        (
            f"{'+' if MOMENT[k] > 0 else ''}{number(float(MOMENT[k]), 0)} N·m",
            number(spread.mean[k], 1),
            number(spread.sd[k], 1),
            number(spread.percentile_lower[k], 1),
            number(spread.percentile_upper[k], 1),
        )
        for k in (5, 11)
    ]
    head = ("Angle (°)", "mean", "sd", "0.15 %", "99.85 %")
    note = (
        f"{found.n_samples:,} knees, {found.settings.sampling}, seed {results.seed(found)}: "
        f"<b>{found.n_failed:,} failed</b> (left out), {marks.counted(found.counts)}."
    )
    return box(table(head, rows) + faint(note))


def judged(words: str, claims: Sequence[tuple[str, str, str, str]]) -> str:
    """Return what became of the paper's claims: in a line, and one by one.

    A claim is its statement, the paper's figure, ours, and the outcome.
    """
    rows = "".join(
        f'<div style="margin-top:6px"><b>{plain(outcome)}:</b> {plain(statement)}<br>'
        f"{faint(f'The paper: {plain(paper)}. Here: {plain(ours)}.')}</div>"
        for statement, paper, ours, outcome in claims
    )
    return box(
        f"The paper: {plain(words)}<details><summary>Claim by claim</summary>{rows}</details>"
    )

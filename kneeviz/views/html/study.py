"""What the study says, as HTML: the sampling's numbers, and the paper's claims in a line."""

from collections.abc import Sequence

from kneecore import MOMENT, MonteCarloResult
from kneeviz.jobs.paper_files import ClaimRow
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


def judged(words: str, claims: Sequence[ClaimRow]) -> str:
    """Return what became of the paper's claims: in a line, and as a table."""
    told = plain(words)
    rows = "".join(_claim(claim) for claim in claims)
    heads = "".join(
        f'<th scope="col" style="text-align:left;padding:1px 4px">{head}</th>'
        for head in ("Where", "The paper", "Here", "Verdict")
    )
    table = (
        '<table style="width:100%;border-collapse:collapse;font-size:12px">'
        f"<thead><tr>{heads}</tr></thead>{rows}</table>"
    )
    note = faint("Fitted, or related to what was: agreeing tells nothing.")
    return box(
        f"The paper: {told}<details><summary>Claim by claim</summary>{table}{note}</details>"
    )


def _claim(claim: ClaimRow) -> str:
    """Return a claim in two rows: what it states, then where, both figures and the verdict."""
    verdict = (
        f"<b>{plain(claim.outcome)}</b>{'' if claim.fit == 'not fitted' else f', {claim.fit}'}"
    )
    cells = (plain(claim.place), plain(claim.paper), plain(claim.ours), verdict)
    line = "border-top:1px solid rgba(128,128,128,.35)"
    figures = "".join(f'<td style="padding:0 4px 4px;vertical-align:top">{c}</td>' for c in cells)
    return (
        f'<tbody><tr><th scope="rowgroup" colspan="4" style="text-align:left;font-weight:400;'
        f'padding:4px 4px 0;{line}">{plain(claim.statement)}</th></tr><tr>{figures}</tr></tbody>'
    )

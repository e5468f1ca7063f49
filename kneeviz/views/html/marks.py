"""What stands behind an angle that is not what it seems: small signs with their words."""

from collections.abc import Mapping

from kneecore import MOMENT, Response
from kneecore.report.marks import MEANINGS, mark
from kneeviz.views.html.pieces import box, escape, faint

_SHORT = {
    "*": "not settled",
    "~": "not yet at rest",
    "!": "implausible",
}


_COUNTED = {
    "unsettled": "unsettled at some load",
    "not_at_rest": "somewhere over 0.1° from their equilibrium",
    "implausible": "implausible",
}

_HELP = 'style="cursor:help;text-decoration:underline dotted"'
"""Shows that more is told on hovering."""


def signs(response: Response, k: int) -> str:
    """Return the signs behind the angle at load `k`; their meaning shows on hovering."""
    return "".join(
        f' <span {_HELP} title="{escape(MEANINGS[sign])}">{escape(sign)}</span>'
        for sign in mark(response, k)
    )


def marks_line(response: Response | None) -> str:
    """Return at which loads the visitor's knee bears which mark, in words; empty for none."""
    if response is None or response.refinements < 0:
        return ""
    told = []
    for sign, words in _SHORT.items():
        at = [k for k in range(len(MOMENT)) if sign in mark(response, k)]
        if at:
            loads = ", ".join(f"{MOMENT[k]:+g}".replace("-", "\u2212") for k in at)
            meant = f'<span {_HELP} title="{escape(MEANINGS[sign])}">{sign} {words}</span>'
            told.append(f"{meant} at {loads} N·m")
    return box(faint("Your knee: " + "; ".join(told) + ".")) if told else ""


def counted(counts: Mapping[str, int]) -> str:
    """Return how many knees of a study bear each mark; empty where they were not counted."""
    told = [f"{counts[kind]:,} {words}" for kind, words in _COUNTED.items() if kind in counts]
    return f"{', '.join(told)} (kept)" if told else ""

"""What stands behind an angle that is not what it seems: small signs with their words."""

from kneecore import MOMENT, Response
from kneecore.report.marks import MEANINGS, mark
from kneeviz.views.html.pieces import box, escape, faint

_SHORT = {
    "*": "not settled",
    "~": "not yet at rest",
    "!": "implausible",
}


def signs(response: Response, k: int) -> str:
    """Return the signs behind the angle at load `k`; their meaning shows on hovering."""
    return "".join(
        f' <span title="{escape(MEANINGS[sign])}">{escape(sign)}</span>'
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
            told.append(
                f'<span title="{escape(MEANINGS[sign])}">{sign} {words} at {loads} N·m</span>'
            )
    return box(faint("Your knee: " + "; ".join(told) + ".")) if told else ""

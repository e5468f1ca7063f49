"""One knee's response as a table."""

import math

import numpy as np
from rich.text import Text

from kneecore.knee.parameters import LIGAMENTS
from kneecore.knee.response import LARGEST_EXTENSION, Response
from kneecore.presented import Words
from kneecore.report.marks import legend, mark
from kneecore.report.step_check import step_lines
from kneecore.report.tables import number, render, table

__all__ = ["WORDS", "response_table"]


def response_table(
    response: Response, at_rest: Response | None = None, *, html: bool = False
) -> str:
    """Return one knee's response as text or HTML, with the angles `at_rest` if they are given."""
    columns = ["load N m", "flexion deg"] + [f"{name.upper()} N" for name in LIGAMENTS]
    columns += ["contact N", "indent mm", "AP mm", "settled"]
    beside = at_rest is not None and math.isnan(at_rest.lost_at)
    if beside:
        columns.append("at rest")
    rows = table(f"Response (status: {response.status})", *columns)
    rows.collapse_padding = True  # all columns fit the width
    for k in np.argsort(-response.moment):
        numbers = [*response.tension[k], response.contact_force[k]]
        rows.add_row(
            f"{response.moment[k]:+g}",
            number(np.degrees(response.flexion[k])) + mark(response, int(k)),
            *(f"{v:.1f}" for v in numbers),
            f"{1e3 * response.indentation[k]:.2f}",
            f"{1e3 * response.ap_position[k]:.2f}",
            "yes" if response.settled[k] else "no",
            *([number(np.degrees(at_rest.flexion[k]))] if at_rest is not None and beside else []),
        )
    rest = ", ".join(
        f"{name.upper()} {1e3 * value:.3f}"
        for name, value in zip(LIGAMENTS, response.rest_length, strict=True)
    )
    below = [Text(f"Rest lengths, mm: {rest}"), *map(Text, legend([response]))]
    below += map(Text, step_lines({"the knee": response}))
    lost_at = response.lost_at if at_rest is None else at_rest.lost_at
    if not math.isnan(lost_at):
        below.append(Text(f"No equilibrium could be followed to {lost_at:+g} N m: dynamics shown."))
    return render([rows, *below], html=html)


def summary(response: Response) -> str:
    """Return the angle under the largest extension moment in one sentence."""
    moment = f"{response.moment[LARGEST_EXTENSION]:+g} N m"
    if response.status == "failed":
        return "The model fails for this knee."
    return f"At {moment} the knee is at {np.degrees(response.flexion[LARGEST_EXTENSION]):.1f} deg."


WORDS = Words(
    summary=summary,
    text=response_table,
    html=lambda response: response_table(response, html=True),
)

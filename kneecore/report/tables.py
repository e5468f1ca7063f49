"""Plain tables for terminals and notebooks."""

import io
import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from rich import box
from rich.console import Console, RenderableType
from rich.table import Table
from rich.text import Text

from kneecore.knee.parameters import LIGAMENTS

if TYPE_CHECKING:
    from kneecore.knee.response import Response

WIDTH = 100


def render(parts: Iterable[RenderableType], *, html: bool = False) -> str:
    """Return rich renderables as plain text, or as HTML for a notebook."""
    parts = list(parts)
    console = Console(file=io.StringIO(), width=WIDTH, record=True, force_jupyter=False)
    # A wider console, rather than numbers that are cut.
    unbounded = console.options.update(width=10 * WIDTH)
    console.width = max(
        [WIDTH]
        + [
            console.measure(part, options=unbounded).maximum
            for part in parts
            if isinstance(part, Table)
        ]
    )
    for part in parts:
        # What must not be wrapped, such as a command to be copied, is one long line.
        console.print(part, soft_wrap=isinstance(part, Text) and bool(part.no_wrap))
    if html:
        return console.export_html(
            inline_styles=True, code_format='<pre style="line-height:1.2">{code}</pre>'
        )
    lines = (line.rstrip() for line in console.export_text(styles=False).splitlines())
    return "\n".join(lines)


def table(title: str, *columns: str) -> Table:
    """Return an empty table; the first column is flush left."""
    made = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left", pad_edge=False)
    for index, column in enumerate(columns):
        made.add_column(column, justify="left" if index == 0 else "right", no_wrap=True)
    return made


def degrees(value: float) -> str:
    """Return an angle (rad) as text in deg."""
    return f"{np.degrees(value):.2f}" if np.isfinite(value) else "failed"


def response_table(
    response: "Response", at_rest: "Response | None" = None, *, html: bool = False
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
            degrees(response.flexion[k]),
            *(f"{v:.1f}" for v in numbers),
            f"{1e3 * response.indentation[k]:.2f}",
            f"{1e3 * response.ap_position[k]:.2f}",
            "yes" if response.settled[k] else "no",
            *([degrees(at_rest.flexion[k])] if at_rest is not None and beside else []),
        )
    rest = ", ".join(
        f"{name.upper()} {1e3 * value:.3f}"
        for name, value in zip(LIGAMENTS, response.rest_length, strict=True)
    )
    below = [Text(f"Rest lengths, mm: {rest}")]
    lost_at = response.lost_at if at_rest is None else at_rest.lost_at
    if not math.isnan(lost_at):
        below.append(Text(f"No equilibrium could be followed to {lost_at:+g} N m: dynamics shown."))
    return render([rows, *below], html=html)

"""Plain tables for terminals and notebooks."""

import io
from collections.abc import Iterable

import numpy as np
from rich import box
from rich.console import Console, RenderableType
from rich.table import Table
from rich.text import Text

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


def number(value: float, digits: int = 2) -> str:
    """Return a number as text; `failed` where there is none."""
    return f"{value:.{digits}f}" if np.isfinite(value) else "failed"


def significant(value: float) -> str:
    """Return a number of unknown size as text."""
    return f"{value:.6g}" if np.isfinite(value) else "failed"


def with_unit(text: str, unit: str) -> str:
    """Return a number's text with its unit behind it."""
    return f"{text} {unit}" if unit and unit != "-" else text

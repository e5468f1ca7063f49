"""A document as blocks, written as Markdown or as one HTML page from the same data."""

import base64
import html
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

__all__ = ["Block", "Heading", "Paragraph", "Picture", "Table", "to_html", "to_markdown"]


@dataclass(frozen=True)
class Heading:
    """A heading; level 1 is the title."""

    text: str
    level: int = 2


@dataclass(frozen=True)
class Paragraph:
    """Plain text, in a box if it is a warning."""

    text: str
    warning: bool = False


@dataclass(frozen=True)
class Table:
    """A table of texts."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    marked: int | None = None
    """Column whose text says how a row is coloured in HTML, such as `agrees`."""


@dataclass(frozen=True)
class Picture:
    """A PNG picture by its file name."""

    file: str
    caption: str


Block = Heading | Paragraph | Table | Picture

_STYLE = """
:root { color-scheme: light dark; --rule: #8884; --soft: #8881; }
body { font: 16px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 72rem; padding: 0 1rem; }
h1 { line-height: 1.2; } h2 { margin-top: 2.5rem; }
p, figcaption { max-width: 46rem; }
.scroll { margin: 1rem 0 1.5rem; overflow-x: auto; }
table { border-collapse: collapse; font-size: 0.875rem; font-variant-numeric: tabular-nums; }
th, td { border-bottom: 1px solid var(--rule); padding: 0.35rem 0.75rem 0.35rem 0; text-align: left;
  vertical-align: top; }
th { white-space: nowrap; }
td.mark { white-space: nowrap; font-weight: 600; }
tr.agrees td.mark { color: light-dark(#00664b, #4fd1a5); }
tr.differs td.mark { color: light-dark(#a84300, #ff9d5c); }
table:has(td.mark) { min-width: 60rem; }
.warning { background: var(--soft); border-left: 4px solid #D55E00; padding: 0.75rem 1rem; }
figure { margin: 1.5rem 0 2.5rem; }
img { background: white; height: auto; max-width: 100%; }
figcaption { font-size: 0.875rem; }
"""


def _plain(text: str) -> str:
    """Return text in which Markdown sees nothing but text, on one line."""
    return re.sub(r"([\\`*_\[\]<>#|~])", r"\\\1", " ".join(text.split()))


def _markdown_table(table: Table) -> str:
    lines = [table.columns, ["---"] * len(table.columns), *table.rows]
    cells = [[c if k == 1 else _plain(c) for c in line] for k, line in enumerate(lines)]
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)


def to_markdown(blocks: Sequence[Block]) -> str:
    """Return the document as Markdown that refers to its pictures by file name."""
    parts = []
    for block in blocks:
        match block:
            case Heading():
                parts.append(f"{'#' * block.level} {_plain(block.text)}")
            case Paragraph():
                parts.append(f"{'> ' if block.warning else ''}{_plain(block.text)}")
            case Table():
                parts.append(_markdown_table(block))
            case Picture():
                caption = _plain(block.caption)
                parts.append(f"![{caption}]({block.file})\n\n{caption}")
    return "\n\n".join(parts) + "\n"


def _html_table(table: Table) -> str:
    head = "".join(f"<th>{html.escape(column)}</th>" for column in table.columns)
    mark_cell = ' class="mark"'
    rows = []
    for row in table.rows:
        cells = "".join(
            f"<td{mark_cell if k == table.marked else ''}>{html.escape(cell)}</td>"
            for k, cell in enumerate(row)
        )
        mark = "" if table.marked is None else f' class="{html.escape(row[table.marked])}"'
        rows.append(f"<tr{mark}>{cells}</tr>")
    body = "\n".join(rows)
    return (
        f'<div class="scroll"><table>\n<thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{body}\n</tbody></table></div>"
    )


def _html_block(block: Block, pictures: Mapping[str, bytes]) -> str:
    match block:
        case Heading():
            return f"<h{block.level}>{html.escape(block.text)}</h{block.level}>"
        case Paragraph():
            box = ' class="warning"' if block.warning else ""
            return f"<p{box}>{html.escape(block.text)}</p>"
        case Table():
            return _html_table(block)
        case Picture():
            data = base64.b64encode(pictures[block.file]).decode()
            caption = html.escape(block.caption)
            return (
                f'<figure><img src="data:image/png;base64,{data}" alt="{caption}">'
                f"<figcaption>{caption}</figcaption></figure>"
            )


def to_html(title: str, blocks: Sequence[Block], pictures: Mapping[str, bytes]) -> str:
    """Return the document as one HTML page that needs no other file.

    Parameters
    ----------
    title : str
        Of the browser's window.
    blocks : sequence of Block
    pictures : mapping
        The content of each picture by its file name.
    """
    body = "\n".join(_html_block(block, pictures) for block in blocks)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(title)}</title>\n<style>{_STYLE}</style>\n</head>\n"
        f"<body>\n{body}\n</body>\n</html>\n"
    )

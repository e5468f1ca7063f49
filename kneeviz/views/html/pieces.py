"""Small pieces of HTML for the panels: pure functions from numbers to text.

Text that a visitor brought along (titles, file names, messages about them) is escaped here.
"""

import html
import re
from collections.abc import Sequence

import numpy as np

from kneeviz.views import theme

_BOX = "font-size:12.5px;line-height:1.45;padding:2px 14px 4px 14px"


def box(content: str, *, style: str = "") -> str:
    """Return `content` as a block in the panels' text size."""
    return f'<div style="{_BOX};{style}">{content}</div>'


def heading(text: str) -> str:
    """Return the heading of a part of a panel."""
    return f'<h2 style="font-size:1.1em;margin:2px 0">{text}</h2>'


def unseen_title(text: str) -> str:
    """Return the page's title for who hears it; those who see it have the picture."""
    style = "position:absolute;width:1px;height:1px;margin:0;overflow:hidden;clip-path:inset(50%)"
    return f'<h1 style="{style}">{text}</h1>'


def faint(text: str) -> str:
    """Return text in the quieter tone."""
    return f'<span style="opacity:.68">{text}</span>'


def escape(text: str) -> str:
    """Return foreign text that no browser takes for markup."""
    return html.escape(str(text), quote=True)


def plain(words: str) -> str:
    """Return a report's words, escaped, with numbers and units as `number` writes them."""
    words = re.sub(r"(?<![\w.])-(?=\d)", "\u2212", words)
    return escape(re.sub(r" deg\b", "°", words).replace("N m", "N·m"))


def sentence(text: str) -> str:
    """Return text with a full stop at its end."""
    return text if text.endswith((".", "!", "?")) else f"{text}."


def number(value: float, digits: int, unit: str = "") -> str:
    """Return a number with a true minus sign and its unit; a dash for what is not known."""
    if not np.isfinite(value):
        return "\u2013"
    text = f"{value:.{digits}f}"
    if float(text) == 0.0:
        text = text.lstrip("-")
    gap = "" if unit in ("", "°") else " "
    return text.replace("-", "\u2212") + gap + unit


def status(text: str, *, kind: str = "calm") -> str:
    """Return the line that says what the app is doing; `kind` is calm, busy or bad."""
    colour = {"calm": "#2b8a3e", "busy": "#e08a00", "bad": "#d6336c"}[kind]
    dot = (
        f'<span style="display:inline-block;width:8px;height:8px;border-radius:50%;'
        f'background:{colour};margin-right:7px"></span>'
    )
    line = "white-space:nowrap;overflow:hidden;text-overflow:ellipsis;padding-top:0"
    plain = text.replace('"', "&quot;")
    return f'<div title="{plain}">{box(dot + text, style=line)}</div>'


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a compact table; the first column is text, the others are numbers."""
    cells = "".join(f'<th style="text-align:{_side(i)}">{h}</th>' for i, h in enumerate(head))
    body = "".join(
        "<tr>"
        + "".join(
            f'<td style="text-align:{_side(i)};padding:1px 4px">{c}</td>' for i, c in enumerate(row)
        )
        + "</tr>"
        for row in rows
    )
    return (
        f'<table style="width:100%;border-collapse:collapse;font-size:12px;'
        f'font-variant-numeric:tabular-nums"><thead><tr>{cells}</tr></thead>'
        f"<tbody>{body}</tbody></table>"
    )


def _side(column: int) -> str:
    return "left" if column == 0 else "right"


def coloured(text: str, hue: str) -> str:
    """Return text in a hue, as dark or as light as it must be to be read."""
    return f'<span style="color:{theme.ink(hue)};font-weight:600">{text}</span>'


def curve_switch(key: str, content: str, hint: str = "") -> str:
    """Return a legend's entry, which switches the curves of that key (`kneeviz/charts.js`)."""
    style = (
        "all:unset;box-sizing:border-box;cursor:pointer;white-space:nowrap;margin-right:12px;"
        "outline:revert"
    )
    title = escape(f"{hint} Show or hide it.".strip())
    return (
        f'<button type="button" data-curve="{key}" aria-pressed="true" title="{title}" '
        f'style="{style}">{content}</button>'
    )


def command_line(command: str) -> str:
    """Return a shell command in a box that one click selects."""
    style = (
        "display:block;user-select:all;white-space:pre-wrap;word-break:break-word;font-size:11px;"
        "border:1px solid rgba(128,128,128,.35);border-radius:4px;padding:4px 6px;margin-top:3px"
    )
    return f'<code style="{style}">{escape(command)}</code>'


def sparkline(values: Sequence[float], colour: str) -> str:
    """Return the best f so far as a small rising curve."""
    finite = [v for v in values if np.isfinite(v)]
    if len(finite) < 2:
        return ""
    low, high = min(finite), max(finite)
    span = max(high - low, 1e-9)
    n = len(finite) - 1
    points = " ".join(
        f"{290 * i / n:.1f},{44 - 40 * (v - low) / span:.1f}" for i, v in enumerate(finite)
    )
    return (
        f'<svg viewBox="0 0 296 48" width="100%" height="48" style="display:block">'
        f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2"/></svg>'
    )

"""Small drawings for the panels: rows of bars with a name at their left."""

__all__ = ["LABELS", "ROW", "WIDTH", "drawing", "rect", "text"]

WIDTH, LABELS = 362.0, 112.0
"""Width of a drawing, and of the names' column."""
ROW = 13.0


def drawing(height: float, body: str) -> str:
    """Return a drawing as wide as the panel."""
    return (
        f'<svg viewBox="0 0 {WIDTH:g} {height:g}" width="100%" style="display:block;'
        f'font-variant-numeric:tabular-nums" fill="currentColor" font-size="10.5">{body}</svg>'
    )


def text(x: float, y: float, words: str, *, anchor: str = "start", extra: str = "") -> str:
    """Return words, which must be escaped, on a baseline."""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {extra}>{words}</text>'


def rect(x: float, y: float, width: float, height: float, hue: str, opacity: float) -> str:
    """Return a filled rectangle."""
    return (
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{max(width, 0.0):.1f}" height="{height:.1f}" '
        f'fill="{hue}" fill-opacity="{opacity:.2f}"/>'
    )

"""How uPlot draws lines, dots and axes: one hue a knee, the same in every chart."""

from typing import Any

from kneeviz.views import theme


def line_style(
    colour: str, width: float, *, dash: tuple[float, ...] | None = None
) -> dict[str, Any]:
    """Return a line without dots at its corners."""
    line: dict[str, Any] = {"stroke": colour, "width": width, "points": {"show": False}}
    if dash is not None:
        line["dash"] = dash
    return line


def knee_lines(colours: theme.Palette) -> list[dict[str, Any]]:
    """Return the lines of baseline, the visitor's knee, worst case 1 and 2."""
    return [
        line_style(colours.baseline, 1.5 * colours.size),
        line_style(colours.current, 2.5 * colours.size),
        line_style(colours.model_1, 2.0 * colours.size),
        line_style(colours.model_2, 2.0 * colours.size),
    ]


def dots(colours: theme.Palette) -> list[dict[str, Any]]:
    """Return what marks the poses on screen: a ring, a dot within it and a dot within that.

    So they are told apart where they coincide.
    """
    ring = _mark(colours.current, 15 * colours.size, 2.5 * colours.size, "rgba(0,0,0,0)")
    one = _mark(colours.model_1, 10 * colours.size, 0, colours.model_1)
    two = _mark(colours.model_2, 6 * colours.size, 0, colours.model_2)
    return [ring, one, two]


def _mark(hue: str, size: float, rim: float, fill: str) -> dict[str, Any]:
    points = {"show": True, "size": size, "width": rim, "stroke": hue, "fill": fill, "space": 0}
    return {"stroke": hue, "width": 0, "points": points}


def axis_style(
    label: str, *, side: int, scale: str, size: int, colours: theme.Palette
) -> dict[str, Any]:
    """Return an axis; `side` is uPlot's: 2 below, 3 to the left."""
    return {
        "label": label,
        "side": side,
        "scale": scale,
        "size": round(size * colours.size),
        "labelSize": round(18 * colours.size),
        "gap": 4,
        "font": f"{11 * colours.size:g}px sans-serif",
        "labelFont": f"{12 * colours.size:g}px sans-serif",
        "stroke": colours.text,
        "grid": {"stroke": colours.rule, "width": 1},
        "ticks": {"stroke": colours.rule, "size": 4, "width": 1},
    }

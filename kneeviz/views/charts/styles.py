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


def axis_told(label: str, unit: str, digits: int | None = 1) -> dict[str, Any]:
    """Return the first series, which has the places on the axis: what a pointer is told of it.

    Without `digits` its numbers have four, wherever the point is.
    """
    return {"label": label, "unit": unit, "digits": digits}


def switched(style: dict[str, Any], key: str) -> dict[str, Any]:
    """Return a series that the legend's entry `key` switches off and on (`kneeviz/charts.js`)."""
    return {**style, "key": key}


def told(
    style: dict[str, Any], key: str, label: str, unit: str, digits: int | None = 1
) -> dict[str, Any]:
    """Return the same whose value stands beside the pointer, with its name and unit."""
    return {**switched(style, key), "label": label, "unit": unit, "digits": digits}


def knee_lines(
    colours: theme.Palette,
    unit: str,
    digits: int | None = 1,
    called: tuple[str, str] = ("baseline", "your knee"),
) -> list[dict[str, Any]]:
    """Return the lines of baseline, the visitor's knee, worst case 1 and 2.

    The first two are `called` so.
    """
    size = colours.size
    lines = (
        (colours.baseline, 1.5, "baseline", called[0]),
        (colours.current, 2.5, "current", called[1]),
        (colours.model_1, 2.0, "model_1", "model 1"),
        (colours.model_2, 2.0, "model_2", "model 2"),
    )
    return [
        told(line_style(hue, width * size), key, label, unit, digits)
        for hue, width, key, label in lines
    ]


def dots(colours: theme.Palette) -> list[dict[str, Any]]:
    """Return what marks the poses on screen: a ring, a dot within it and a dot within that.

    So they are told apart where they coincide.
    """
    ring = _mark(colours.current, 15 * colours.size, 2.5 * colours.size, "rgba(0,0,0,0)")
    one = _mark(colours.model_1, 10 * colours.size, 0, colours.model_1)
    two = _mark(colours.model_2, 6 * colours.size, 0, colours.model_2)
    keys = ("current", "model_1", "model_2")
    return [switched(mark, key) for mark, key in zip((ring, one, two), keys, strict=True)]


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

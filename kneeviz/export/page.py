"""One HTML file that needs no server and no network: the knees, their curves and the sentence."""

import base64
import json
from collections.abc import Sequence
from importlib import resources

from kneecore import Knee, SearchResult
from kneecore.figures.style import LABELS
from kneecore.presented import rendered
from kneecore.report.command import command_line
from kneecore.report.knee_pair import difference_lines, knee_footer
from kneecore.report.search import objective_text
from kneeviz.export.chart import chart
from kneeviz.export.drawing import drawing, frames
from kneeviz.export.film import Film, film_of
from kneeviz.views.html.pieces import escape, number, plain

_PAPER = (
    'After A. Ciszkiewicz and R. Dumas, "Surrogate-based worst-case analysis of a knee joint model '
    'using Genetic Algorithm", Front. Mech. Eng. 10:1392616 (2024), doi 10.3389/fmech.2024.1392616.'
)
# Nothing may be fetched, whatever a browser thinks of a file from disk.
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"


def html_page(result: SearchResult) -> str:
    """Return a search's result as a page: moving for knees, with figures for any other model."""
    film = film_of(result) if isinstance(result.model, Knee) else None
    views = script = ""
    if film is None:
        views = _figures(result)
    elif film.knees:
        views, script = _moving(film), _script(film)
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(_title(result))}</title>\n<style>\n{_asset('page.css')}</style>\n</head>\n"
        f"<body>\n<main>\n<h1>{plain(result.summary())}</h1>\n{views}{_numbers(result, film)}"
        f"</main>\n{_origin(result)}{script}</body>\n</html>\n"
    )


def _asset(name: str) -> str:
    return resources.files("kneeviz.export").joinpath(name).read_text(encoding="utf-8")


def _title(result: SearchResult) -> str:
    if isinstance(result.model, Knee):
        return "The two most different knees within the uncertainty of their parameters"
    return f"{result.model.name}: the two most different models within the bounds"


def _moving(film: Film) -> str:
    """Return drawing, chart and what plays them."""
    boxes = "".join(
        f'<label class="knee {knee.name}"><input type="checkbox" checked '
        f'data-knee="{knee.name}"> {LABELS[knee.name]}</label>'
        for knee in film.knees
    )
    return (
        f'<div class="views">{drawing(film)}{chart(film)}</div>\n'
        '<div class="controls"><button id="play" type="button">Play</button>'
        '<input id="position" type="range" min="0" max="1" step="0.001" value="0" '
        'aria-label="Moment, from extension to flexion">'
        f'<span id="now"></span>{boxes}</div>\n'
        "<noscript><p>The knees move where scripts may run.</p></noscript>\n"
    )


def _script(film: Film) -> str:
    data = json.dumps(frames(film), allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    return (
        f'<script id="film" type="application/json">{data}</script>\n'
        f"<script>\n{_asset('page.js')}</script>\n"
    )


def _figures(result: SearchResult) -> str:
    pictures = (
        (name, base64.b64encode(content).decode())
        for name, content in rendered(result)
        if name.endswith(".svg")
    )
    images = "".join(
        f'<img alt="{escape(name.removesuffix(".svg").replace("_", " "))}" '
        f'src="data:image/svg+xml;base64,{content}">'
        for name, content in pictures
    )
    return f'<div class="views">{images}</div>\n'


def _numbers(result: SearchResult, film: Film | None) -> str:
    """Return the table of angles, f with what the model says of it, and the verdict."""
    lines = []
    if isinstance(result.model, Knee):
        lines += difference_lines(result)
    lines.append(_objective(result))
    if result.verdict is not None:
        lines.append(str(result.verdict))
    table = "" if film is None or not film.knees else _angles(film)
    return table + "".join(f"<p>{plain(line)}</p>\n" for line in lines)


def _objective(result: SearchResult) -> str:
    """Return f, the model's beside the surrogate's, and what it is."""
    unit = "summed over the outputs"
    if isinstance(result.model, Knee):
        unit = "the angles between the two models, summed over the loads that count"
    model = "not known, for the model fails there"
    if result.objective_model is not None:
        model = objective_text(result.model, result.objective_model)
    told = f"f, {unit}: {model} in the true model"
    if result.objective_surrogate is None:
        return f"{told}, which was searched."
    gap = "" if result.gap_percent is None else f" (gap {number(result.gap_percent, 1)} %)"
    promised = objective_text(result.model, result.objective_surrogate)
    return f"{told}; the surrogate that was searched said {promised}{gap}."


def _angles(film: Film) -> str:
    """Return each knee's angle now, and at both ends of the motion."""
    last = len(film.moment) - 1
    columns: list[tuple[str, Sequence[str]]] = [
        ("Knee angle now", [""] * len(film.knees)),
        *(
            (
                f"at {'+' if film.moment[k] > 0.0 else ''}{number(film.moment[k], 0)} N·m",
                [number(knee.angle_deg[k], 1, "°") for knee in film.knees],
            )
            for k in (0, last)
        ),
    ]
    head = "".join(f'<th class="{knee.name}">{LABELS[knee.name]}</th>' for knee in film.knees)
    rows = ""
    for at, (name, cells) in enumerate(columns):
        told = "".join(
            f'<td class="{"angle " if at == 0 else ""}{knee.name}">{cell}</td>'
            for knee, cell in zip(film.knees, cells, strict=True)
        )
        rows += f'<tr><th scope="row">{name}</th>{told}</tr>'
    return f"<table><thead><tr><th></th>{head}</tr></thead><tbody>{rows}</tbody></table>\n"


def _origin(result: SearchResult) -> str:
    """Return where the result comes from and how to get it again."""
    lines = []
    if isinstance(result.model, Knee):
        lines += [knee_footer(result.model), _PAPER]
        lines.append(f"Bounds: {_bounds(result.model)}.")
    command = command_line(result)
    again = f"<p>The same again: <code>{escape(command)}</code></p>" if command else ""
    versions = ", ".join(f"{name} {version}" for name, version in result.versions.items())
    told = "".join(f"<p>{escape(line)}</p>" for line in [*lines, f"Computed with {versions}."])
    return f'<footer class="faint">\n{told}{again}\n</footer>\n'


def _bounds(knee: Knee) -> str:
    space = knee.space
    if space.half_ranges is not None:
        return "each parameter's own, as the knee file gives them"
    return (
        f"{space.geometry_bound_mm:g} mm for each coordinate and length, "
        f"{space.slope_bound_deg:g}\u00b0 for the plateau's slope, "
        f"{space.material_bound_percent:g} % for the material"
    )

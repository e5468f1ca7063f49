"""The paper's Figures 1 to 4 for a result: PNG for people, SVG for print.

Colours mean the same everywhere (Okabe-Ito, safe for colour-blind readers): the baseline grey,
model 1 blue, model 2 orange.
"""

import io
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from kneecore.knee.parameters import LIGAMENTS, N_PARAMETERS, NAMES
from kneecore.knee.physics.forces import THETA_0
from kneecore.knee.response import MOMENT, Response
from kneecore.knee.space import ParameterSpace

if TYPE_CHECKING:
    from kneecore.search.result import SearchResult

FloatArray = NDArray[np.float64]

COLOURS = {"baseline": "#8c8c8c", "model_1": "#0072B2", "model_2": "#D55E00"}
LABELS = {"baseline": "baseline", "model_1": "model 1", "model_2": "model 2"}
_ORDER = np.argsort(-MOMENT)
REST_DEG = float(np.degrees(THETA_0))
STYLE: dict[Any, Any] = {
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "figure.dpi": 150,
    "font.size": 9,
    "grid.alpha": 0.25,
    "legend.frameon": False,
    "svg.hashsalt": "kneecore",
}


def rests_unloaded(space: ParameterSpace, rest_length: str) -> bool:
    """Tell whether all knees of a space are at rest without load in the load-free pose.

    Not those with the baseline's rest lengths, or with lengths that are uncertain themselves.
    """
    return rest_length == "recomputed" and len(space.lower) == N_PARAMETERS


def along(values: FloatArray, through_rest: bool, at_rest: float = REST_DEG) -> FloatArray:
    """Return values in the order of the motion, with that of the load-free pose between.

    Nothing is put in where knees are under load in that pose.
    """
    ordered = values[_ORDER]
    return np.insert(ordered, len(MOMENT) // 2, at_rest) if through_rest else ordered


def _curve(
    response: Response, values: FloatArray, through_rest: bool
) -> tuple[FloatArray, FloatArray]:
    """Return (angles in deg, values) along the motion."""
    return along(np.degrees(response.flexion), through_rest), along(values, through_rest, 0.0)


def _draw(axes: Axes, result: "SearchResult", values: dict[str, FloatArray]) -> None:
    for name, response in result.models.items():
        if response.status == "failed":
            continue
        axes.plot(
            *_curve(response, values[name], rests_unloaded(result.space, result.rest_length)),
            marker="o",
            markersize=3,
            linewidth=1.6,
            color=COLOURS[name],
            label=LABELS[name],
            zorder=3,
        )
    axes.axvline(0.0, color="0.5", linewidth=0.8, linestyle=":")
    axes.set_xlabel("knee angle, deg (flexion > 0)")


def _moment_angle(result: "SearchResult") -> Figure:
    figure = Figure(figsize=(6.0, 4.2), layout="constrained")
    axes = figure.add_subplot()
    if result.training_flexion is not None:
        through_rest = rests_unloaded(result.space, result.rest_length)
        for row, flexion in enumerate(np.degrees(result.training_flexion)):
            axes.plot(
                along(flexion, through_rest),
                along(MOMENT, through_rest, 0.0),
                color="0.8",
                linewidth=0.6,
                label="training samples" if row == 0 else None,
                zorder=1,
            )
    _draw(axes, result, dict.fromkeys(result.models, MOMENT))
    axes.axhline(0.0, color="0.5", linewidth=0.8)
    axes.set_ylabel("external moment, N m (extension > 0)")
    axes.set_title("Moment against angle")
    axes.legend()
    return figure


def _draw_geometry(axes: Axes, x: FloatArray, response: Response, name: str) -> None:
    """Draw circle, plateau line and ligaments at the load-free pose, femur frame, mm."""
    value = dict(zip(NAMES, 1e3 * x[:N_PARAMETERS], strict=True))
    style: dict[str, Any] = {"color": COLOURS[name], "linewidth": 1.4}
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    axes.plot(
        value["condyle_x"] + value["condyle_radius"] * np.cos(turn),
        value["condyle_y"] + value["condyle_radius"] * np.sin(turn),
        label=LABELS[name],
        **style,
    )
    cos, sin = np.cos(-THETA_0), np.sin(-THETA_0)
    turned = np.array([[cos, -sin], [sin, cos]])
    origin = 1e3 * response.load_free_position
    slope = x[NAMES.index("plateau_slope")]
    along = np.array([np.cos(slope), np.sin(slope)])
    point = np.array([value["plateau_x"], value["plateau_y"]])
    ends = np.array([point + s * along for s in (-30.0, 25.0)]) @ turned.T + origin
    axes.plot(*ends.T, **style)
    for ligament in LIGAMENTS:
        femur = np.array([value[f"{ligament}_femur_{axis}"] for axis in "xy"])
        tibia = np.array([value[f"{ligament}_tibia_{axis}"] for axis in "xy"])
        both = np.array([femur, turned @ tibia + origin])
        axes.plot(*both.T, marker="o", markersize=3, linestyle="--", **style)
        if name == "baseline":
            axes.annotate(
                ligament.upper(),
                both[1],
                xytext=(9, -10),
                textcoords="offset points",
                fontsize=8,
                color="0.2",
                bbox={"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none"},
                zorder=5,
            )


def _geometry(result: "SearchResult") -> Figure:
    figure = Figure(figsize=(5.2, 5.6), layout="constrained")
    axes = figure.add_subplot()
    knees = zip(result.models.items(), (result.space.baseline, *result.x), strict=True)
    for (name, response), x in knees:
        _draw_geometry(axes, x, response, name)
    axes.set_aspect("equal")
    axes.set_xlabel("anterior, mm")
    axes.set_ylabel("proximal, mm")
    axes.set_title(f"Geometry in the load-free pose ({np.degrees(THETA_0):.2f} deg)")
    axes.legend(loc="lower right")
    return figure


def _ligament_forces(result: "SearchResult") -> Figure:
    figure = Figure(figsize=(7.2, 5.4), layout="constrained")
    grid = figure.subplots(2, 2, sharex=True, sharey=True)
    for i, (axes, ligament) in enumerate(zip(grid.flat, LIGAMENTS, strict=True)):
        _draw(axes, result, {n: r.tension[:, i] for n, r in result.models.items()})
        axes.set_title(ligament.upper())
        axes.set_ylabel("tension, N")
    grid[0, 0].legend()
    return figure


def _ap_position(result: "SearchResult") -> Figure:
    figure = Figure(figsize=(6.0, 4.2), layout="constrained")
    axes = figure.add_subplot()
    for name, response in result.models.items():
        angles = np.degrees(response.flexion[_ORDER])
        axes.plot(
            angles,
            1e3 * response.ap_position[_ORDER],
            marker="o",
            markersize=3,
            linewidth=1.6,
            color=COLOURS[name],
            label=LABELS[name],
        )
    axes.axvline(0.0, color="0.5", linewidth=0.8, linestyle=":")
    axes.set_xlabel("knee angle, deg (flexion > 0)")
    axes.set_ylabel("contact position on the plateau, mm (anterior > 0)")
    axes.set_title("Anterior-posterior displacement")
    axes.legend()
    return figure


_FIGURES = {
    "figure_1_moment_angle": _moment_angle,
    "figure_2_geometry": _geometry,
    "figure_3_ligament_forces": _ligament_forces,
    "figure_4_ap_displacement": _ap_position,
}
_REPAIR, _CONVERGENCE = "figure_5_repair", "figure_6_convergence"
FIGURE_FILES = tuple(
    f"{n}.{ending}" for n in (*_FIGURES, _REPAIR, _CONVERGENCE) for ending in ("png", "svg")
)
"""Names of the files that `render_figures` gives."""


_UNDATED: dict[str, dict[str, Any]] = {"png": {"Software": None}, "svg": {"Date": None}}
"""Metadata of each kind of file that would change from run to run, left out."""


def draw_figures(result: "SearchResult") -> dict[str, Figure]:
    """Return the four figures, and those of a repair and of rivals, by name without an ending."""
    # It takes its style from here.
    from kneecore.figures.evidence import convergence_figure, repair_figure

    with mpl.rc_context(STYLE):
        drawn = {name: draw(result) for name, draw in _FIGURES.items()}
    if result.repair is not None:
        drawn[_REPAIR] = repair_figure(result.repair)
    if result.rivals:
        drawn[_CONVERGENCE] = convergence_figure(result)
    return drawn


def render(
    figures: Mapping[str, Figure], endings: Sequence[str] = tuple(_UNDATED)
) -> Iterator[tuple[str, bytes]]:
    """Yield (file name, content) of each figure as PNG and as SVG; the bytes are reproducible."""
    for name, figure in figures.items():
        for ending in endings:
            buffer = io.BytesIO()
            with mpl.rc_context(STYLE):
                figure.savefig(buffer, format=ending, metadata=_UNDATED[ending])
            yield f"{name}.{ending}", buffer.getvalue()


def render_figures(result: "SearchResult") -> Iterator[tuple[str, bytes]]:
    """Yield (file name, content) of a result's figures."""
    yield from render(draw_figures(result))

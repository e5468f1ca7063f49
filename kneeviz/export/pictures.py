"""The knees and their curves as pictures: one moment as PNG, the motion as GIF."""

import io
from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from matplotlib.transforms import Affine2D
from PIL import Image

from kneecore import Cancelled, Progress, SearchResult
from kneecore.figures.style import COLOURS, LABELS, styled
from kneecore.progress import Callback
from kneeviz.export.film import Film, Filmed
from kneeviz.geometry.bones import bones
from kneeviz.geometry.mechanism import TAUT_TENSION, condyle, plateau_line
from kneeviz.views import theme
from kneeviz.views.scene.body import ligament_width

_SIZE = (9.6, 5.0)  # inches
_DPI_PNG, _DPI_GIF = 200, 90
_FRAME_MS = 60
_REST_MS = 900
_COLOURS = 64
"""Of the animation: flat areas need no more."""
_OWN = theme.LIGHT


def png(result: SearchResult, film: Film, share: float = 0.0) -> bytes:
    """Return the knees at a share of the motion, 0 at full extension, and their curves."""
    written = io.BytesIO()
    with styled():
        stage = _Stage(result, film)
        stage.show(round(share * (len(film.moment) - 1)))
        stage.figure.savefig(written, format="png", dpi=_DPI_PNG, metadata={"Software": None})
    return written.getvalue()


def gif(result: SearchResult, film: Film, callback: Callback | None = None) -> bytes:
    """Return the motion there and back as an animated GIF that goes on for ever.

    Raises
    ------
    Cancelled
        If `callback` asked to stop.
    """
    drawn = []
    with styled():
        stage = _Stage(result, film)
        for k in range(len(film.moment)):
            told = Progress(stage="drawing frames", done=k, total=len(film.moment))
            if callback is not None and callback(told):
                raise Cancelled
            stage.show(k)
            drawn.append(stage.image())
    # One palette for all frames, so that no colour flickers.
    palette = drawn[len(drawn) // 2].quantize(_COLOURS, dither=Image.Dither.NONE)
    flat = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in drawn]
    order = [*flat, *flat[-2:0:-1]]
    rests = {0: _REST_MS, len(flat) - 1: _REST_MS}
    written = io.BytesIO()
    order[0].save(
        written,
        format="GIF",
        save_all=True,
        append_images=order[1:],
        duration=[rests.get(k, _FRAME_MS) for k in range(len(order))],
        loop=0,
        optimize=False,
    )
    return written.getvalue()


class _Stage:
    """A figure whose knees and dots can be put where a frame has them."""

    def __init__(self, result: SearchResult, film: Film) -> None:
        self._film = film
        self.figure = Figure(figsize=_SIZE, dpi=_DPI_GIF, layout="constrained")
        self._canvas: Any = FigureCanvasAgg(self.figure)
        self.figure.suptitle(result.summary(), fontsize=11)
        left, right = self.figure.subplots(1, 2, width_ratios=(1.0, 1.05))
        self._moment = left.set_title("", fontsize=9)
        _femur(left)
        self._bodies = [_Body(left, knee, layer) for layer, knee in enumerate(film.knees)]
        _frame_knees(left, film)
        self._dots = [_curve(right, knee) for knee in film.knees]
        _label_chart(right, film)

    def show(self, k: int) -> None:
        """Move to frame `k`."""
        self._moment.set_text(f"external moment {self._film.moment[k]:+.2f} N m")
        for body in self._bodies:
            body.show(k)
        for knee, dot in zip(self._film.knees, self._dots, strict=True):
            dot(knee.angle_deg[k], self._film.moment[k])

    def image(self) -> Image.Image:
        """Return what is shown now."""
        self._canvas.draw()
        return Image.fromarray(np.asarray(self._canvas.buffer_rgba())).convert("RGB")


class _Body:
    """One knee without its femur."""

    def __init__(self, axes: Axes, knee: Filmed, layer: int) -> None:
        self._axes, self._knee = axes, knee
        self._own, hue = knee.name == "baseline", COLOURS[knee.name]
        depth = 1.0 if self._own else 3.0 + layer
        self._moving: list[Artist] = []
        for bone in bones():
            if bone.frame == "tibia":
                fill = _own_colour(_OWN.fibula if bone.name == "fibula" else _OWN.bone)
                patch = Polygon(
                    1e3 * bone.outline,
                    facecolor=fill if self._own else (hue, 0.26),
                    edgecolor=_own_colour(_OWN.rim) if self._own else hue,
                    linewidth=0.9,
                    zorder=depth,
                )
                self._moving.append(axes.add_patch(patch))
        plateau = 1e3 * plateau_line(knee.sweep.x)
        edge = _own_colour(_OWN.mechanism) if self._own else hue
        self._moving += axes.plot(*plateau.T, color=edge, linewidth=0.9, zorder=depth + 0.1)
        centre, radius = condyle(knee.sweep.x)
        axes.add_patch(
            Circle(
                tuple(1e3 * centre), 1e3 * radius, fill=False, color=edge, linewidth=0.9, zorder=7
            )
        )
        self._ligaments = LineCollection([], capstyle="round", zorder=8.0 + layer)
        axes.add_collection(self._ligaments, autolim=False)
        self._hue = hue

    def show(self, k: int) -> None:
        """Put the knee where frame `k` has it."""
        pose = self._knee.poses[k]
        x, y = self._knee.tibia_mm[k]
        place = Affine2D().rotate(-pose.flexion).translate(x, y) + self._axes.transData
        for artist in self._moving:
            artist.set_transform(place)
        self._ligaments.set_segments(list(self._knee.ligaments_mm[k]))
        slack = pose.tension < TAUT_TENSION
        widths = [ligament_width(float(t)) for t in pose.tension]
        if self._own:
            hues = np.where(slack, "#b2b2b2", np.array(theme.LIGAMENT_COLOURS))
            self._ligaments.set_color(list(hues))
            self._ligaments.set_linewidth([0.42 * width for width in widths])
        else:  # two more knees: their slack ligaments would only clutter
            self._ligaments.set_color(self._hue)
            shown = zip(widths, pose.tension >= TAUT_TENSION, strict=True)
            self._ligaments.set_linewidth([0.3 * width * taut for width, taut in shown])


def _own_colour(colour: theme.RGB) -> tuple[float, float, float]:
    red, green, blue = (channel / 255.0 for channel in colour)
    return red, green, blue


def _femur(axes: Axes) -> None:
    femur = next(bone for bone in bones() if bone.frame == "femur")
    axes.add_patch(
        Polygon(
            1e3 * femur.outline,
            facecolor=_own_colour(_OWN.bone),
            edgecolor=_own_colour(_OWN.rim),
            linewidth=0.9,
            zorder=2.0,
        )
    )


def _frame_knees(axes: Axes, film: Film) -> None:
    left, right, bottom, top = film.window_mm()
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    axes.set_axis_off()


def _curve(axes: Axes, knee: Filmed) -> Callable[[float, float], None]:
    """Draw a knee's curve; return what puts its dot."""
    hue = COLOURS[knee.name]
    axes.plot(
        np.degrees(knee.sweep.flexion),
        knee.sweep.moment,
        color=hue,
        linewidth=1.8,
        label=LABELS[knee.name],
    )
    (dot,) = axes.plot([], [], "o", color=hue, markeredgecolor="white", markersize=8, zorder=5)
    return lambda angle, moment: dot.set_data([angle], [moment])


def _label_chart(axes: Axes, film: Film) -> None:
    axes.axvline(0.0, color="0.5", linewidth=0.8, linestyle=":")
    axes.axhline(0.0, color="0.5", linewidth=0.8)
    axes.set_xlabel("knee angle, deg (flexion > 0)")
    axes.set_ylabel("external moment, N m (extension > 0)")
    axes.legend()

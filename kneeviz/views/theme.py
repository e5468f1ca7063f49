"""Colours and small text helpers: one colour has one meaning in scene, curves and tables.

The hues are Okabe and Ito's, which people with the common colour-vision deficiencies can tell
apart; only greys and near-blacks change between the light and the dark theme.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

RGB = tuple[int, int, int]

MODEL_1 = "#0072B2"
"""The worst case that over-extends."""
MODEL_2 = "#D55E00"
"""The worst case that cannot extend."""
SURROGATE = "#CC79A7"
LIGAMENT_COLOURS = ("#009E73", "#8E3BA8", "#C79A00", "#C2185B")
"""ACL, PCL, MCL, LCL when taut."""
LIGAMENT_LABELS = ("ACL", "PCL", "MCL", "LCL")
_OTHER_GROUPS = {"condyle": "#B07D3C", "plateau": "#7A5C3A"}


@dataclass(frozen=True, kw_only=True)
class Palette:
    """The colours that depend on the theme."""

    current: str
    """The visitor's knee, in curves and tables."""
    baseline: str
    training: str
    surrogate: str
    band: str
    """The sampling band's fill."""
    band_edge: str
    genetic: str
    """The genetic algorithm in the true model."""
    exact: str
    """The search by exact gradients."""
    repair: str
    """The surrogate that repairs itself."""
    model_1: str
    model_2: str
    ghost: str
    """The visitor's earlier knees."""
    zero: str
    """The line of zero flexion."""
    beyond: str
    """The shade over over-extension."""
    text: str
    ground: str
    """The panels', behind all text."""
    faint: str
    rule: str
    bone: RGB
    rim: RGB
    fibula: RGB
    slack: RGB
    mechanism: RGB
    arrow: RGB
    contact: RGB
    handle: RGB
    """Boxes of bounds, and the handles of circle and plateau."""
    size: float = 1.0
    """How much larger lines, dots and their text are than at a desk."""


LIGHT = Palette(
    current="#222222",
    baseline="#999999",
    training="rgba(120,120,120,0.20)",
    surrogate="#B0528A",
    band="rgba(40,130,150,0.22)",
    band_edge="rgba(40,130,150,0.55)",
    genetic="#6b6b6b",
    exact="#1c7f92",
    repair="#7A4FA3",
    model_1=MODEL_1,
    model_2=MODEL_2,
    ghost="#66727d",
    zero="rgba(60,60,60,0.55)",
    beyond="rgba(200,120,60,0.10)",
    text="#222222",
    ground="#ffffff",
    faint="#6b6b6b",
    rule="#e3e3e3",
    bone=(255, 228, 174),
    rim=(178, 146, 98),
    fibula=(255, 240, 212),
    slack=(118, 118, 118),
    mechanism=(110, 96, 74),
    arrow=(60, 60, 60),
    contact=(255, 176, 0),
    handle=(60, 60, 60),
)
DARK = Palette(
    current="#f2f2f2",
    baseline="#8f8f8f",
    training="rgba(190,190,190,0.18)",
    surrogate="#E29BC4",
    band="rgba(110,190,205,0.26)",
    band_edge="rgba(110,190,205,0.60)",
    genetic="#a5a5a5",
    exact="#6ec3d2",
    repair="#B99AE0",
    model_1="#4AA8E0",
    model_2="#F0813A",
    ghost="#98a5b1",
    zero="rgba(220,220,220,0.55)",
    beyond="rgba(240,150,90,0.12)",
    text="#eaeaea",
    ground="#242424",
    faint="#a5a5a5",
    rule="#3a3a3a",
    bone=(206, 194, 166),
    rim=(120, 104, 78),
    fibula=(150, 142, 124),
    slack=(122, 122, 122),
    mechanism=(150, 105, 50),
    arrow=(250, 250, 250),
    contact=(255, 190, 40),
    handle=(30, 115, 135),
)


CLASS_SIZE = 1.3
"""How much larger everything is for a class, which looks from afar."""
CLASS_WIDER = 1.2
"""The same of the panels: less than the text that they hold, for the picture needs its room."""


def palette(dark: bool, *, large: bool = False) -> Palette:
    """Return the colours of the light or the dark theme, at a desk's size or large for a class."""
    colours = DARK if dark else LIGHT
    return replace(colours, size=CLASS_SIZE) if large else colours


CONTRAST = 4.5
"""WCAG's least contrast of text with its ground (AA)."""


def luminance(colour: RGB) -> float:
    """Return a colour's relative luminance as WCAG defines it, 0 (black) to 1 (white)."""
    parts = (part / 255.0 for part in colour)
    linear = [p / 12.92 if p <= 0.03928 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: str, two: str) -> float:
    """Return WCAG's contrast of two colours ``#rrggbb``, 1 to 21."""
    low, high = sorted(luminance(rgb(colour)) for colour in (one, two))
    return (high + 0.05) / (low + 0.05)


def readable(hue: str, ground: str) -> str:
    """Return `hue` so far towards black or white that it can be read on `ground`."""
    end: RGB = (0, 0, 0) if luminance(rgb(ground)) > 0.5 else (255, 255, 255)
    shades = (_hex(mix(rgb(hue), end, step / 20.0)) for step in range(21))
    return next(shade for shade in shades if contrast(shade, ground) >= CONTRAST)


def ink(hue: str) -> str:
    """Return `hue` as CSS for text, which can be read in the theme that the browser shows."""
    return f"light-dark({readable(hue, LIGHT.ground)}, {readable(hue, DARK.ground)})"


def _hex(colour: RGB) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)


_FADES = {
    "knee": ("current", "bone", "rim", "fibula", "mechanism"),
    "worst": ("model_1", "model_2"),
    "landscape": ("current", "surrogate", "training", "model_1", "model_2"),
}
"""The colours of what may belong to a state that is over."""
_GREY: RGB = (150, 150, 150)
_FADED = 0.72  # so far towards grey: the two models can still be told apart


def faded(colours: Palette, subjects: frozenset[str]) -> Palette:
    """Return `colours` with those of some subjects (`_FADES`) turned towards grey."""
    names = {name for subject in subjects for name in _FADES[subject]}
    turned: dict[str, Any] = {name: _greyed(getattr(colours, name)) for name in names}
    return replace(colours, **turned)


def _greyed(colour: str | RGB) -> str | RGB:
    if not isinstance(colour, str):
        return mix(colour, _GREY, _FADED)
    if not colour.startswith("#"):  # it is pale already
        return colour
    return _hex(mix(rgb(colour), _GREY, _FADED))


def group_colour(group: str, colours: Palette) -> str:
    """Return the hue of a group of parameters: a ligament's own, bone, or grey for material."""
    if group.upper() in LIGAMENT_LABELS:
        return LIGAMENT_COLOURS[LIGAMENT_LABELS.index(group.upper())]
    return _OTHER_GROUPS.get(group, colours.baseline)


def rgb(hex_colour: str) -> RGB:
    """Return ``#rrggbb`` as three integers."""
    value = int(hex_colour.lstrip("#"), 16)
    return value >> 16, value >> 8 & 255, value & 255


def mix(a: RGB, b: RGB, share: float) -> RGB:
    """Return the colour that lies `share` of the way from `a` to `b`."""
    part = min(max(share, 0.0), 1.0)
    red, green, blue = (round(p + part * (q - p)) for p, q in zip(a, b, strict=True))
    return red, green, blue


def handle_colour(colour: RGB) -> NDArray[np.uint8]:
    """Return a colour in the form that line handles take after their creation."""
    return np.array(colour, dtype=np.uint8)


BRAND: RGB = (27, 72, 105)
"""Of which viser makes the colours of its buttons and tabs."""
VISER_TEXTS = """<style>
:root {
  --mantine-color-dimmed: #5f6973 !important; --mantine-color-gray-filled: #5f6973 !important;
}
:root[data-mantine-color-scheme="dark"] {
  --mantine-color-dimmed: #a3a3a3 !important; --mantine-color-gray-filled: #343a40 !important;
}
.mantine-Slider-markLabel, .mantine-Notification-description {
  color: var(--mantine-color-dimmed) !important
}
:root[data-mantine-color-scheme="dark"] [role="tab"][aria-selected="true"] * {
  color: #7db8e0 !important;
}
</style>"""
"""viser's own labels, grey buttons and open tabs, which are paler than one can read."""


def large_text() -> str:
    """Return the style that enlarges the panels' content.

    The charts are left out: they draw their own text, and a pointer over an enlarged one would
    read the wrong place.
    """
    content = 'div[style*="cursor: grab"] + div[style*="flex-grow: 1"] > *'
    return (
        f"<style>{content} {{ zoom: {CLASS_SIZE}; width: 100% !important }}"
        f"{content} {content} {{ zoom: 1 }}"
        f".uplot-container {{ zoom: calc(1 / {CLASS_SIZE}) }}"
        f":root {{ --kneeviz-size: {CLASS_SIZE} }}</style>"
    )


ON_A_PHONE = """<style>
.mantine-Paper-root[style*="max-height: 60%"] { max-height: 50% !important; width: 100% !important }
.mantine-Paper-root[style*="max-height: 60%"] [style*="width: 20em"] { width: 100% !important }
body:has(.mantine-Paper-root[style*="max-height: 60%"])
  div[style*="flex-grow: 1"]:has(> div > div > div > canvas),
body:has(.mantine-Paper-root[style*="max-height: 60%"])
  div[style*="flex-grow: 1"]:has(> div > div > div > div > canvas) {
  height: 50% !important; flex: 0 0 100% !important;
}
</style>"""
"""The picture keeps the upper half; viser lays the panels over three fifths of it."""

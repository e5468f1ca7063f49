"""What can be read: sizes, contrast, labels, and one way to write numbers."""

import re
from itertools import combinations

import numpy as np
import pytest

import kneecore
from kneeviz.geometry.mechanism import ligament_segments
from kneeviz.geometry.sweep import sweep_of
from kneeviz.views import theme
from kneeviz.views.charts import styles
from kneeviz.views.html import pieces
from kneeviz.views.scene.labels import label_box, label_spots, leaders

VISERS_TEXT = {"#ffffff": "#000000", "#242424": "#c9c9c9"}
"""What viser writes with on its panels."""


def sizes(colours):
    """Widths of lines, sizes of dots and of the charts' text, in px."""
    axis = styles.axis_style("", side=2, scale="x", size=30, colours=colours)
    return [
        *(line["width"] for line in styles.knee_lines(colours, "°")),
        *(dot["points"]["size"] for dot in styles.dots(colours)),
        float(axis["font"].split("px")[0]),
        float(axis["labelFont"].split("px")[0]),
    ]


@pytest.mark.parametrize("dark", [False, True])
def test_a_class_sees_every_line_dot_and_number_of_a_chart_larger(dark):
    desk, large = sizes(theme.palette(dark)), sizes(theme.palette(dark, large=True))
    assert large == pytest.approx([theme.CLASS_SIZE * size for size in desk])


HUES = [
    *(getattr(theme.LIGHT, name) for name in ("current", "baseline", "surrogate", "model_1")),
    *(getattr(theme.DARK, name) for name in ("baseline", "genetic", "exact", "repair", "model_2")),
    theme.MODEL_2,
    *theme.LIGAMENT_COLOURS,
]


@pytest.mark.parametrize("hue", HUES)
def test_coloured_text_can_be_read_in_both_themes(hue):
    inks = re.findall("#[0-9a-f]{6}", pieces.coloured("x", hue))
    for ink, colours in zip(inks, (theme.LIGHT, theme.DARK), strict=True):
        assert theme.contrast(ink, colours.ground) >= 4.5


def test_a_hue_that_can_be_read_stays_as_it_is():
    assert theme.readable("#8e3ba8", "#ffffff") == "#8e3ba8"


def test_contrast_is_wcags():
    assert theme.contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert theme.contrast("#767676", "#ffffff") == pytest.approx(4.54, abs=0.01)


@pytest.mark.parametrize("colours", [theme.LIGHT, theme.DARK])
def test_plain_and_faint_text_can_be_read(colours):
    share = float(re.search("opacity:([.0-9]+)", pieces.faint("x"))[1])
    ground, text = theme.rgb(colours.ground), theme.rgb(VISERS_TEXT[colours.ground])
    faint = "#{:02x}{:02x}{:02x}".format(*theme.mix(ground, text, share))
    for ink in (colours.text, colours.faint, faint):
        assert theme.contrast(ink, colours.ground) >= 4.5


CLOSE = 0.012
"""m between a label's box and its ligament."""


@pytest.fixture(scope="module")
def baseline():
    x = kneecore.packaged_knee().baseline
    return x, sweep_of(x, kneecore.simulate(x))


@pytest.mark.parametrize("forces", [False, True])
@pytest.mark.parametrize("size", [1.0, theme.CLASS_SIZE])
@pytest.mark.parametrize("share", np.linspace(0.0, 1.0, 20))
def test_labels_stand_at_their_ligament_and_clear_of_each_other(baseline, share, size, forces):
    x, sweep = baseline
    segments = ligament_segments(x, sweep.at_moment(sweep.moment_at(share)))
    box = np.array(label_box(forces=forces, size=size))
    spots = label_spots(segments, tuple(box))
    for spot, (start, end) in zip(spots, segments, strict=True):
        points = start + np.linspace(0.0, 1.0, 101)[:, None] * (end - start)
        outside = np.maximum(np.abs(points - spot) - 0.5 * box, 0.0)
        assert np.hypot(*outside.T).min() < CLOSE * size
    for i, j in combinations(range(4), 2):
        assert (np.abs(spots[i] - spots[j]) >= box - 1e-6).any()


def test_a_label_is_led_to_the_nearest_point_of_its_ligament():
    segments = np.array([[[0.0, 0.0], [1.0, 0.0]]] * 2)
    lines = leaders(np.array([[0.3, 0.4], [1.4, 0.3]]), segments)
    np.testing.assert_allclose(lines[:, 1], [[0.3, 0.0], [1.0, 0.0]])


def test_dots_that_coincide_can_be_told_apart():
    ring, one, two = (dot["points"] for dot in styles.dots(theme.LIGHT))
    assert ring["size"] - 2.0 * ring["width"] >= one["size"]  # nothing is hidden under the next
    assert one["size"] > two["size"]
    assert ring["fill"] == "rgba(0,0,0,0)"


def test_a_reports_words_are_written_as_the_pages_numbers():
    told = pieces.plain("At +5 N m model 1 over-extends to -23.5 deg, 1e-6 <b>of</b> 3-5 degrees")
    assert told == (
        "At +5 N·m model 1 over-extends to \u221223.5°, 1e-6 &lt;b&gt;of&lt;/b&gt; 3-5 degrees"
    )

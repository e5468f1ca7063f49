"""What can be read: sizes, contrast, labels, and one way to write numbers."""

import pytest

from kneeviz.views import theme
from kneeviz.views.charts import styles


def sizes(colours):
    """Widths of lines, sizes of dots and of the charts' text, in px."""
    axis = styles.axis_style("", side=2, scale="x", size=30, colours=colours)
    return [
        *(line["width"] for line in styles.knee_lines(colours)),
        *(dot["points"]["size"] for dot in styles.dots(colours)),
        float(axis["font"].split("px")[0]),
        float(axis["labelFont"].split("px")[0]),
    ]


@pytest.mark.parametrize("dark", [False, True])
def test_a_class_sees_every_line_dot_and_number_of_a_chart_larger(dark):
    desk, large = sizes(theme.palette(dark)), sizes(theme.palette(dark, large=True))
    assert large == pytest.approx([theme.CLASS_SIZE * size for size in desk])

"""What a class sees from afar."""

import pytest

from kneeviz.jobs.messages import Asked
from kneeviz.views import theme

SIZES = """() => [...document.querySelectorAll('label, [role=tab], b')]
    .filter(e => e.offsetParent && e.textContent.trim())
    .map(e => e.getBoundingClientRect().height)"""


def test_class_size_enlarges_text_and_leaves_the_charts_pointer_right(visitor, app):
    page = app.page
    visitor.tab("Curve")
    desk = visitor.page.evaluate(SIZES)
    page.post("large", Asked(None, -1, True))
    try:
        visitor.wait_until(lambda: max(visitor.page.evaluate(SIZES)) > max(desk))
        large = visitor.page.evaluate(SIZES)
        assert len(large) == len(desk)
        assert min(b / a for a, b in zip(desk, large, strict=True)) > 0.95 * theme.CLASS_SIZE
        over = visitor.page.locator(".u-over").first
        box = over.bounding_box()
        visitor.page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
        left = visitor.page.evaluate(
            "id => { const c = window.__viserTestpoints.uplots[id].chart;"
            " return c.cursor.left / c.over.clientWidth; }",
            page.view.curve.handle._impl.uuid,
        )
        assert left == pytest.approx(0.5, abs=0.02)
    finally:
        page.post("large", Asked(None, -1, False))
        visitor.wait_until(lambda: max(visitor.page.evaluate(SIZES)) == pytest.approx(max(desk)))

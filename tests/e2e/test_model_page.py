"""A model of one's own in a browser: its sliders, curves, picture and worst pair."""

import models
import pytest
from e2e.conftest import Visitor, eventually

from kneeviz.anymodel import state
from kneeviz.server.app import App

READY = """() => window.__viserMutable?.nodeRefFromName?.['/model/own'] != null
    && Object.keys(window.__viserTestpoints?.uplots ?? {}).length > 0"""


class ModelVisitor(Visitor):
    def open(self):
        self.page.goto(self.url)
        self.page.wait_for_function(READY, timeout=60_000)


@pytest.fixture(scope="module")
def shown(chromium):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(state, "FAST_SECONDS", 5.0)  # fast also where the machine is busy
        app = App(port=0, model=models.slider_crank())
        try:
            eventually(lambda: app.page.state.surrogate is not None)
            visitor = ModelVisitor(chromium, app.url)
            yield app.page, visitor
            assert visitor.errors == []
            visitor.close()
        finally:
            app.stop()


def curve(visitor, page):
    return visitor.curve(page.view.charts.charts[0].handle._impl.uuid)


def test_a_slider_moves_curve_and_picture_and_a_key_finds_the_worst_pair(shown):
    page, visitor = shown
    visitor.thumb("crank (mm)").press("Home")
    eventually(lambda: page.state.x[0] == 49.0)
    expected = models.slider_crank_y(page.state.x)[:5]
    visitor.wait_until(lambda: curve(visitor, page)[4] == pytest.approx(expected))
    assert curve(visitor, page)[6] == [None] * 5
    visitor.page.evaluate("document.activeElement?.blur()")
    visitor.page.keyboard.press("w")
    visitor.wait_until(lambda: page.state.result is not None)
    visitor.wait_until(lambda: curve(visitor, page)[6] == pytest.approx(page.state.result.y[0, :5]))
    visitor.tab("Search")
    visitor.page.get_by_text("Verdict:").wait_for()
    visitor.wait("name => window.__viserMutable.nodeRefFromName[name].visible", "/model/worst_1")
    before = visitor.pixels(page.view.charts.charts[0].handle._impl.uuid)
    visitor.page.keyboard.press("d")
    eventually(lambda: page.view.dark)
    visitor.wait_until(
        lambda: visitor.pixels(page.view.charts.charts[0].handle._impl.uuid) != before
    )
    assert curve(visitor, page)[4] == pytest.approx(expected)

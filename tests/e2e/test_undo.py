"""Undo by keys and buttons, as a visitor has them, and a word about what was limited."""

import pytest
from e2e.conftest import eventually

from kneecore import NAMES
from kneeviz.state import saved

ACL_X = NAMES.index("acl_femur_x")
CANVAS = (640, 690)  # a free place between the panels


@pytest.fixture
def fresh(visitor, app):
    """The visitor's page as it began, and its state's text."""
    page = app.page
    page.post("start_over")
    eventually(lambda: page.snapshot().same_as(page.history.start))
    eventually(lambda: not page.animation.morphing)
    page.begin()
    yield page
    page.post("start_over")
    eventually(lambda: page.snapshot().same_as(page.history.start))


def text(page):
    eventually(lambda: page.history.present.same_as(page.snapshot()))
    return saved.to_text(page.history.present)


def geometry(visitor):
    return visitor.row("Geometry, mm").locator("input:not([type='hidden'])")


def open_bounds(visitor):
    visitor.tab("Knee")
    if not geometry(visitor).is_visible():
        visitor.page.get_by_text("Bounds: how uncertain?").click()
        visitor.wait_until(lambda: geometry(visitor).is_visible())


def test_keys_and_buttons_go_back_to_the_same_bytes(visitor, fresh):
    keys, texts = visitor.page.keyboard, [text(fresh)]
    visitor.tab("Knee")
    visitor.thumb("ACL femur x").focus()
    keys.press("End")
    visitor.wait_until(lambda: fresh.state.x[ACL_X] == pytest.approx(-13e-3))
    texts.append(text(fresh))
    open_bounds(visitor)
    geometry(visitor).fill("0.5")
    visitor.wait_until(lambda: fresh.state.bounds.geometry_mm == 0.5)
    texts.append(text(fresh))
    visitor.tab("Search")
    visitor.press("Worst case (surrogate)")
    visitor.wait_until(lambda: fresh.state.result is not None)
    visitor.page.get_by_text("over-extends").first.wait_for()
    texts.append(text(fresh))
    visitor.page.mouse.click(*CANVAS)
    for wanted in texts[-2::-1]:
        keys.press("Control+z")
        visitor.wait_until(lambda w=wanted: text(fresh) == w)
    visitor.wait_until(lambda: visitor.page.get_by_text("over-extends").count() == 0)
    for wanted in texts[1:]:
        keys.press("Control+Shift+z")
        visitor.wait_until(lambda w=wanted: text(fresh) == w)
    visitor.press("Undo")
    visitor.wait_until(lambda: text(fresh) == texts[-2])
    visitor.press("Start over")
    visitor.wait_until(lambda: text(fresh) == texts[0])


def test_a_number_that_the_page_limits_is_told(visitor, fresh):
    open_bounds(visitor)
    box = geometry(visitor)
    box.fill("99")
    visitor.page.wait_for_timeout(150)  # the page sends a value every 50 ms
    box.blur()
    visitor.wait_until(lambda: fresh.state.bounds.geometry_mm == 10.0)
    visitor.page.get_by_text("Geometry, mm: 99 was limited to 10.").wait_for()

"""What a pointer over a chart is told, and which curves its legend shows."""

import pytest

from kneeviz.jobs.messages import Asked

NOTE = "() => document.querySelector('.kneeviz-note')?.innerText ?? ''"
HIDDEN = """id => {
    const { chart } = window.__viserTestpoints.uplots[id];
    return chart.series.filter((s) => !s.show).map((s) => s.key).sort();
}"""

KEEP = "id => { window.keptChart = window.__viserTestpoints.uplots[id].chart }"
IS_NEW = "id => window.__viserTestpoints.uplots[id]?.chart !== window.keptChart"


@pytest.fixture
def curve(visitor, app):
    """The id of the moment-angle chart, which is in sight; all its curves show at the end."""
    visitor.tab("Curve")
    yield app.page.view.curve.handle._impl.uuid
    visitor.page.evaluate("() => window.__kneevizHidden.clear()")


def middle(visitor, down):
    """The middle of the chart in sight, at a share of its height."""
    box = visitor.page.locator(".u-over").first.bounding_box()
    return box["x"] + 0.5 * box["width"], box["y"] + down * box["height"]


def test_the_pointer_is_told_the_values_and_poses_the_knee(visitor, app, curve):
    page = app.page
    share = page.playback.share
    visitor.page.mouse.move(*middle(visitor, 0.25), steps=2)
    visitor.wait_until(lambda: page.poses[0].moment == pytest.approx(2.8, abs=0.1))
    told = visitor.page.evaluate(NOTE).split("\n")
    assert told[0] == f"External moment: {page.poses[0].moment:.2f} N·m"
    angle = page.poses[0].flexion * 57.29577951308232
    assert f"your knee {angle:.1f}°".replace("-", "\u2212") in told
    visitor.page.mouse.move(640, 700)
    visitor.wait_until(lambda: page.playback.share == pytest.approx(share))
    assert visitor.page.evaluate(NOTE) == ""


def test_a_legends_entry_switches_its_curve_until_it_is_pressed_again(visitor, app, curve):
    page, keys = app.page, visitor.page.keyboard
    visitor.page.locator("[data-curve=surrogate]").first.click()
    entry = visitor.page.locator("[data-curve=training]").first
    entry.focus()
    keys.press("Space")
    assert not page.playback.playing  # Space is the key for play elsewhere
    off = sorted(["surrogate", *["training"] * len(page.state.training_curves)])
    visitor.wait_until(lambda: visitor.page.evaluate(HIDDEN, curve) == off)
    assert entry.get_attribute("aria-pressed") == "false"
    old = visitor.curve(curve)
    page.post("position", Asked(None, -1, 60.0))
    visitor.wait_until(lambda: visitor.curve(curve) != old)  # new numbers
    assert visitor.page.evaluate(HIDDEN, curve) == off
    visitor.page.evaluate(KEEP, curve)
    page.post("large", Asked(None, -1, True))
    visitor.wait_until(lambda: visitor.page.evaluate(IS_NEW, curve))  # a new chart
    visitor.wait_until(lambda: visitor.page.evaluate(HIDDEN, curve) == off)
    page.post("large", Asked(None, -1, False))
    entry.press("Enter")
    visitor.wait_until(lambda: visitor.page.evaluate(HIDDEN, curve) == ["surrogate"])

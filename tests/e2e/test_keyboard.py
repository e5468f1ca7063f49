"""The page without a mouse, and what one hears who does not see it."""

import pytest
from e2e.conftest import eventually

NAMELESS = """() => [...document.querySelectorAll('[role=slider], input, canvas')]
  .filter((n) => n.type !== 'hidden')
  .filter((n) => n.offsetParent !== null && !n.closest('.uplot') && !n.closest('label'))
  .filter((n) => !(n.getAttribute('aria-label') || n.labels?.length
    || n.getAttribute('aria-labelledby') || n.placeholder))
  .map((n) => n.outerHTML.slice(0, 120))"""


FOCUSED = """() => {
  const e = document.activeElement;
  return e === document.body ? "" : e.getAttribute("aria-label") ?? e.textContent.trim();
}"""


def tab_to(visitor, name, most=70):
    """Press Tab until what has that name has the focus; return the names on the way."""
    way = []
    while not way or way[-1] != name:
        assert len(way) < most, f"{name} cannot be reached by Tab: {way}"
        visitor.page.keyboard.press("Tab")
        way.append(visitor.page.evaluate(FOCUSED))
    return way


@pytest.fixture
def loaded(visitor, app):
    """The page as it is loaded, with names for all there is, and no result."""
    app.page.post("start_over")
    eventually(lambda: app.page.state.result is None)
    visitor.open()
    visitor.wait("() => document.querySelector('[aria-expanded][tabindex]')")
    visitor.wait_until(lambda: visitor.page.evaluate(NAMELESS) == [], 10)
    return visitor


def test_from_load_to_a_result_by_tab_and_enter_alone(loaded, app):
    page, keys = app.page, loaded.page.keyboard
    way = tab_to(loaded, "Search")
    order = ["Curve", "Influence", "Commands", "Position (%)", "Undo", "Knee", "Search"]
    assert [name for name in dict.fromkeys(way) if name in order] == order
    assert "" not in [name for name in way if name != way[0]]
    keys.press("Enter")
    tab_to(loaded, "Worst case (surrogate)")
    keys.press("Enter")
    loaded.wait_until(lambda: page.overlay)
    loaded.page.get_by_text("over-extends").first.wait_for()
    loaded.wait("() => document.querySelector('[aria-label=\"Show both\"]')")  # within a second
    tab_to(loaded, "Show both")
    keys.press("Space")
    loaded.wait_until(lambda: not page.overlay)
    seed = loaded.row("Seed").locator("input:not([type='hidden'])")
    assert not seed.is_visible()
    tab_to(loaded, "Settings")
    keys.press("Enter")
    loaded.wait_until(seed.is_visible)
    assert not page.playback.playing
    tab_to(loaded, "Curve")  # round and round: nothing holds the focus
    keys.press("Shift+Tab")
    assert loaded.page.evaluate(FOCUSED) != "Curve"


def test_a_whole_search_by_shortcuts(visitor, app):
    page = app.page
    eventually(lambda: page.surrogate_ready)
    keys = visitor.page.keyboard
    visitor.page.evaluate("document.activeElement?.blur()")
    playing = page.playback.playing
    keys.press("Space")
    visitor.wait_until(lambda: page.playback.playing is not playing)
    page.state.result = None
    keys.press("w")
    visitor.wait_until(lambda: page.state.result is not None and page.overlay)
    keys.press("o")
    visitor.wait_until(lambda: not page.overlay)
    keys.press("End")
    visitor.wait_until(lambda: page.playback.share == 1.0)
    keys.press("Control+k")
    keys.type("View in 3D")
    visitor.page.wait_for_timeout(300)
    keys.press("Enter")
    visitor.wait_until(lambda: page.view.scene.spatial)
    keys.press("Escape")
    visitor.page.get_by_role("dialog").wait_for(state="hidden")
    keys.press("2")
    visitor.wait_until(lambda: not page.view.scene.spatial)


def test_sliders_numbers_and_pictures_have_names(visitor):
    visitor.tab("Knee")
    visitor.wait_until(lambda: visitor.page.evaluate(NAMELESS) == [], 10)
    assert visitor.thumb("ACL femur x").get_attribute("aria-label") == "ACL femur x"
    assert visitor.page.evaluate("document.documentElement.lang") == "en"

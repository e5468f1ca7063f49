"""The page without a mouse, and what one hears who does not see it."""

from e2e.conftest import eventually

NAMELESS = """() => [...document.querySelectorAll('[role=slider], input, canvas')]
  .filter((n) => n.type !== 'hidden')
  .filter((n) => n.offsetParent !== null && !n.closest('.uplot') && !n.closest('label'))
  .filter((n) => !(n.getAttribute('aria-label') || n.labels?.length
    || n.getAttribute('aria-labelledby') || n.placeholder))
  .map((n) => n.outerHTML.slice(0, 120))"""


def test_a_whole_search_without_a_mouse(visitor, app):
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

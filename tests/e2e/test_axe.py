"""axe-core's rules on each tab of the page. What viser's client leaves out is mended in the browser
(`kneeviz.viser_scripts.name_widgets`), so that there is no finding to excuse."""

import pytest
from e2e.conftest import eventually

from kneeviz.jobs.messages import Asked

base = pytest.importorskip("axe_playwright_python.base")

RUN = """() => axe.run({
  resultTypes: ['violations'],
  // Measured in `test_legible`, on every text and in both themes.
  rules: { 'color-contrast': { enabled: false } },
}).then(({ violations }) => violations.flatMap(
  ({ impact, id, nodes }) => nodes.map(({ html }) => `${impact} ${id}: ${html.slice(0, 300)}`)))"""
TABS = (
    ("Knee", "Curve"),
    ("Search", "Forces"),
    ("Study", "AP"),
    ("Learn", "Compare"),
    ("View", "Influence"),
    ("Files", "Curve"),
)
"""A tab of each panel: both are seen at once."""


@pytest.fixture
def lesson(visitor, app):
    """The lesson's first step, revealed."""
    page = app.page
    page.post("lesson_press")
    eventually(lambda: page.lesson == 0)
    page.post("lesson_press")
    eventually(lambda: page.answers.revealed)
    yield
    page.post("lesson_turn", Asked(None, -1, "Back"))
    eventually(lambda: page.lesson is None)


def test_no_tab_has_a_finding(visitor, lesson):
    visitor.page.evaluate(base.AXE_SCRIPT)
    found = {}
    for right, left in TABS:
        visitor.tab(right)
        visitor.tab(left)
        visitor.page.wait_for_timeout(800)  # names are given every 0.7 s
        found[right, left] = visitor.page.evaluate(RUN)
    assert {tabs: told for tabs, told in found.items() if told} == {}

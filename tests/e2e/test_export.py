"""The exported pages, opened from disk without a network."""

import re

import numpy as np
import pytest
from searches import searched

from kneeviz.export.page import html_page
from kneeviz.export.sheet import html_sheet


@pytest.fixture(scope="module")
def result():
    return searched(pop_size=20, n_generations=3)


@pytest.fixture
def opened(chromium, result, tmp_path):
    path = tmp_path / "knees.html"
    path.write_text(html_page(result), encoding="utf-8")
    context = chromium.new_context(offline=True)
    page = context.new_page()
    asked, errors = [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(path.as_uri())
    yield page
    assert asked == [path.as_uri()]
    assert errors == []
    context.close()


def test_it_moves_by_itself_and_by_hand(opened, result):
    at = opened.locator("#position")
    before = float(at.input_value())
    opened.wait_for_function("(was) => Number(document.getElementById('position').value) > was",
                             arg=before)  # fmt: skip
    at.focus()
    opened.keyboard.press("End")
    assert opened.locator("#play").inner_text() == "Play"
    assert opened.locator("#now").inner_text() == "\u22125.00 N·m"
    for name, response in result.responses.items():
        told = opened.locator(f"td.angle.{name}").inner_text()
        angle = float(np.degrees(response.flexion[11]))
        assert float(told.replace("\u2212", "-").rstrip("°")) == pytest.approx(angle, abs=0.06)
    opened.get_by_role("button", name="Play").click()
    opened.wait_for_function("() => Number(document.getElementById('position').value) < 1")


def test_a_knee_can_be_hidden(opened):
    tibia = opened.locator("g.tibia.model_1")
    assert tibia.is_visible()
    opened.get_by_label("model 1").uncheck()
    assert not tibia.is_visible()
    assert not opened.locator("polyline.curve.model_1").is_visible()
    assert opened.locator("g.tibia.model_2").is_visible()


OVER_THE_EDGE = """() => [...document.querySelectorAll('body *')].filter((e) => {
  const { left, right } = e.getBoundingClientRect(), edge = document.body.getBoundingClientRect();
  return left < edge.left - 1 || right > edge.right + 1;
}).map((e) => e.outerHTML.slice(0, 80))"""


def test_the_lesson_prints_on_a4_with_the_answers_on_the_last_page(chromium):
    context = chromium.new_context(offline=True, viewport={"width": 794, "height": 1123})  # A4
    page = context.new_page()
    page.set_content(html_sheet())
    page.emulate_media(media="print")
    assert page.evaluate(OVER_THE_EDGE) == []
    printed = page.pdf(prefer_css_page_size=True)
    pages = len(re.findall(rb"/Type\s*/Page\b", printed))
    assert pages in (3, 4)  # as the machine's fonts have it
    page.add_style_tag(content=".answers { display: none }")
    without = page.pdf(prefer_css_page_size=True)
    assert len(re.findall(rb"/Type\s*/Page\b", without)) == pages - 1
    context.close()

"""What a class sees from afar."""

import pytest

from kneeviz.jobs.messages import Asked
from kneeviz.views import theme

SIZES = """() => [...document.querySelectorAll('label, [role=tab], b')]
    .filter(e => e.offsetParent && e.textContent.trim())
    .map(e => e.getBoundingClientRect().height)"""
TABS = (
    "Knee", "Search", "Study", "Learn", "View", "Files", "Forces", "AP", "Compare", "Influence",
    "Curve",
)  # fmt: skip
CHART = """([id, labelSize]) => {
  const { chart } = window.__viserTestpoints.uplots[id] ?? {};
  if (chart?.axes[0].labelSize !== labelSize || !chart.over.isConnected) return null;
  const { left, top, width, height } = chart.over.getBoundingClientRect();
  return width > 0 && height > 0 ? [left, top, width, height] : null;
}"""
"""Where a chart is drawn that has been made anew for a size of text; null until then."""
PALE = """() => {
  const rgba = text => [...text.match(/[0-9.]+/g).map(Number), 1].slice(0, 4);
  const over = (a, b) => [0, 1, 2].map(i => a[i] * a[3] + b[i] * (1 - a[3]));
  const linear = v => v <= 0.03928 * 255 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4;
  const light = c => 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);
  const found = {};
  for (const element of document.querySelectorAll('body *:not(style, script, input)')) {
    const own = [...element.childNodes].filter(node => node.nodeType === 3);
    const words = own.map(node => node.data).join('').trim();
    if (!words || !element.offsetParent || element.closest('[data-disabled], :disabled')) continue;
    const chain = [];
    for (let e = element; e; e = e.parentElement) chain.unshift(getComputedStyle(e));
    let ground = [255, 255, 255], opacity = 1;
    for (const style of chain) {
      ground = over(rgba(style.backgroundColor), ground);
      opacity *= Number(style.opacity);
    }
    const colour = rgba(chain.at(-1).color);
    const ink = over([...colour.slice(0, 3), colour[3] * opacity], ground);
    const [low, high] = [light(ink), light(ground)].sort((a, b) => a - b);
    const contrast = (high + 0.05) / (low + 0.05);
    if (contrast < 4.5) found[words] = contrast;
  }
  return found;
}"""
"""Every text of less contrast than WCAG wants (AA), by its words; what is shut is left out."""


def steady_chart(visitor, page, label_size):
    """Wait until the curve's chart is there at a size of text and rests; return where it is."""
    asked, seen = [page.view.curve.handle._impl.uuid, label_size], [None]

    def rests():
        seen.append(visitor.page.evaluate(CHART, asked))
        return seen[-1] is not None and seen[-1] == seen[-2]

    visitor.wait_until(rests, 20)
    return seen[-1]


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
        left, top, width, height = steady_chart(visitor, page, round(18 * theme.CLASS_SIZE))
        visitor.page.mouse.move(left + 0.5 * width, top + 0.5 * height)
        left = visitor.page.evaluate(
            "id => { const c = window.__viserTestpoints.uplots[id].chart;"
            " return c.cursor.left / c.over.clientWidth; }",
            page.view.curve.handle._impl.uuid,
        )
        assert left == pytest.approx(0.5, abs=0.02)
    finally:
        page.post("large", Asked(None, -1, False))
        visitor.wait_until(lambda: max(visitor.page.evaluate(SIZES)) == pytest.approx(max(desk)))


FRAMES = "() => window.__viserTestpoints.rendererInfo.render.frame"
MINUS = """() => {
  const drawn = ["-4", "\u22124"].map((text) => {
    const pen = document.createElement("canvas").getContext("2d");
    pen.fillText(text, 20, 20);
    return pen.canvas.toDataURL();
  });
  return drawn[0] === drawn[1];
}"""


def test_charts_are_drawn_by_the_cpu_and_have_true_minus_signs(visitor):
    assert visitor.page.evaluate(MINUS)
    assert visitor.page.evaluate(
        "() => Object.values(window.__viserTestpoints.uplots)"
        ".every(({ chart }) => chart.ctx.getContextAttributes().willReadFrequently)"
    )


def test_the_picture_is_drawn_when_there_is_news_and_not_on_and_on(visitor, app):
    visitor.wait_until(lambda: not app.page.moving)

    def is_calm():  # what came before may still be drawn
        before = visitor.page.evaluate(FRAMES)
        visitor.page.evaluate("() => window.__viserMutable.requestRender()")
        visitor.page.wait_for_timeout(450)
        n = visitor.page.evaluate(FRAMES) - before
        return 1 <= n <= 3  # the news, the last, and viser's heartbeat

    visitor.wait_until(is_calm, 10.0)


def test_translucent_bones_cut_no_patches_out_of_each_other(visitor, app):
    writes = (
        "name => { let found = null; window.__viserMutable.nodeRefFromName[name].traverse("
        "p => { if (p.material?.isMeshStandardMaterial) found = p.material.depthWrite; });"
        " return found; }"
    )
    femur = "/knee/femur"
    visitor.press("3D")
    visitor.wait(f"name => ({writes})(name) === false", femur)
    visitor.press("2D")
    visitor.wait(f"name => ({writes})(name) === true", femur)
    visitor.wait_until(lambda: not app.page.moving)


@pytest.mark.parametrize("dark", [False, True])
def test_every_text_of_the_page_stands_out_from_its_ground(visitor, app, dark):
    page = app.page
    page.post("dark", Asked(None, -1, dark))
    try:
        visitor.wait(
            "dark => (document.documentElement.dataset.mantineColorScheme === 'dark') === dark",
            dark,
        )
        # A notice of another test that fades away is paler with each moment.
        visitor.wait("() => !document.querySelector('.mantine-Notification-root')")
        pale = {}
        for tab in TABS:
            visitor.tab(tab)
            visitor.page.wait_for_timeout(250)  # colours ease
            pale |= visitor.page.evaluate(PALE)
        assert pale == {}
    finally:
        page.post("dark", Asked(None, -1, False))
        visitor.wait("() => document.documentElement.dataset.mantineColorScheme === 'light'")

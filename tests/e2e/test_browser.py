"""What only a browser shows."""

import json

import numpy as np
import pytest
from e2e.conftest import Visitor, eventually
from searches import searched

import kneecore
from kneecore import NAMES
from kneeviz import viser_internals
from kneeviz.jobs.messages import Asked

ACL_X, ACL_Y = NAMES.index("acl_femur_x"), NAMES.index("acl_femur_y")


def chart(app):
    return viser_internals.widget_id(app.page.view.curve.handle)


def current_angles(visitor, app):
    """The visitor's knee's angles at the 12 loads as the chart holds them, deg."""
    data = visitor.curve(chart(app))
    own = data[-7]  # before surrogate, two worst cases and three dots
    points = [(m, a) for m, a in zip(data[0], own, strict=True) if a is not None]
    return np.interp(kneecore.MOMENT, *np.array(points).T)


def true_angles(app):
    return np.degrees(kneecore.simulate(app.page.state.x).flexion)


def play(app):
    if not app.page.playback.playing:
        app.page.post("play", Asked(None, -1, True))
    eventually(lambda: app.page.playback.playing)


def search(visitor, app):
    visitor.tab("Search")
    app.page.state.result = None
    visitor.press("Worst case (surrogate)")
    visitor.wait_until(lambda: app.page.state.result is not None, 40)


def test_the_page_loads_without_errors_and_shows_a_moving_knee(chromium, app):
    play(app)
    fresh = Visitor(chromium, app.url)
    try:
        turn = fresh.turn()
        fresh.wait_until(lambda: np.abs(np.subtract(fresh.turn(), turn)).max() > 0.01)
        assert fresh.page.get_by_text("ACL (mm)").is_visible()
        # Every axis has its numbers, at the first sight.
        fresh.wait(
            "id => window.__viserTestpoints.uplots[id].chart.axes"
            ".every(a => (a._values ?? []).length >= 3)",
            chart(app),
        )
        assert fresh.errors == []
    finally:
        fresh.close()
        app.page.playback.play(False)


def test_a_slider_by_keyboard_changes_curve_and_picture(visitor, app):
    visitor.tab("Knee")
    before, picture = current_angles(visitor, app), visitor.pixels(chart(app))
    thumb = visitor.thumb("ACL femur x")
    thumb.focus()
    visitor.page.keyboard.press("End")
    visitor.wait_until(lambda: app.page.state.x[ACL_X] == pytest.approx(-13e-3))
    visitor.wait_until(lambda: np.allclose(current_angles(visitor, app), true_angles(app)))
    assert np.abs(current_angles(visitor, app) - before).max() > 0.3
    visitor.wait_until(lambda: visitor.pixels(chart(app)) != picture)
    assert thumb.get_attribute("aria-valuenow") == "-13"


def test_a_slider_by_mouse_ends_where_the_mouse_ended(visitor, app):
    visitor.tab("Knee")
    uuid = viser_internals.widget_id(app.page.view.knee.sliders[ACL_Y])
    track = visitor.page.locator(f'[id="{uuid}"] .mantine-Slider-track').bounding_box()
    mouse, y = visitor.page.mouse, track["y"] + track["height"] / 2
    mouse.move(track["x"] + track["width"] / 2, y)
    mouse.down()
    for share in np.linspace(0.5, 0.9, 25):
        mouse.move(track["x"] + share * track["width"], y)
        visitor.page.wait_for_timeout(16)
    mouse.up()
    visitor.wait_until(lambda: app.page.state.x[ACL_Y] > 0.3e-3)
    shown = float(visitor.thumb("ACL femur y").get_attribute("aria-valuenow"))
    visitor.wait_until(lambda: app.page.state.x[ACL_Y] == pytest.approx(1e-3 * shown))
    visitor.wait_until(lambda: np.allclose(current_angles(visitor, app), true_angles(app)))


def test_typing_a_number(visitor, app):
    visitor.tab("Knee")
    box = visitor.row("ACL tibia x").locator("input:not([type='hidden'])")
    box.fill("10.75")
    index = NAMES.index("acl_tibia_x")
    visitor.wait_until(lambda: app.page.state.x[index] == pytest.approx(10.75e-3))


def test_play_and_pause(visitor, app):
    readout = visitor.page.get_by_text("N·m", exact=False).first
    visitor.press("Play")
    seen = {(tuple(visitor.turn()), readout.inner_text())}
    visitor.wait_until(
        lambda: seen.add((tuple(visitor.turn()), readout.inner_text())) or len(seen) > 4
    )
    visitor.press("Pause")
    eventually(lambda: not app.page.playback.playing)
    visitor.page.wait_for_timeout(400)
    still = visitor.turn()
    visitor.page.wait_for_timeout(400)
    assert visitor.turn() == still


def test_a_surrogate_search_shows_both_knees_and_what_differs(visitor, app):
    search(visitor, app)
    page = visitor.page
    page.get_by_text("Extension deficit").wait_for()
    page.get_by_text("python -m kneecore.search").first.wait_for()
    visitor.wait("() => window.__viserMutable.nodeRefFromName['/worst_1/tibia']?.visible")
    one, own, two = (visitor.turn(f"/{n}/tibia")[3] for n in ("worst_1", "knee", "worst_2"))
    assert len({round(q, 4) for q in (one, own, two)}) == 3
    data = visitor.curve(chart(app))
    assert any(v is not None for v in data[-5])
    assert any(v is not None for v in data[-4])
    visitor.page.get_by_role("checkbox", name="Show both").or_(
        visitor.row("Show both").locator("input")
    ).first.click()
    visitor.wait("() => !window.__viserMutable.nodeRefFromName['/worst_1/tibia']?.visible")


def test_a_search_in_the_true_model_is_cancelled(visitor, app):
    visitor.tab("Search")
    visitor.press("Worst case (true model)")
    visitor.page.get_by_text("Best f so far").wait_for()
    bar = visitor.page.get_by_role("progressbar")
    visitor.wait_until(lambda: float(bar.get_attribute("aria-valuenow")) > 0)
    assert visitor.page.get_by_role("button", name="Worst case (surrogate)").is_disabled()
    visitor.press("Cancel the search")
    visitor.page.get_by_text("The search was cancelled").wait_for()
    assert app.page.search.job is None
    assert visitor.page.get_by_role("button", name="Worst case (surrogate)").is_enabled()


def test_download_a_result_and_load_it_back(visitor, app, tmp_path):
    search(visitor, app)
    found = app.page.state.result
    visitor.tab("Files")
    with visitor.page.expect_download() as download:
        visitor.press("Result (result.json)")
    path = tmp_path / "result.json"
    download.value.save_as(path)
    assert json.loads(path.read_text())["seed"] == found.settings.seed
    with visitor.page.expect_file_chooser() as chooser:
        visitor.press("Load a file …")
    chooser.value.set_files(path)
    visitor.wait_until(lambda: app.page.state.result not in (None, found))
    np.testing.assert_array_equal(app.page.state.result.x, found.x)


def test_reset_puts_the_sliders_back(visitor, app):
    visitor.tab("Knee")
    visitor.thumb("ACL femur x").focus()
    visitor.page.keyboard.press("Home")
    visitor.wait_until(lambda: app.page.state.x[ACL_X] == pytest.approx(-15e-3))
    visitor.press("Reset ACL")
    visitor.wait_until(lambda: app.page.state.x[ACL_X] == pytest.approx(-14e-3))
    visitor.wait_until(lambda: visitor.thumb("ACL femur x").get_attribute("aria-valuenow") == "-14")


def test_a_reloaded_page_shows_the_same_knee(visitor, app):
    visitor.tab("Knee")
    visitor.thumb("ACL femur x").focus()
    visitor.page.keyboard.press("End")
    visitor.wait_until(lambda: app.page.state.x[ACL_X] == pytest.approx(-13e-3))
    visitor.open()
    visitor.wait_until(lambda: visitor.thumb("ACL femur x").get_attribute("aria-valuenow") == "-13")
    visitor.wait_until(lambda: np.allclose(current_angles(visitor, app), true_angles(app)))


def test_two_browsers_see_one_knee(chromium, visitor, app):
    other = Visitor(chromium, app.url)
    try:
        visitor.tab("Knee")
        visitor.thumb("ACL femur x").focus()
        visitor.page.keyboard.press("Home")
        other.wait_until(lambda: other.thumb("ACL femur x").get_attribute("aria-valuenow") == "-15")
        other.wait_until(lambda: np.allclose(current_angles(other, app), true_angles(app)))
        assert other.errors == []
    finally:
        other.close()


def camera(visitor):
    return visitor.page.evaluate(
        "() => { const c = window.__viserMutable.cameraControl;"
        " const turn = 2 * Math.PI;  // -pi is pi\n"
        " return [((c.azimuthAngle % turn) + turn) % turn, c.polarAngle]; }"
    )


def drag_scene(visitor):
    mouse = visitor.page.mouse
    mouse.move(640, 600)
    mouse.down()
    mouse.move(720, 560, steps=6)
    mouse.up()
    visitor.page.wait_for_timeout(300)


def test_the_flat_view_does_not_tumble_and_the_3d_view_does(visitor, app):
    visitor.press("2D")
    visitor.page.wait_for_timeout(500)
    flat = camera(visitor)
    drag_scene(visitor)
    assert camera(visitor) == pytest.approx(flat, abs=1e-3)
    visitor.press("3D")
    visitor.wait_until(lambda: app.page.view.scene.spatial)
    visitor.wait_until(lambda: np.abs(np.subtract(camera(visitor), flat)).max() > 0.2)
    visitor.page.wait_for_timeout(500)
    before = camera(visitor)
    drag_scene(visitor)
    assert np.abs(np.subtract(camera(visitor), before)).max() > 0.05
    visitor.press("2D")
    visitor.wait_until(lambda: np.allclose(camera(visitor), flat, atol=1e-3))


def test_the_live_worst_case_follows_a_bound(visitor, app):
    page = app.page
    eventually(lambda: page.exact_ready)
    visitor.tab("Search")
    visitor.page.get_by_role("checkbox", name="Live worst case").or_(
        visitor.row("Live worst case").locator("input")
    ).first.click()
    visitor.page.get_by_text("climbs end here").first.wait_for()
    visitor.wait("() => window.__viserMutable.nodeRefFromName['/worst_1/tibia']?.visible")

    def drawn():
        data = visitor.curve(chart(app))
        top = len(data[0]) - 2
        edges = [data[i][top] for i in (3, 4, -5, -4)]
        edges = [np.nan if edge is None else edge for edge in edges]  # no band while it improves
        return [*edges, visitor.turn("/worst_1/tibia")[3], visitor.turn("/worst_2/tibia")[3]]

    visitor.wait_until(lambda: np.isfinite(drawn()).all())
    before, picture = drawn(), visitor.pixels(chart(app))
    visitor.tab("Knee")
    visitor.page.get_by_text("Bounds: how uncertain?").click()
    box = visitor.row("Geometry, mm").locator("input:not([type='hidden'])")
    box.fill("0.6")
    visitor.wait_until(lambda: all(a != b for a, b in zip(drawn(), before, strict=True)))
    space = kneecore.ParameterSpace(geometry_bound_mm=0.6)
    wanted = searched(space, method="exact", solver="equilibrium")
    knees = np.degrees([wanted.responses[n].flexion[5] for n in ("model_1", "model_2")])
    visitor.wait_until(lambda: np.allclose(drawn()[2:4], knees))
    assert visitor.pixels(chart(app)) != picture
    box.fill("1")
    visitor.wait_until(lambda: np.allclose(drawn()[:4], before[:4]))
    page.post("live", Asked(page.view.search.live, -1, False))
    visitor.wait_until(lambda: np.isnan(drawn()[0]))


def shown(visitor, node):
    """Tell whether a node and all above it are drawn."""
    return visitor.page.evaluate(
        "name => { let n = window.__viserMutable.nodeRefFromName[name]; if (!n) return false;"
        " for (; n; n = n.parent) if (!n.visible) return false; return true; }",
        node,
    )


def test_the_landscape_takes_the_knees_place_and_gives_it_back(visitor, app):
    visitor.press("2D")
    visitor.page.wait_for_timeout(500)
    flat = camera(visitor)
    visitor.tab("Study")
    visitor.press("Show the landscape")
    visitor.page.get_by_text("knees simulated").wait_for()
    visitor.wait_until(lambda: shown(visitor, "/landscape/model"))
    visitor.wait_until(lambda: shown(visitor, "/landscape/surrogate"))
    assert not shown(visitor, "/knee/femur")
    assert not shown(visitor, "/knee/ligament_ACL")
    visitor.wait_until(lambda: np.abs(np.subtract(camera(visitor), flat)).max() > 0.2)
    visitor.page.wait_for_timeout(500)
    before = camera(visitor)
    drag_scene(visitor)
    assert np.abs(np.subtract(camera(visitor), before)).max() > 0.05
    visitor.press("Back to the knee")
    visitor.wait_until(lambda: shown(visitor, "/knee/femur"))
    assert not shown(visitor, "/landscape/model")
    visitor.wait_until(lambda: np.allclose(camera(visitor), flat, atol=1e-3))
    drag_scene(visitor)
    assert camera(visitor) == pytest.approx(flat, abs=1e-3)


def test_the_study_draws_a_band_and_sorted_bars(visitor, app):
    visitor.tab("Study")
    visitor.press("Sampling")
    visitor.page.get_by_text("10,000 knees").wait_for(timeout=60_000)
    visitor.wait_until(
        lambda: all(any(v is not None for v in edge) for edge in visitor.curve(chart(app))[3:5])
    )
    visitor.press("Influence")
    visitor.wait_until(lambda: app.page.study.influence is not None, 120)
    visitor.tab("Influence")
    visitor.page.get_by_text("decide the angle").wait_for()
    names = visitor.page.locator("svg text[x='112.0']").all_text_contents()
    widths = visitor.page.locator("svg g rect:first-of-type").evaluate_all(
        "all => all.map(r => r.getBBox().width)"
    )
    assert len(names) == len(widths) == 28
    assert names[0] == "Condyle x"
    assert widths == sorted(widths, reverse=True)
    visitor.tab("Study")
    visitor.page.get_by_text("Study files").click()
    with visitor.page.expect_download() as download:
        visitor.press("Study (uncertainty.json)")
    document = json.loads(download.value.path().read_text())
    assert document["n_samples"] == 10_000
    assert document["influence"]["parameters"]
    visitor.tab("Curve")


CONTRAST = """line => {
    const channels = text => text.match(/[\\d.]+/g).map(Number);
    let opacity = 1, behind = null;
    for (let e = line; e && behind === null; e = e.parentElement) {
        const style = getComputedStyle(e), [r, g, b, a = 1] = channels(style.backgroundColor);
        opacity *= Number(style.opacity);
        if (a === 1) behind = [r, g, b];
    }
    const ink = channels(getComputedStyle(line).color).slice(0, 3);
    const seen = ink.map((c, i) => opacity * c + (1 - opacity) * behind[i]);
    const light = c => (c /= 255) <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
    const bright = ([r, g, b]) => 0.2126 * light(r) + 0.7152 * light(g) + 0.0722 * light(b);
    const both = [bright(seen), bright(behind)].sort((one, other) => other - one);
    return (both[0] + 0.05) / (both[1] + 0.05);
}"""
"""The ratio of brightness between a text and what is behind it, as WCAG 2 defines it."""


def test_the_marks_of_ones_knee_are_legible_in_both_themes(visitor, app):
    sign = visitor.page.get_by_text("~ not yet at rest").first
    assert sign.is_visible()
    assert "0.1 deg of the same knee's equilibrium" in sign.get_attribute("title")
    ratios = []
    try:
        for dark, brightness in ((False, "light"), (True, "dark")):
            app.page.post("dark", Asked(None, -1, dark))
            visitor.page.wait_for_selector(f"[data-mantine-color-scheme={brightness}]")
            ratios.append(sign.evaluate(CONTRAST))
    finally:
        app.page.post("dark", Asked(None, -1, False))
    assert min(ratios) >= 4.5
    assert ratios[0] != ratios[1]

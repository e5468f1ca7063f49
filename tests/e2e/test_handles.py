"""The knee in a visitor's hand, as a browser shows it."""

import numpy as np
import pytest
from e2e.conftest import eventually

import kneecore
from kneeviz import viser_internals
from kneeviz.geometry.handles import BY_NAME
from kneeviz.jobs.messages import Asked
from kneeviz.state.handles import bound_now, box_of, values_of

ACL = BY_NAME["acl_femur"]
PIXELS_PER_MM = 2.29 * 20
"""On a window 720 px high, in a loupe that magnifies twenty times."""


@pytest.fixture
def still(visitor, app):
    """The page, paused, with its handles, none of them chosen."""
    visitor.press("2D")
    visitor.tab("Knee")
    app.page.post("position", Asked(None, -1, 30.0))
    visitor.wait_until(lambda: app.page.view.handles.root.visible)
    visitor.page.wait_for_timeout(300)
    yield visitor
    for _ in range(2):
        visitor.page.keyboard.press("Escape")
    app.page.post(("bound", "geometry_mm"), Asked(None, -1, 1.0))
    eventually(lambda: bound_now(app.page.state, "geometry_mm") == 1.0)


def take(visitor, node="acl_femur"):
    at = visitor.spot(f"/handles/{node}")
    visitor.page.mouse.move(*at)
    visitor.page.mouse.down()
    return np.array(at)


def pull(visitor, at, *, right=0.0, up=0.0):
    visitor.page.mouse.move(at[0] + right, at[1] - up, steps=4)


def away_mm(app):
    box = box_of(app.page.state, ACL)
    return 1e3 * (values_of(app.page.state, ACL) - box.home)


def drawn_angles(visitor, app):
    data = visitor.curve(viser_internals.widget_id(app.page.view.curve.handle))
    own = [(m, a) for m, a in zip(data[0], data[-7], strict=True) if a is not None]
    return np.interp(kneecore.MOMENT, *np.array(own).T)


def test_a_drag_inside_to_the_edge_and_past_it(still, app):
    at = take(still)
    pull(still, at, right=0.5 * PIXELS_PER_MM, up=0.3 * PIXELS_PER_MM)
    still.wait_until(lambda: np.abs(away_mm(app) - [0.5, 0.3]).max() < 0.04)
    still.wait_until(
        lambda: np.allclose(still.spot("/handles/acl_femur"), at + [22.9, -13.7], atol=2.5)
    )
    truth = np.degrees(kneecore.simulate(app.page.state.x).flexion)
    still.wait_until(lambda: np.allclose(drawn_angles(still, app), truth))
    shown = f"{-14.0 + away_mm(app)[0]:g}"
    still.wait_until(lambda: still.thumb("ACL femur x").get_attribute("aria-valuenow") == shown)
    pull(still, at, right=1.0 * PIXELS_PER_MM)
    still.wait_until(lambda: away_mm(app).tolist() == [pytest.approx(1.0, abs=1e-9), 0.0])
    pull(still, at, right=3000.0, up=-3000.0)  # beyond the window
    still.wait_until(lambda: np.allclose(away_mm(app), [1.0, -1.0]))
    still.wait_until(
        lambda: np.allclose(still.spot("/handles/acl_femur"), at + [45.8, 45.8], atol=2.5)
    )
    still.page.mouse.up()
    still.wait_until(lambda: not app.page.handles.grabs)
    assert np.allclose(away_mm(app), [1.0, -1.0])


def test_escape_while_the_hand_is_down(still, app):
    at = take(still)
    pull(still, at, right=0.6 * PIXELS_PER_MM)
    still.page.mouse.up()
    still.wait_until(lambda: not app.page.handles.grabs)
    before = away_mm(app)
    assert before[0] > 0.5
    at = take(still)
    pull(still, at, right=-1.0 * PIXELS_PER_MM)
    still.wait_until(lambda: away_mm(app)[0] < 0.0)
    still.page.keyboard.press("Escape")
    still.wait_until(lambda: away_mm(app).tolist() == before.tolist())
    pull(still, at, right=-0.9 * PIXELS_PER_MM)
    still.page.mouse.up()
    still.wait_until(lambda: not app.page.handles.grabs)
    assert away_mm(app).tolist() == before.tolist()


def test_two_clicks(still, app):
    app.page.post(("param", 0), Asked(None, -1, -13.5))
    at = np.array(still.spot("/handles/acl_femur"))

    def home():  # a busy machine may take too long between two clicks
        still.page.mouse.dblclick(*at)
        still.page.wait_for_timeout(300)
        return app.page.state.at_baseline

    still.wait_until(home)


def test_the_edge_of_a_box(still, app):
    middle = np.array(still.spot("/handles/acl_femur"))
    still.page.mouse.click(*middle)
    edge = middle - [0.0, PIXELS_PER_MM]
    still.wait_until(lambda: np.allclose(still.spot("/handles/edge_3"), edge, atol=2.5))
    at = take(still, "edge_3")
    pull(still, at, up=0.5 * PIXELS_PER_MM)
    still.wait_until(lambda: bound_now(app.page.state, "geometry_mm") == 1.5)
    still.wait_until(lambda: np.allclose(still.spot("/handles/edge_3"), at - [0, 22.9], atol=2.5))
    still.page.mouse.up()
    still.wait_until(lambda: not app.page.handles.grabs)
    still.wait_until(lambda: app.page.view.knee.sliders[0].max == pytest.approx(-12.5))
    # Released, the loupe takes the magnification that suits the new bound.
    still.wait_until(lambda: np.allclose(still.spot("/handles/edge_3"), at + [0, 11.4], atol=2.5))


def test_what_can_be_taken_says_so_to_the_pointer(still):
    spot = still.spot("/handles/acl_tibia")
    cursor = "() => window.__viserMutable.canvas.style.cursor"
    still.page.mouse.move(spot[0] + 12, spot[1] + 12)  # a finger is no finer than that
    still.wait(f"() => ({cursor})() === 'pointer'")
    still.page.mouse.move(500, 640)
    still.wait(f"() => ({cursor})() !== 'pointer'")

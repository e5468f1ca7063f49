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


def hand_s_way(visitor):
    """Return how many pixels a hand goes for 1 mm: the loupe of such a bound magnifies 20 times."""
    apart = np.subtract(visitor.spot("/handles/acl_femur"), visitor.spot("/handles/mcl_femur"))
    x = kneecore.packaged_knee().baseline
    one, other = (x[BY_NAME[name].indices] for name in ("acl_femur", "mcl_femur"))
    return 20.0 * np.linalg.norm(apart) / (1e3 * np.linalg.norm(one - other))


@pytest.fixture
def still(visitor, app):
    """The page, paused, with its handles, none of them chosen."""
    visitor.press("2D")
    visitor.tab("Knee")
    app.page.post("position", Asked(None, -1, 30.0))
    visitor.wait_until(lambda: app.page.view.handles.root.visible)
    visitor.wait_until(lambda: not app.page.moving)
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
    at, mm = take(still), hand_s_way(still)
    pull(still, at, right=0.5 * mm, up=0.3 * mm)
    still.wait_until(lambda: np.abs(away_mm(app) - [0.5, 0.3]).max() < 0.04)
    still.wait_until(
        lambda: np.allclose(still.spot("/handles/acl_femur"), at + [0.5 * mm, -0.3 * mm], atol=2.5)
    )
    truth = np.degrees(kneecore.simulate(app.page.state.x).flexion)
    still.wait_until(lambda: np.allclose(drawn_angles(still, app), truth))
    shown = f"{-14.0 + away_mm(app)[0]:g}"
    still.wait_until(lambda: still.thumb("ACL femur x").get_attribute("aria-valuenow") == shown)
    pull(still, at, right=1.0 * mm)
    still.wait_until(lambda: away_mm(app).tolist() == [pytest.approx(1.0, abs=1e-9), 0.0])
    pull(still, at, right=3000.0, up=-3000.0)  # beyond the window
    still.wait_until(lambda: np.allclose(away_mm(app), [1.0, -1.0]))
    still.wait_until(lambda: np.allclose(still.spot("/handles/acl_femur"), at + [mm, mm], atol=2.5))
    still.page.mouse.up()
    still.wait_until(lambda: not app.page.handles.grabs)
    assert np.allclose(away_mm(app), [1.0, -1.0])


def test_escape_while_the_hand_is_down(still, app):
    at, mm = take(still), hand_s_way(still)
    pull(still, at, right=0.6 * mm)
    still.page.mouse.up()
    still.wait_until(lambda: not app.page.handles.grabs)
    before = away_mm(app)
    assert before[0] > 0.5
    at = take(still)
    pull(still, at, right=-1.0 * mm)
    still.wait_until(lambda: away_mm(app)[0] < 0.0)
    still.page.keyboard.press("Escape")
    still.wait_until(lambda: away_mm(app).tolist() == before.tolist())
    pull(still, at, right=-0.9 * mm)
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
    middle, mm = np.array(still.spot("/handles/acl_femur")), hand_s_way(still)
    still.page.mouse.click(*middle)
    edge = middle - [0.0, mm]
    still.wait_until(lambda: np.allclose(still.spot("/handles/edge_3"), edge, atol=2.5))
    at = take(still, "edge_3")
    pull(still, at, up=0.5 * mm)
    still.wait_until(lambda: bound_now(app.page.state, "geometry_mm") == 1.5)
    still.wait_until(
        lambda: np.allclose(still.spot("/handles/edge_3"), at - [0, 0.5 * mm], atol=2.5)
    )
    still.page.mouse.up()
    still.wait_until(lambda: not app.page.handles.grabs)
    still.wait_until(lambda: app.page.view.knee.sliders[0].max == pytest.approx(-12.5))
    # Released, the loupe takes the magnification that suits the new bound.
    still.wait_until(
        lambda: np.allclose(still.spot("/handles/edge_3"), middle - [0, 0.75 * mm], atol=2.5)
    )


def hint(visitor):
    return visitor.page.evaluate(
        "() => { const h = window.__kneevizHint;"
        " return h && h.style.display !== 'none' ? h.textContent : null; }"
    )


def test_a_handle_says_what_it_is_before_it_is_taken(still):
    x, y = still.spot("/handles/pcl_tibia")
    told = "PCL tibia\nx \u221217.10 mm, home\ny \u22128.10 mm, home\nbound \u00b11.00 mm"

    def is_told():
        still.page.mouse.move(x - 12, y)  # half of what a finger needs
        still.page.mouse.move(x - 11, y)
        return hint(still) == told

    still.wait_until(is_told)
    still.page.mouse.move(500, 640)
    assert hint(still) is None


def test_a_finger_drags_a_handle(still, app):
    hand = still.page.context.new_cdp_session(still.page)
    at, mm = np.array(still.spot("/handles/acl_femur")), hand_s_way(still)

    def touch(kind, *points):
        spots = [{"x": float(x), "y": float(y)} for x, y in points]
        hand.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": spots})

    touch("touchStart", at - [8, 8])  # beside it; the other side is another's
    for share in (0.25, 0.5, 0.75, 1.0):
        touch("touchMove", at + [-8 + 0.5 * mm * share, -8 - 0.3 * mm * share])
        still.page.wait_for_timeout(60)
    still.wait_until(lambda: np.abs(away_mm(app) - [0.5, 0.3]).max() < 0.06)
    touch("touchEnd")
    still.wait_until(lambda: not app.page.handles.grabs)
    hand.detach()


def test_what_can_be_taken_says_so_to_the_pointer(still):
    spot = still.spot("/handles/acl_tibia")
    cursor = "() => window.__viserMutable.canvas.style.cursor"
    still.page.mouse.move(spot[0] + 12, spot[1] + 12)  # a finger is no finer than that
    still.wait(f"() => ({cursor})() === 'pointer'")
    still.page.mouse.move(500, 640)
    still.wait(f"() => ({cursor})() !== 'pointer'")

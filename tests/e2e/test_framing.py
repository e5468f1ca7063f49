"""Knees and worst cases in the free area between the panels, in windows of four sizes."""

import numpy as np
import pytest
from e2e.conftest import Visitor, eventually
from searches import searched

from kneeviz.geometry import framing
from kneeviz.server.app import App

SIZES = ((1920, 1080), (1280, 720), (900, 700), (420, 800))
FREE = """() => { const r = document.querySelector('canvas').getBoundingClientRect();
  const at = (x, y) => document.elementFromPoint(x, y)?.tagName;
  const inner = [0.02, 0.5, 0.98].flatMap((u) => [0.02, 0.5, 0.98].map((v) =>
    at(r.x + u * r.width, r.y + v * r.height)));
  return [r.width, r.height, inner.every((tag) => tag === 'CANVAS' || tag === 'DIV')
    && document.elementsFromPoint(r.x + r.width / 2, r.y + r.height - 4)
      .some((e) => e.tagName === 'CANVAS')]; }"""


@pytest.fixture(scope="module")
def shown(chromium):
    app = App(port=0, result=searched(pop_size=40, n_generations=20))
    try:
        eventually(lambda: app.page.model_ready)
        visitor = Visitor(chromium, app.url)
        yield app, visitor
        assert visitor.errors == []
        visitor.close()
    finally:
        app.stop()


def in_picture(client, page, aspect):
    """Tell whether all knees are in a client's picture at 20 positions of the motion."""
    position, look_at = np.array(client.camera.position), np.array(client.camera.look_at)
    half = (position[2] - look_at[2]) * np.tan(0.5 * framing.FIELD_OF_VIEW)
    sweeps = [knee.sweep for knee in page.knees if knee is not None]
    assert len(sweeps) == 3
    poses = [s.at_moment(m) for s in sweeps for m in np.linspace(5.0, -5.0, 20)]
    away = np.abs(framing.knee_points(poses) - look_at)[:, :2].max(axis=0)
    return away[1] < half and away[0] < half * aspect and away.max() > 0.5 * half


def fits(app, visitor, window):
    """Tell whether knees and worst cases are in the free area of a window."""
    (client,) = app.server.get_clients().values()
    wide, high, free = visitor.page.evaluate(FREE)
    # At most half of a phone's height, and no panel over the picture.
    large = wide > 200 and high >= 0.5 * window[1] - 1
    if not (large and free):
        return False
    told = abs(client.camera.aspect / (wide / high) - 1.0) < 0.02
    return told and in_picture(client, app.page, wide / high)


@pytest.mark.parametrize("window", SIZES)
def test_knees_and_worst_cases_are_in_the_free_area(shown, window):
    app, visitor = shown
    visitor.page.set_viewport_size({"width": window[0], "height": window[1]})
    visitor.wait_until(lambda: fits(app, visitor, window))

"""What a visitor does to a page and sees of it, for the tests over a WebSocket."""

import numpy as np
from viz.conftest import eventually

import kneecore
from kneeviz import viser_internals


def widget(handle):
    return viser_internals.widget_id(handle)


def press(visitor, handle, value=True):
    visitor.set(widget(handle), value)


def curve(visitor, page):
    """The data of the moment-angle chart as the browser has it: axis and series."""
    return visitor.props[widget(page.view.curve.handle)]["data"]


def current_curve(visitor, page):
    """The visitor's knee in the chart: (moments, angles) without what is not drawn."""
    data = curve(visitor, page)
    angles = data[-7]  # before surrogate, two worst cases and three dots
    drawn = np.isfinite(angles)
    return data[0][drawn], angles[drawn]


def shows(visitor, page, angles):
    """Tell whether the chart's curve of the visitor's knee has these 12 angles, deg."""
    drawn = np.interp(kneecore.MOMENT, *current_curve(visitor, page))
    return np.allclose(drawn, angles, atol=1e-9)


def height(visitor):
    """Where the ACL's femoral end is drawn, m."""
    return float(visitor.scene["/knee/ligament_ACL"]["points"].reshape(2, 3)[0, 1])


def search_anew(page, visitor):
    """Search in the surrogate and wait for its own result, not one that was there before."""
    page.state.result = None
    press(visitor, page.view.search.surrogate)
    wait_for_result(page)


def wait_for_result(page, timeout=60.0):
    eventually(lambda: page.search.job is None and page.state.result is not None, timeout)


def play(visitor, page):
    if not page.playback.playing:
        press(visitor, page.view.transport.play)
    eventually(lambda: page.playback.playing)


def pause(visitor, page):
    if page.playback.playing:
        press(visitor, page.view.transport.play)
    eventually(lambda: not page.playback.playing)

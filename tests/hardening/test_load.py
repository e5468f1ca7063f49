"""Many visitors at once, and what they leave behind; ``run.py`` does the same for minutes."""

import threading
import time

import numpy as np
import pytest
from hardening.rows_load import SEARCH, drag_and_measure, drop_in, thirty_two_draggers
from hardening.served import slider
from viz.conftest import eventually
from viz.websocket_client import WebSocketClient

from kneeviz import viser_internals
from kneeviz.server.app import App

pytestmark = pytest.mark.filterwarnings("ignore:Queued a ")  # viser's, for those who left


def test_thirty_two_drag_while_one_searches():
    """A move of one more is answered soon, though there are 640 others a second."""
    with thirty_two_draggers() as (served, client, draggers):
        client.set(slider(client, SEARCH), True)
        took = drag_and_measure(client, 3.0)
        assert len(took) > 5
        assert np.percentile(took, 95) < 400.0  # of a busy machine; on a quiet one, 50
        assert not any(dragger.failure for dragger in draggers)
        assert served.said == ""


@pytest.fixture(scope="module")
def app():
    running = App(port=0)
    try:
        eventually(lambda: running.page.surrogate_ready)
        yield running
    finally:
        running.stop()


def held(app):
    """What the server keeps that could pile up."""
    buffer = app.server._websock_server._broadcast_buffer
    return {
        "messages": len(buffer.message_from_id),
        "cursors": len(buffer.generator_cursors),
        "windows": len(vars(buffer)["_kneeviz"]._windows),
        "clients": len(app.server.get_clients()),
        "uploads": len(app.page.uploads._latest) + len(viser_internals.unfinished_uploads()),
        "threads": sum(t.name in ("upload", "search", "view") for t in threading.enumerate()),
    }


def test_visitors_who_come_and_go_leave_nothing(app):
    port = app.server.get_port()
    for turn in range(3):  # whatever is made once has been made
        drop_in(port, turn)
    eventually(lambda: app.page.search.job is None and held(app)["clients"] == 0, 30)
    before = held(app)
    for turn in range(9):
        drop_in(port, turn)
        with WebSocketClient(port) as one:
            one.wait(lambda c: c.counts.get("ReplayDoneMessage"))
            for value in np.linspace(-1.0, 0.5, 40):
                one.set(slider(one), float(value))
                time.sleep(0.001)
    eventually(lambda: app.page.search.job is None and held(app)["clients"] == 0, 30)
    eventually(lambda: held(app)["threads"] == before["threads"], 10)
    after = held(app)
    assert after["windows"] <= 3
    assert after["messages"] <= before["messages"] + 10  # some acknowledgements, which are few
    assert after | {"messages": 0, "windows": 0} == before | {"messages": 0, "windows": 0}

"""A real server for the tests that speak to it over a WebSocket."""

import time
from collections.abc import Callable, Iterator

import pytest
from viz.websocket_client import WebSocketClient

from kneeviz.page.page import Page
from kneeviz.server.app import App


def eventually(condition: Callable[[], object], timeout: float = 60.0) -> None:
    """Wait until a condition on the server holds."""
    end = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < end, "what was waited for did not happen"
        time.sleep(0.01)


@pytest.fixture(scope="module")
def app() -> Iterator[App]:
    running = App(port=0)
    try:
        eventually(lambda: running.page.surrogate_ready, 60.0)
        yield running
    finally:
        running.stop()


@pytest.fixture
def page(app: App) -> Page:
    """The shared page, back at the baseline and paused."""
    page = app.page
    if not page.state.at_baseline:
        page.post("reset_all")
    page.post("reset_all")
    eventually(lambda: page.state.at_baseline)
    eventually(lambda: not page.animation.morphing)
    return page


@pytest.fixture
def visitor(app: App) -> Iterator[WebSocketClient]:
    with WebSocketClient(app.server.get_port()) as client:
        client.wait(lambda c: c.counts.get("ReplayDoneMessage"))
        eventually(lambda: app.server.get_clients())
        yield client

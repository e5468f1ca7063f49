"""A real server for the tests that speak to it over the wire."""

import time
from collections.abc import Callable, Iterator

import pytest
from viz.wire_client import WireClient

from kneeviz.server.app import App
from kneeviz.server.session import Session


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
        eventually(lambda: running.session.surrogate_ready, 60.0)
        yield running
    finally:
        running.stop()


@pytest.fixture
def session(app: App) -> Session:
    """The shared session, back at the baseline and paused."""
    session = app.session
    if not session.state.at_baseline:
        session.post("reset_all")
    session.post("reset_all")
    eventually(lambda: session.state.at_baseline)
    eventually(lambda: session._morph is None)
    return session


@pytest.fixture
def visitor(app: App) -> Iterator[WireClient]:
    with WireClient(app.server.get_port()) as client:
        client.wait(lambda c: c.counts.get("ReplayDoneMessage"))
        eventually(lambda: app.server.get_clients())
        yield client

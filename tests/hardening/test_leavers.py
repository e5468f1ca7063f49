"""A knee for each visitor, and visitors who leave before they have come."""

import threading
import time

import pytest
from hardening.leavers import Watchdog, hail_of_leavers
from hardening.served import serving
from viz.conftest import eventually
from viz.websocket_client import WebSocketClient

from kneeviz.server import app as apps
from kneeviz.server.app import MAX_SESSIONS, App

pytestmark = pytest.mark.filterwarnings("ignore:Queued a ")  # viser's, for those who left


OTHERS = set()
"""Threads of other apps of this process."""


@pytest.fixture
def app():
    OTHERS.clear()
    OTHERS.update(threading.enumerate())
    running = App(port=0, shared=False)
    try:
        yield running
    finally:
        running.stop()


@pytest.fixture
def port(app):
    return app.server.get_port()


def views():
    new = set(threading.enumerate()) - OTHERS
    return [thread for thread in new if thread.name == "view"]


def test_hundreds_of_early_leavers_leave_nothing(app, port):
    watchdog = Watchdog(app)
    assert hail_of_leavers(port, 300) > 250
    eventually(lambda: len(app.seats) == 0 and not app.server.get_clients(), 30)
    assert app.sessions == {}
    assert 1 <= watchdog.most <= MAX_SESSIONS
    eventually(lambda: watchdog.alive == 0 and not views(), 10)
    with WebSocketClient(port) as late:
        eventually(lambda: len(app.sessions) == 1, 10)
        assert late.notifications == []


def test_a_burst_fills_the_places_and_no_more(app, port):
    watchdog = Watchdog(app)
    visitors = [WebSocketClient(port) for _ in range(MAX_SESSIONS + 8)]
    try:
        eventually(lambda: len(app.sessions) == MAX_SESSIONS, 30)
        eventually(lambda: sum(bool(v.notifications) for v in visitors) == 8, 30)
        assert watchdog.most == MAX_SESSIONS
    finally:
        for visitor in visitors:
            visitor.close()
    eventually(lambda: app.sessions == {} and watchdog.alive == 0, 20)


def test_one_who_leaves_while_his_session_is_made_frees_his_place(app, port, monkeypatch):
    begun, go_on = threading.Event(), threading.Event()
    make = app._session

    def slow(*arguments):
        begun.set()
        go_on.wait(20)
        return make(*arguments)

    monkeypatch.setattr(app, "_session", slow)
    with WebSocketClient(port):
        assert begun.wait(20)
        assert len(app.seats) == 1
    eventually(lambda: not app.server.get_clients(), 10)
    go_on.set()
    eventually(lambda: len(app.seats) == 0 and not views(), 10)


def test_one_whose_session_cannot_be_made_frees_his_place(app, port, monkeypatch, caplog):
    def broken(*_):
        raise ZeroDivisionError("a slip")

    monkeypatch.setattr(app, "_session", broken)
    with WebSocketClient(port):
        eventually(lambda: "cannot be made" in caplog.text, 20)
        assert len(app.seats) == 0
        monkeypatch.undo()
        with WebSocketClient(port):
            eventually(lambda: len(app.sessions) == 1, 20)


def test_who_is_gone_before_his_turn_costs_no_work(app, port, monkeypatch):
    made = []
    monkeypatch.setattr(app, "_session", lambda *a: made.append(a))
    app._join(type("Gone", (), {"client_id": 12345})())
    assert made == []
    assert len(app.seats) == 0


def test_when_the_app_stops_all_sessions_end(monkeypatch):
    OTHERS.clear()
    OTHERS.update(threading.enumerate())
    running = apps.App(port=0, shared=False)
    with WebSocketClient(running.server.get_port()):
        eventually(lambda: len(running.sessions) == 1, 20)
        running.stop()
        time.sleep(0.1)
        assert running.sessions == {}
    eventually(lambda: not views(), 10)


def test_who_leaves_early_does_not_fill_the_log():
    with serving("--per-visitor") as served:
        assert hail_of_leavers(served.port, 40) > 30
        assert served.said == ""

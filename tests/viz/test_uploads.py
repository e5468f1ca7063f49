"""Files that take long: read apart from all pages, and given up in time."""

import subprocess
import sys
import threading
import time

import models
import numpy as np
import pytest
from viz.conftest import eventually
from viz.visits import widget
from viz.websocket_client import WebSocketClient

import kneecore
from kneecore import NAMES, FileFormatError, KneeFile, asset_path
from kneeviz.jobs import uploads
from kneeviz.jobs.uploads import Uploads, parse_apart

ACL_Y = NAMES.index("acl_femur_y")
KNEE = asset_path("baseline.toml").read_bytes()
SLOW = """
import time
from kneeviz.jobs import uploads

def endless(name, content):
    while True:
        sum(range(10_000))

uploads.parse = endless
uploads._main()
"""


def endless(*_):
    """What stops a page if it ever runs on a page's thread, or holds on to a lock of Python's."""
    end = time.monotonic() + 20.0
    while time.monotonic() < end:
        sum(range(10_000_000))


@pytest.fixture
def slow(monkeypatch):
    """A parser made slow on purpose, wherever it runs; the processes that were started."""
    started = []
    popen = subprocess.Popen

    def recorded(*arguments, **options):
        started.append(popen(*arguments, **options))
        return started[-1]

    monkeypatch.setattr(uploads.subprocess, "Popen", recorded)
    monkeypatch.setattr(uploads, "_COMMAND", (sys.executable, "-c", SLOW))
    monkeypatch.setattr(uploads, "parse", endless)
    monkeypatch.setattr(uploads, "DEADLINE", 2.0)
    yield started
    for process in started:
        process.kill()


def upload(visitor, page, name, content=KNEE):
    visitor.upload(widget(page.view.files.upload), name, content)


def test_a_slow_parser_stops_nobody_and_is_given_up(app, page, visitor, slow):
    handle, took = page.view.knee.sliders[ACL_Y], []
    with WebSocketClient(app.server.get_port()) as other:
        other.wait(lambda c: c.counts.get("ReplayDoneMessage"))
        upload(visitor, page, "slow.toml")
        eventually(lambda: slow)
        while slow[0].poll() is None:
            value, start = -1.2 + 0.01 * len(took), time.perf_counter()
            other.set(widget(handle), value)
            eventually(lambda v=value: page.state.current.x[ACL_Y] == pytest.approx(1e-3 * v), 5)
            took.append(time.perf_counter() - start)
            time.sleep(0.02)
        assert len(took) > 10
        assert np.percentile(took, 95) < 0.5
        visitor.wait(lambda c: c.notifications, 10)
        assert "slow.toml: given up after 2 s" in visitor.notifications[0]["props"]["body"]
        assert other.notifications == []
    assert slow[0].poll() is not None
    status = widget(page.view.transport.status)
    visitor.wait(lambda c: "What you had stands" in c.props[status]["content"])


def test_the_page_says_that_it_reads(page, visitor, slow):
    upload(visitor, page, "<b>.toml")
    status = widget(page.view.transport.status)
    visitor.wait(lambda c: "Reading &lt;b&gt;.toml" in c.props[status]["content"])
    visitor.wait(lambda c: c.notifications, 10)


def test_a_file_without_a_name_is_one_line_or_a_knee(page, visitor):
    upload(visitor, page, "", b"{]")
    visitor.wait(lambda c: c.notifications, 20)
    (told,) = visitor.notifications
    assert told["props"]["body"].startswith("a file without a name: not a ")
    assert "\n" not in told["props"]["body"]
    status = widget(page.view.transport.status)
    visitor.upload(widget(page.view.files.upload), "", KNEE)
    visitor.wait(lambda c: "Packaged" in c.props[status]["content"], 20)


class TestReader:
    @pytest.fixture
    def reader(self):
        posted = []
        running = Uploads(lambda key, value: posted.append((key, value)))
        yield running, posted
        running.stop()

    def test_it_reads_as_the_parser_does(self):
        assert parse_apart("a.toml", KNEE).title == kneecore.parse_knee(KNEE.decode()).title
        with pytest.raises(FileFormatError, match="UTF-8"):
            parse_apart("a.toml", b"\xff\xfe")

    def test_a_process_that_fails_is_one_line(self, monkeypatch):
        monkeypatch.setattr(uploads, "_COMMAND", (sys.executable, "-c", "import os; os.abort()"))
        with pytest.raises(FileFormatError, match="has failed"):
            parse_apart("a.toml", KNEE)

    def test_few_are_read_at_once_and_few_may_wait(self, reader, monkeypatch):
        running, posted = reader
        now, most, go = [0], [0], threading.Event()

        def counted(name, content):
            now[0] += 1
            most[0] = max(most[0], now[0])
            go.wait(20)
            now[0] -= 1
            return KneeFile

        monkeypatch.setattr(uploads, "parse_apart", counted)
        taken = [running.read("x", b"", client) for client in range(uploads.MOST_WAITING + 3)]
        assert taken == [True] * uploads.MOST_WAITING + [False] * 3
        eventually(lambda: now[0] == uploads.AT_ONCE, 5)
        go.set()
        eventually(lambda: len(posted) == uploads.MOST_WAITING, 10)
        assert most[0] == uploads.AT_ONCE
        assert running.read("x", b"", 0)

    def test_of_one_visitor_the_latest_counts(self, reader, monkeypatch):
        running, posted = reader
        turns = {"first": threading.Event(), "second": threading.Event()}
        monkeypatch.setattr(uploads, "parse_apart", lambda name, _: turns[name].wait(20) and name)
        assert running.read("first", b"", 1)
        assert running.read("second", b"", 1)
        turns["second"].set()
        eventually(lambda: posted, 5)
        turns["first"].set()
        time.sleep(0.1)
        assert [(key, value.loaded) for key, value in posted] == [(("uploaded", 1), "second")]

    def test_whoever_has_left_is_told_nothing(self, reader, monkeypatch):
        running, posted = reader
        go, done = threading.Event(), threading.Event()

        def held(*_):
            go.wait(20)
            done.set()

        monkeypatch.setattr(uploads, "parse_apart", held)
        assert running.read("x", b"", 1)
        running.stop()
        go.set()
        assert done.wait(5)
        time.sleep(0.05)
        assert posted == []


def test_a_result_of_another_model_is_refused(page, visitor):
    other = kneecore.worst_case(
        models.ishigami(), kneecore.SearchSettings(pop_size=20, n_generations=3)
    )
    upload(visitor, page, "other.json", other.to_json().encode())
    visitor.wait(lambda c: c.notifications, 20)
    assert "results of knees" in visitor.notifications[0]["props"]["body"]

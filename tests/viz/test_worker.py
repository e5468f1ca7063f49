import threading
import time

import pytest

from kneeviz.jobs.worker import Mailbox, Worker


def test_a_later_request_replaces_an_earlier_one_and_goes_last():
    mailbox = Mailbox()
    mailbox.post("a", 1)
    mailbox.post("b", 2)
    mailbox.post("a", 3)
    assert mailbox.take(0) == [("b", 2), ("a", 3)]
    assert mailbox.take(0) == []


def test_waiting_ends_with_a_request():
    mailbox = Mailbox()
    threading.Timer(0.05, mailbox.post, ("late",)).start()
    assert mailbox.take(5.0) == [("late", None)]


def test_a_closed_mailbox_gives_none():
    mailbox = Mailbox()
    mailbox.post("a")
    mailbox.close()
    assert mailbox.take(None) is None


@pytest.fixture
def make():
    made = []

    def maker(step, on_error=lambda error: None):
        worker = Worker(step, on_error)
        made.append(worker)
        worker.start()
        return worker

    yield maker
    for worker in made:
        worker.stop()


def test_a_slow_step_gets_the_latest_of_many(make):
    seen, busy = [], threading.Event()

    def step(actions):
        seen.append(dict(actions))
        busy.wait(0.2)

    worker = make(step)
    for value in range(50):
        worker.mailbox.post("slider", value)
        time.sleep(0.001)
    busy.set()
    deadline = time.monotonic() + 5
    while seen[-1] != {"slider": 49} and time.monotonic() < deadline:
        time.sleep(0.01)
    assert seen[-1] == {"slider": 49}
    assert len(seen) < 10


def test_it_is_called_again_when_due(make):
    called = threading.Event()
    calls = []

    def step(actions):
        calls.append(actions)
        if len(calls) == 3:
            called.set()
            return None
        return time.monotonic() + 0.02

    make(step).mailbox.post("go")
    assert called.wait(5)
    time.sleep(0.1)
    assert calls == [[("go", None)], [], []]


def test_a_failing_step_is_told_and_the_thread_goes_on(make, caplog):
    told, done = [], threading.Event()

    def step(actions):
        if actions[0][0] == "bad":
            raise ValueError("no")
        done.set()

    worker = make(step, told.append)
    worker.mailbox.post("bad")
    time.sleep(0.05)
    worker.mailbox.post("good")
    assert done.wait(5)
    assert str(told[0]) == "no"


def test_stop_ends_the_thread(make):
    worker = make(lambda actions: None)
    worker.stop()
    assert not worker._thread.is_alive()

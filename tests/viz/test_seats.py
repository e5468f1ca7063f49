"""Places for visitors, taken and left in any order."""

import contextlib
import random
import threading
import time

import pytest
from viz.conftest import eventually

from kneeviz.server.seats import NoRoom, Seats


@pytest.fixture
def ended():
    return []


@pytest.fixture
def seats(ended):
    return Seats(2, ended.append)


def test_a_visitor_gets_what_is_made_and_gives_it_back(seats, ended):
    assert seats.join(1, lambda: "a") == "a"
    assert seats.made == {1: "a"}
    seats.leave(1)
    assert (seats.made, len(seats), ended) == ({}, 0, ["a"])


def test_there_are_no_more_than_there_are(seats):
    seats.join(1, lambda: "a")
    seats.join(2, lambda: "b")
    with pytest.raises(NoRoom):
        seats.join(3, lambda: "c")
    seats.leave(3)
    seats.leave(1)
    assert seats.join(4, lambda: "d") == "d"


def test_a_place_is_taken_before_the_work_and_held_until_its_end(seats, ended):
    begun, go_on = threading.Event(), threading.Event()

    def slow():
        begun.set()
        go_on.wait(10)
        return "a"

    got = []
    thread = threading.Thread(target=lambda: got.append(seats.join(1, slow)))
    thread.start()
    begun.wait(10)
    assert len(seats) == 1
    seats.leave(1)
    assert len(seats) == 1, "its work goes on"
    go_on.set()
    thread.join(10)
    assert (got, ended, len(seats), seats.made) == ([None], ["a"], 0, {})


def test_who_leaves_before_he_comes_gets_nothing(seats, ended):
    seats.leave(1)
    assert seats.join(1, lambda: pytest.fail("nobody to work for")) is None
    assert (len(seats), ended) == (0, [])
    assert seats._left_before == set()


def test_a_place_is_free_again_when_the_work_fails(seats, ended):
    with pytest.raises(ZeroDivisionError):
        seats.join(1, lambda: 1 / 0)
    assert seats.join(2, lambda: None) is None
    assert len(seats) == 0
    for visitor in (1, 2):
        seats.leave(visitor)
    assert (ended, seats._turned_away, seats._left_before) == ([], set(), set())


def test_a_place_is_free_again_when_the_end_fails():
    seats = Seats(1, lambda made: 1 / 0)
    seats.join(1, lambda: "a")
    with pytest.raises(ZeroDivisionError):
        seats.leave(1)
    assert len(seats) == 0


def test_after_the_end_nobody_is_let_in(seats, ended):
    seats.join(1, lambda: "a")
    seats.close()
    assert ended == ["a"]
    assert seats.join(2, lambda: pytest.fail("it is over")) is None


def test_hundreds_who_come_and_go_leave_nothing_and_are_never_too_many():
    """Joining and leaving run on threads of their own, in any order, as viser's callbacks do."""
    lock, alive, most = threading.Lock(), set(), [0]

    def make(visitor):
        with lock:
            alive.add(visitor)
            most[0] = max(most[0], len(alive))
        time.sleep(0.002 * random.random())
        if visitor % 7 == 0:
            with lock:
                alive.discard(visitor)
            raise ZeroDivisionError
        return visitor

    def discard(visitor):
        time.sleep(0.001 * random.random())
        with lock:
            alive.remove(visitor)

    seats = Seats(4, discard)

    def join(visitor):
        with contextlib.suppress(NoRoom, ZeroDivisionError):
            seats.join(visitor, lambda: make(visitor))

    threads = [
        threading.Thread(target=target, args=(visitor,))
        for visitor in range(600)
        for target in random.sample([join, seats.leave], 2)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    eventually(lambda: len(seats) == 0, 10)
    assert alive == set()
    assert 1 <= most[0] <= 4
    assert (seats._turned_away, seats._left_before) == (set(), set())

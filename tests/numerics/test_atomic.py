"""Counters shared by threads: no count is lost, and no number is drawn twice."""

from concurrent.futures import ThreadPoolExecutor
from threading import Event

import numpy as np
import pytest

from kneecore import _threads
from kneecore._jit import kernel
from kneecore.numerics.atomic import fetch, fetch_add


def _draw_in_python(counters, drawn):
    fetch_add(counters, 0)
    while fetch(counters, 0) < 2:  # so that both threads draw at once
        pass
    for i in range(len(drawn)):
        drawn[i] = fetch_add(counters, 3)
    return fetch(counters, 3)


_draw = kernel(_draw_in_python)


@pytest.mark.parametrize(("draw", "n"), [(_draw, 1_000_000), (_draw_in_python, 3000)])
def test_no_number_is_drawn_twice(draw, n):
    counters = np.zeros(8, dtype=np.int64)
    draw(counters + 2, np.zeros(1, dtype=np.int64))  # compiled before the race
    drawn = np.zeros((2, n), dtype=np.int64)
    with ThreadPoolExecutor(2) as pool:
        seen = list(pool.map(lambda mine: draw(counters, mine), drawn))
    np.testing.assert_array_equal(np.sort(drawn.ravel()), np.arange(2 * n))
    assert max(seen) == counters[3] == 2 * n
    assert counters.sum() == 2 * n + 2


def test_work_together_is_called_here_and_elsewhere():
    calls = []
    _threads.run_together(calls.append, 3)
    assert calls.count(True) == 1
    assert calls.count(False) <= 2
    _threads.run_together(calls.append, 1)
    assert calls[-1] is True


def test_an_error_of_a_helper_is_not_lost():
    began = Event()

    def work(leads):
        if leads:
            assert began.wait(60)
            return
        began.set()
        raise ValueError("lost")

    with pytest.raises(ValueError, match="lost"):
        _threads.run_together(work, 2)


def test_without_a_thread_to_be_had_the_work_is_done_here(monkeypatch):
    class Exhausted:
        def submit(self, *_):
            raise RuntimeError("can't start new thread")

    calls = []
    monkeypatch.setattr(_threads, "_pool", lambda _: Exhausted())
    _threads.run_together(calls.append, 4)
    assert calls == [True]

"""The states of a page one after the other; no page and no clock is needed."""

from dataclasses import replace

import numpy as np
import pytest

from kneecore import packaged_knee
from kneecore.knee.parameters import widened
from kneeviz.state.bounds import Bounds
from kneeviz.state.history import DEEPEST, PAUSE, History
from kneeviz.state.snapshot import Snapshot

START = Snapshot(knee=packaged_knee(), bounds=Bounds(), x=widened(packaged_knee().baseline, 32))


def with_first(value):
    x = np.array(START.x)
    x[0] = value
    return replace(START, x=x)


@pytest.fixture
def history():
    return History(START)


def record(history, value, *, who=1, what="slider", now=0.0):
    state = with_first(value)
    history.record(state, who=who, what=what, now=now)
    return state


def test_undo_and_redo_give_back_the_very_same_states(history):
    states = [START, *(record(history, k, now=10.0 * k) for k in range(1, 6))]
    assert [history.undo() for _ in range(5)] == states[-2::-1]
    assert history.undo() is None
    assert [history.redo() for _ in range(5)] == states[1:]
    assert history.redo() is None


def test_nothing_can_be_written_into_a_state():
    x = np.array(START.x)
    state = replace(START, x=x)
    x[0] = 99.0
    assert state.x[0] == START.x[0]
    with pytest.raises(ValueError, match="read-only"):
        state.x[0] = 99.0


def test_a_drag_is_one_step(history):
    for k in range(1, 50):
        record(history, k, now=0.05 * k)
    assert history.undo() is START
    assert history.undo() is None


@pytest.mark.parametrize(
    "second",
    [{"now": 2.0 * PAUSE}, {"what": "another"}],
    ids=["after a pause", "another widget"],
)
def test_what_is_another_gesture_is_another_step(history, second):
    first = record(history, 1.0)
    record(history, 2.0, **second)
    assert history.undo() is first
    assert history.undo() is START


def test_two_visitors_who_drag_at_once_make_one_step(history):
    for k in range(1, 40):
        record(history, k, who=k % 2, what=f"slider {k % 2}", now=0.05 * k)
    assert history.undo() is START
    assert history.undo() is None


def test_what_is_over_at_once_is_a_step_of_its_own(history):
    """Also while a slider of another visitor moves."""
    first = record(history, 1.0)
    second = record(history, 2.0, who=2, what=None, now=0.1)
    record(history, 3.0, who=2, what=None, now=0.2)
    assert history.undo() is second
    assert history.undo() is first


def test_a_drag_back_to_where_it_began_leaves_no_step(history):
    record(history, 1.0)
    history.record(START, who=1, what="slider", now=0.1)
    assert history.undo() is None
    record(history, 2.0, now=0.2)
    assert history.undo().same_as(START)


def test_a_change_after_undo_ends_the_way_forward(history):
    record(history, 1.0)
    history.undo()
    record(history, 2.0, now=0.1)
    assert history.redo() is None
    assert history.undo() is START


def test_what_only_follows_is_no_step(history):
    record(history, 1.0)
    followed = replace(with_first(1.0), overlay=True)
    assert history.amend(followed)
    assert history.undo() is START
    assert history.redo() is followed


def test_no_more_than_the_last_steps_are_kept(history):
    for k in range(1, DEEPEST + 20):
        record(history, k, now=10.0 * k)
    states = list(iter(history.undo, None))
    assert len(states) == DEEPEST
    assert states[-1].x[0] == 19.0


def test_what_has_changed_is_told_in_words():
    other = replace(with_first(1.0), bounds=Bounds(geometry_mm=0.5), settings=(("seed", 1),))
    assert START.changes_from(other) == ("bounds", "knee", "settings")
    assert START.changes_from(START) == ()

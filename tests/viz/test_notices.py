"""What a visitor is told once he pauses: once, and only him."""

from types import SimpleNamespace

import pytest

from kneeviz import viser_internals
from kneeviz.page.notices import QUIET_SECONDS, Notices


@pytest.fixture
def told():
    return {1: [], 2: []}


@pytest.fixture
def notices(told, monkeypatch):
    monkeypatch.setattr(viser_internals, "force_value", lambda *_: None)

    def client(number):
        add = lambda title, text, **_: told[number].append((title, text))  # noqa: E731
        return SimpleNamespace(add_notification=add, flush=lambda: None)

    return Notices(lambda: {number: client(number) for number in told}, None)


@pytest.fixture
def handle():
    return SimpleNamespace(label="Geometry, mm", value=1.0, min=0.0, max=10.0)


def test_a_fault_is_told_after_a_pause_to_its_sender(notices, told, handle):
    notices.complain(1, handle, "99 is outside 0 to 10", 99, now=0.0)
    assert notices.deliver(0.1) == QUIET_SECONDS
    assert notices.deliver(1.0) is None
    assert [title for title, _ in told[1]] == ["Not taken"]
    assert told[2] == []


def test_what_the_browser_limits_when_the_number_is_left_is_told(notices, told, handle):
    notices.complain(1, handle, "99 is outside 0 to 10", 99, now=0.0)
    notices.withdraw(1, handle, 10.0)
    assert told[1] == [("Limited", "Geometry, mm: 99 was limited to 10.")]
    assert notices.deliver(9.0) is None


@pytest.mark.parametrize(("sent", "then"), [(3, 5.0), (31, 31.5), (12, 1.0)])
def test_what_is_typed_on_is_not(notices, told, handle, sent, then):
    handle.min = 31.5 if sent == 31 else handle.min
    notices.complain(1, handle, "no", sent, now=0.0)
    notices.withdraw(1, handle, then)
    notices.deliver(9.0)
    assert told[1] == []


def test_a_list_has_no_limits(notices, told):
    choices = SimpleNamespace(label="Varies", value="both")
    notices.complain(1, choices, "no", 5, now=0.0)
    notices.withdraw(1, choices, "geometry")
    assert told[1] == []


def test_another_widgets_good_value_does_not_help(notices, told, handle):
    notices.complain(1, handle, "no", "x", now=0.0)
    notices.withdraw(1, SimpleNamespace(min=0.0, max=1.0), 1.0)
    notices.deliver(9.0)
    assert len(told[1]) == 1


def test_a_remark_for_all_comes_once_after_the_pause(notices, told):
    for n in range(5):
        notices.remark(None, "Limited", f"{n} values", now=0.1 * n)
    notices.deliver(9.0)
    assert told == {1: [("Limited", "4 values")], 2: [("Limited", "4 values")]}

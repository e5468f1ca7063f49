"""What goes out to many visitors: all of it, in order, packed once, at one beat."""

import gc
import time

import pytest
import viser
from viz.conftest import eventually
from viz.websocket_client import WebSocketClient

from kneeviz import viser_broadcast, viser_internals
from kneeviz.viser_broadcast import Broadcast


@pytest.fixture(scope="module")
def server():
    viser_internals.skip_client_build()
    viser_broadcast.install()
    running = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield running
    running.stop()


@pytest.fixture
def slider(server):
    handle = server.gui.add_slider("s", 0.0, 10.0, 0.001, 5.0)
    yield handle
    handle.remove()


@pytest.fixture
def crowd(server, slider):
    """Six visitors who have the page's state."""
    clients = [WebSocketClient(server.get_port()) for _ in range(6)]
    for client in clients:
        client.wait(lambda c: c.counts.get("ReplayDoneMessage"), 10)
    eventually(lambda: len(server.get_clients()) == 6)
    yield clients
    for client in clients:
        client.close()


def uuid_of(handle):
    return viser_internals.widget_id(handle)


def broadcast_of(server):
    return vars(server._websock_server._broadcast_buffer)["_kneeviz"]


def test_news_for_many_are_packed_once(server, slider, crowd, monkeypatch):
    packed = []
    kind = type(next(iter(server._websock_server._broadcast_buffer.message_from_id.values())))
    base = next(c for c in kind.__mro__ if "as_serializable_dict" in vars(c))
    plain = base.as_serializable_dict
    monkeypatch.setattr(
        base, "as_serializable_dict", lambda m, *a: packed.append(m) or plain(m, *a)
    )
    slider.value = 7.0
    for client in crowd:
        client.wait(lambda c: c.values[uuid_of(slider)] == 7.0, 10)
    ours = [m for m in packed if getattr(m, "uuid", None) == uuid_of(slider)]
    assert len(ours) == 1


def test_all_get_the_same_in_the_same_order(server):
    text, heard = server.gui.add_html(""), [[], [], []]
    clients = [WebSocketClient(server.get_port(), on_message=into.append) for into in heard]
    try:
        for client in clients:
            client.wait(lambda c: c.counts.get("ReplayDoneMessage"), 10)
        for number in range(200):
            text.content = f"{number}"
            time.sleep(0.001)
        for client in clients:
            client.wait(lambda c: c.props[uuid_of(text)]["content"] == "199", 10)
    finally:
        for client in clients:
            client.close()
        text.remove()
    for told in heard:
        shown = [int(m["updates"]["content"]) for m in told if "content" in m.get("updates", {})]
        assert shown == sorted(set(shown))


def test_a_visitors_own_moves_are_left_out_for_him_alone(server, slider, crowd):
    one, *others = crowd
    counts = one.counts.get("GuiUpdateMessage", 0)
    for value in (1.0, 2.0, 3.0):
        one.set(uuid_of(slider), value)
        for other in others:
            other.wait(lambda c, v=value: c.values[uuid_of(slider)] == v, 10)
    assert one.values[uuid_of(slider)] == 5.0
    assert one.counts.get("GuiUpdateMessage", 0) == counts
    slider.value = 4.0
    for client in crowd:
        client.wait(lambda c: c.values[uuid_of(slider)] == 4.0, 10)


def test_who_comes_late_is_told_all_of_it_once_and_then_that_it_is_all(server, slider):
    extra = [server.gui.add_number(f"n{k}", k) for k in range(300)]  # more than a frame's
    for k, handle in enumerate(extra):
        handle.value = k + 1000
    heard = []
    with WebSocketClient(server.get_port(), on_message=heard.append) as late:
        late.wait(lambda c: c.counts.get("ReplayDoneMessage"), 10)
        assert [late.values[uuid_of(handle)] for handle in extra] == [k + 1000 for k in range(300)]
        made = [m["uuid"] for m in heard if m["type"] == "GuiNumberMessage"]
        assert len(made) == len(set(made)) == 300
        assert late.counts["ReplayDoneMessage"] == 1
        assert late.frames >= 5  # no frame holds more than a page can take at once
    for handle in extra:
        handle.remove()


def test_nothing_goes_out_in_the_middle_of_what_belongs_together(server, slider, crowd):
    with server.atomic():
        slider.value = 8.0
        server.flush()
        time.sleep(0.2)
        assert {client.values[uuid_of(slider)] for client in crowd} == {5.0}
    for client in crowd:
        client.wait(lambda c: c.values[uuid_of(slider)] == 8.0, 10)


def test_the_clock_stops_with_the_last_visitor(server, slider):
    with WebSocketClient(server.get_port()) as one:
        one.wait(lambda c: c.counts.get("ReplayDoneMessage"), 10)
        assert broadcast_of(server)._clock is not None
    eventually(lambda: broadcast_of(server)._clock is None, 10)
    cursors = server._websock_server._broadcast_buffer.generator_cursors
    eventually(lambda: cursors == {}, 10)  # viser forgets them a little later


def test_a_server_that_stops_lets_all_of_it_end(caplog):
    running = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    with WebSocketClient(running.get_port()) as one:
        one.wait(lambda c: c.counts.get("ReplayDoneMessage"), 10)
        clock, task = broadcast_of(running), broadcast_of(running)._clock
        running.stop()
        assert task.done()
        assert clock._listeners == 0
    gc.collect()
    assert caplog.text == ""


def test_a_flush_is_followed_at_once_and_else_the_beat_is_kept(server, slider, monkeypatch):
    monkeypatch.setattr(viser_broadcast, "_BEAT", 0.5)
    monkeypatch.setattr(viser_broadcast, "_LONGEST_BEAT", 0.5)
    with WebSocketClient(server.get_port()) as one:
        one.wait(lambda c: c.counts.get("ReplayDoneMessage"), 10)
        time.sleep(0.6)
        for flush, least, most in ((True, 0.0, 0.3), (False, 0.35, 2.0)):
            start, wanted = time.monotonic(), 1.0 if flush else 2.0
            slider.value = wanted
            if flush:
                server.flush()
            one.wait(lambda c, w=wanted: c.values[uuid_of(slider)] == w, 10)
            assert least <= time.monotonic() - start < most


class TestBeats:
    """How often: the more listen, the rarer, unless there is a flush."""

    @pytest.fixture
    def beats(self, server, slider, monkeypatch):
        def count(listeners, seconds=0.6):
            with WebSocketClient(server.get_port()) as one:
                one.wait(lambda c: c.counts.get("ReplayDoneMessage"), 10)
                clock, frames = broadcast_of(server), one.frames
                monkeypatch.setattr(clock, "_listeners", listeners)
                end, value = time.monotonic() + seconds, 0.0
                while time.monotonic() < end:
                    slider.value = value = value + 0.001
                    time.sleep(0.001)
                counted = one.frames - frames
                monkeypatch.setattr(clock, "_listeners", 1)
            eventually(lambda: clock._clock is None, 10)
            return counted

        return count

    def test_many_are_told_rarely_though_news_never_end(self, beats):
        assert beats(50) <= 8  # one each 0.1 s, not one a message
        assert beats(1) > 15


def test_who_reads_slowly_is_sent_the_latest_only(server, slider):
    clock = Broadcast(server._websock_server._broadcast_buffer)
    for value in (1.0, 2.0, 3.0):
        slider.value = value
    end = server._websock_server._broadcast_buffer.message_counter - 1
    messages, last = clock._between(end - 3, end)
    assert last == end
    assert [m.updates["value"] for m in messages] == [3.0]

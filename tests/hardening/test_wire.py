"""The real server under attack for some seconds; ``run.py`` does the same for minutes."""

import contextlib
import os
import re
import time

import msgspec
import pytest
from hardening import attacks
from hardening.served import Honest, serving
from viz.conftest import eventually
from viz.websocket_client import CAMERA, WebSocketClient
from websockets.exceptions import ConnectionClosed

from kneeviz import viser_internals
from kneeviz.server import caps
from kneeviz.server.app import App


@pytest.fixture(scope="module")
def served():
    with serving() as running:
        yield running
        assert running.said == "", "strangers must not fill the log"


@pytest.fixture(scope="module")
def app():
    running = App(port=0)
    try:
        eventually(lambda: running.page.model_ready)
        yield running
    finally:
        running.stop()


def served_well(honest, limit_ms=1000.0):
    """The limit is for a busy machine; on a quiet one it is some ms."""
    assert honest.failure is None
    assert len(honest.seconds) >= 5
    assert honest.p95_ms < limit_ms


def held_files(served):
    return len(os.listdir(f"/proc/{served.pid}/fd"))


def test_hostile_messages_harm_nobody(served):
    before = served.memory_mb
    with Honest(served.port) as honest:
        sent = attacks.fuzz(served.port, 4.0)
    assert sent > 100
    served_well(honest)
    assert served.memory_mb - before < 150.0


def test_three_hundred_half_open_connections_keep_nobody_out(served):
    with Honest(served.port) as honest, attacks.half_open(served.port, 300) as held:
        assert len(held) > 200
        with WebSocketClient(served.port) as newcomer:
            newcomer.wait(lambda c: c.counts.get("ReplayDoneMessage"), 10)
            time.sleep(1.0)
            assert held_files(served) < caps.MAX_CONNECTIONS + 60
    served_well(honest, 4000.0)  # a hundred who ask for the state at once are sent it


def test_what_waits_to_be_read_is_little(served):
    before = served.memory_mb
    with attacks.large_messages(served.port, 24, 3.0) as sent_mb:
        assert sent_mb > 200.0
        assert served.memory_mb - before < 170.0


def test_who_does_not_read_keeps_nobody_waiting(served):
    with attacks.stalled(served.port, 16), Honest(served.port) as honest:
        time.sleep(2.0)
    served_well(honest)


def test_who_reads_slowly_keeps_nobody_waiting(served):
    before = served.memory_mb
    with attacks.slow(served.port, 16) as read, Honest(served.port) as honest:
        time.sleep(2.5)
    assert min(read) > 1000
    served_well(honest)
    assert served.memory_mb - before < 60.0


def test_files_made_to_keep_a_parser_busy_are_refused_meanwhile(served):
    files = [f for f in attacks.long_files() if f[0] in ("dots.toml", "deep.json", "objects.json")]
    with Honest(served.port) as honest, WebSocketClient(served.port) as client:
        client.wait(lambda c: c.counts.get("ReplayDoneMessage"), 10)
        for number, (name, content) in enumerate(files):
            attacks.send_file(client, name, content, number)
            client.wait(lambda c, n=number: len(c.notifications) > n, 20)
        told = [one["props"]["body"] for one in client.notifications]
    assert len(told) == len(files)
    assert all("given up" not in body and len(body) < 400 for body in told), told
    served_well(honest)


def test_who_sends_a_byte_at_a_time_keeps_nobody_waiting(served):
    with Honest(served.port) as honest:
        assert attacks.trickle(served.port, 2.0) > 100
    served_well(honest)


class TestMessages:
    def test_a_large_message_ends_the_connection_before_it_is_read(self, app):
        with WebSocketClient(app.server.get_port()) as client:
            client.wait(lambda c: c.counts.get("ReplayDoneMessage"))
            with contextlib.suppress(ConnectionClosed):
                client.send_raw(b"\x00" * (caps.MAX_MESSAGE + 1))
            client._reader.join(10.0)
            with pytest.raises(ConnectionClosed) as closed:
                client.send(CAMERA)
            assert closed.value.rcvd.code == 1009

    def test_a_flood_is_read_at_the_pace_and_nothing_of_it_is_lost(self, app, monkeypatch):
        taken = []
        guarded = app.server.gui._websock_interface._incoming_handlers
        kind = next(k for k in guarded if k.__name__ == "GuiUpdateMessage")
        monkeypatch.setitem(guarded, kind, [lambda client, message: taken.append(message.uuid)])
        with WebSocketClient(app.server.get_port()) as client:
            start = time.monotonic()
            for number in range(800):
                client.set(str(number), 1.0)
            eventually(lambda: len(taken) == 800, 30)
            took = time.monotonic() - start
        assert taken == [str(number) for number in range(800)]
        assert took > 0.8 * (800 - caps.BURST) / caps.MESSAGES_PER_SECOND

    def test_who_only_listens_is_told_the_state_and_then_little(self, app):
        app.page.playback.play(True)
        app.page.touched = True
        with WebSocketClient(app.server.get_port()) as joined:
            joined.wait(lambda c: c.frames > 2 * caps.FREE_FRAMES, 20)
            with attacks._speechless(app.server.get_port()) as silent:
                frames, end = 0, time.monotonic() + 3.0
                with contextlib.suppress(TimeoutError):
                    while time.monotonic() < end:
                        silent.recv(timeout=0.5)
                        frames += 1
                assert 3 <= frames <= caps.FREE_FRAMES + 6
                silent.send(msgspec.msgpack.encode(CAMERA))
                for _ in range(2 * caps.FREE_FRAMES):
                    silent.recv(timeout=1.0)

    def test_nobody_is_given_a_tunnel(self, app, monkeypatch):
        asked = []
        monkeypatch.setattr(app.server, "request_share_url", lambda *_: asked.append(1))
        with WebSocketClient(app.server.get_port()) as client:
            client.wait(lambda c: c.counts.get("ReplayDoneMessage"))
            client.send({"type": "ShareUrlRequest"})
            client.send({"type": "ShareUrlDisconnect"})
            time.sleep(0.3)
        assert asked == []


class TestUploads:
    @pytest.fixture(autouse=True)
    def nothing_under_way(self, app):
        eventually(lambda: not viser_internals.unfinished_uploads(), 10)

    def test_a_visitor_has_few_under_way_and_they_go_with_him(self, app):
        with WebSocketClient(app.server.get_port()) as client:
            attacks.begin_uploads(client, 3)
            client.wait(lambda c: c.notifications)
            assert len(viser_internals.unfinished_uploads()) <= viser_internals._PENDING
            assert "not finished" in client.notifications[0]["props"]["body"]
        eventually(lambda: not viser_internals.unfinished_uploads(), 10)

    def test_who_has_not_joined_cannot_begin_one(self, app):
        """viser tidies up behind those only who have said where their camera is."""
        port, button = app.server.get_port(), viser_internals.widget_id(app.page.view.files.upload)
        start = {
            "type": "FileTransferStartUpload", "source_component_uuid": button, "filename": "x",
            "transfer_uuid": "stray", "mime_type": "", "part_count": 2, "size_bytes": 10,
        }  # fmt: skip
        with attacks._speechless(port) as silent:
            silent.send(msgspec.msgpack.encode(start))
            time.sleep(0.3)
            assert viser_internals.unfinished_uploads() == {}
            silent.send(msgspec.msgpack.encode(CAMERA))
            silent.send(msgspec.msgpack.encode(start))
            eventually(lambda: list(viser_internals.unfinished_uploads()) == ["stray"], 10)

    def test_all_visitors_together_hold_little(self, app):
        clients = [WebSocketClient(app.server.get_port()) for _ in range(5)]
        try:
            for client in clients:
                attacks.begin_uploads(client, 1)
            clients[-1].wait(lambda c: c.notifications)
            pending = viser_internals.unfinished_uploads().values()
            held = sum(state["total_bytes"] for state in pending)
            assert held <= viser_internals._PENDING_BYTES_OF_ALL
        finally:
            for client in clients:
                client.close()

    def test_one_that_does_not_go_on_is_given_up(self, app, monkeypatch):
        with (
            WebSocketClient(app.server.get_port()) as idle,
            WebSocketClient(app.server.get_port()) as other,
        ):
            attacks.begin_uploads(idle, 1, size=1000)
            eventually(lambda: len(viser_internals.unfinished_uploads()) == 1, 10)
            monkeypatch.setattr(viser_internals, "_PATIENCE", 0.0)
            attacks.begin_uploads(other, 1, size=1000)
            eventually(lambda: [*viser_internals.unfinished_uploads()] == [f"{id(other)}-0"], 10)

    def test_nobody_takes_over_another_s(self, app):
        with (
            WebSocketClient(app.server.get_port()) as one,
            WebSocketClient(app.server.get_port()) as two,
        ):
            attacks.begin_uploads(one, 1, size=1000)
            eventually(lambda: len(viser_internals.unfinished_uploads()) == 1, 10)
            (name,), (state,) = zip(*viser_internals.unfinished_uploads().items(), strict=True)
            two.send(
                {"type": "FileTransferStartUpload", "transfer_uuid": name, "filename": "x",
                 "source_component_uuid": attacks.upload_button(two), "mime_type": "",
                 "part_count": 1, "size_bytes": 5}
            )  # fmt: skip
            two.wait(lambda c: c.notifications)
            assert viser_internals.unfinished_uploads()[name] is state

    def test_acknowledgements_do_not_pile_up(self, app):
        buffer = app.server._websock_server._broadcast_buffer

        def acks():
            return sum(
                type(message).__name__ == "FileTransferPartAck"
                for message in list(buffer.message_from_id.values())
            )

        answered = []
        with WebSocketClient(app.server.get_port(), on_message=answered.append) as client:
            button = attacks.upload_button(client)
            for number in range(150):
                client.upload(button, f"{number}.txt", b"x")
            client.wait(
                lambda _: any(m.get("transfer_uuid") == "transfer-149.txt" for m in answered), 30
            )
            assert acks() <= viser_internals._ACKS_KEPT + 2


def test_the_address_is_as_it_was_printed(served):
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+", served.url)

"""Strangers at the real server's door: pages of other sites, false names, no token."""

import asyncio
import http.client
import os
import socket
import threading

import pytest
import viser
from hardening.served import serving
from viz.conftest import eventually
from viz.websocket_client import WebSocketClient
from websockets.asyncio import server as sockets
from websockets.exceptions import InvalidStatus

from kneeviz.server import front
from kneeviz.server.app import App
from kneeviz.server.gate import Gate

TOKEN = "the-token-of-this-test"


@pytest.fixture(scope="module")
def app():
    running = App(port=0, token=False)
    yield running
    running.stop()


@pytest.fixture(scope="module")
def guarded():
    running = App(port=0, token=TOKEN)
    yield running
    running.stop()


def page(app, path="/", **headers):
    """Ask for the page; return status, headers and text."""
    line = http.client.HTTPConnection("127.0.0.1", app.server.get_port(), timeout=10)
    try:
        line.request("GET", path, headers=headers)
        answer = line.getresponse()
        return answer.status, answer.headers, answer.read()
    finally:
        line.close()


def refused(app, **options):
    """Tell whether a WebSocket is refused with 403 and a line, before any state is sent."""
    answer = None
    try:
        WebSocketClient(app.server.get_port(), **options).close()
    except InvalidStatus as refusal:
        answer = refusal.response
    return answer is not None and answer.status_code == 403 and len(answer.body) < 300


def raw_handshake(port, host, origin="", version=f"viser-v{viser.__version__}"):
    """Open a WebSocket by hand, with any Host; return the first line of the answer."""
    with socket.create_connection(("127.0.0.1", port), 10) as line:
        line.sendall(
            f"GET / HTTP/1.1\r\nHost: {host}\r\n{origin}Upgrade: websocket\r\n"
            "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
            f"Sec-WebSocket-Protocol: {version}\r\n\r\n".encode()
        )
        return line.recv(200).split(b"\r\n")[0].decode()


def test_our_own_page_is_let_in(app):
    port = app.server.get_port()
    assert page(app)[0] == 200
    assert not refused(app, headers={"Origin": f"http://127.0.0.1:{port}"})
    assert "101" in raw_handshake(port, f"localhost:{port}")


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "http://127.0.0.1:1", "null", "https://localhost"]
)
def test_a_page_of_another_site_is_refused(app, origin):
    eventually(lambda: not app.server.get_clients(), 10)
    assert refused(app, headers={"Origin": origin})
    assert page(app, Origin=origin)[0] == 403
    assert not app.server.get_clients()


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example:80", "192.0.2.7"])
def test_a_name_that_only_points_here_is_refused(app, host):
    status, _, text = page(app, Host=host)
    assert status == 403
    assert len(text) < 300
    assert "403" in raw_handshake(app.server.get_port(), host, f"Origin: http://{host}\r\n")


def test_without_the_token_nobody_is_let_in(guarded):
    assert page(guarded)[0] == 403
    assert page(guarded, "/index.html")[0] == 403
    assert page(guarded, "/?token=wrong-but-long-enough")[0] == 403
    assert refused(guarded)
    assert refused(guarded, headers={"Cookie": "kneeviz-1=x"})


def test_with_the_token_the_page_and_what_it_opens_are_let_in_again(guarded):
    status, headers, _ = page(guarded, f"/?token={TOKEN}&fixedDpr=0.5")
    assert status == 200
    cookie = headers["Set-Cookie"].split(";")[0]
    assert page(guarded, Cookie=cookie)[0] == 200, "the page is loaded again"
    assert not refused(guarded, headers={"Cookie": cookie})
    assert not refused(guarded, path=f"/?token={TOKEN}")
    assert guarded.url.endswith(f"/?token={TOKEN}")


@pytest.mark.parametrize("version", ["viser-v0.0.1", "other", "viser-v0, viser-v1.1.1"])
def test_a_page_of_another_version_is_refused_and_fills_no_log(app, capfd, version):
    port = app.server.get_port()
    assert "400" in raw_handshake(port, f"localhost:{port}", version=version)
    assert capfd.readouterr().out == ""


def test_the_page_cannot_be_framed_and_tells_nobody_its_address(app):
    _, headers, _ = page(app)
    assert "frame-ancestors 'self'" in headers["Content-Security-Policy"]
    assert headers["Referrer-Policy"] == "no-referrer"


def test_if_viser_starts_its_server_otherwise_nothing_is_served():
    real = sockets.serve
    with pytest.raises(RuntimeError, match="guarded"), front.standing(Gate(host="127.0.0.1")):
        pass
    assert sockets.serve is real


def test_other_servers_of_this_process_are_left_alone():
    asked = []

    async def one():
        async with sockets.serve(lambda _: None, "127.0.0.1", 0) as server:
            asked.append(server.process_request)

    def served():  # on a thread: after the browser tests this one has a running loop
        thread = threading.Thread(target=lambda: asyncio.run(one()))
        thread.start()
        thread.join()

    with pytest.raises(RuntimeError, match="guarded"), front.standing(Gate(host="127.0.0.1")):
        served()
    assert asked == [None]


def test_on_all_addresses_the_printed_one_has_a_token_and_the_risk_is_named():
    with serving("--host", "0.0.0.0") as served:
        assert "/?token=" in served.url
        assert served.url.startswith("http://127.0.0.1:")
        assert "warning: whoever has the token" in served.said
        raw_handshake(served.port, "a b\r\nnonsense")
        path = served.url.partition(str(served.port))[2]
        with WebSocketClient(served.port, path=path) as client:
            client.wait(lambda c: c.counts.get("ReplayDoneMessage"))
        with pytest.raises(InvalidStatus):
            WebSocketClient(served.port)
        assert "Traceback" not in served.said, "strangers must not fill the log"


def test_the_token_may_be_one_s_own_and_may_be_left_out():
    with serving("--token", environment={"KNEEVIZ_TOKEN": TOKEN}) as served:
        assert served.url == f"http://127.0.0.1:{served.port}/?token={TOKEN}"
        assert served.said == ""
    with serving("--host", "0.0.0.0", "--no-token", "--allow-host", "knee.example.org") as served:
        assert "token" not in served.url
        assert "warning: whoever can reach" in served.said
        assert "101" in raw_handshake(served.port, "knee.example.org")


@pytest.mark.skipif(
    not socket.has_ipv6 or not os.path.exists("/proc/net/if_inet6"), reason="no IPv6"
)
def test_an_address_of_version_6_is_printed_in_brackets():
    with serving("--host", "::1") as served:
        assert served.url == f"http://[::1]:{served.port}"
        line = http.client.HTTPConnection("::1", served.port, timeout=10)
        line.request("GET", "/")
        assert line.getresponse().status == 200
        line.close()


def test_a_stopped_app_frees_its_port():
    running = App(port=0)
    port = running.server.get_port()
    running.stop()
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.1", port), 10)

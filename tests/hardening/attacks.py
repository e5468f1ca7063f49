"""What strangers do to a server, each for a given time or number."""

import contextlib
import random
import socket
import struct
import threading
import time
from collections.abc import Iterator

import msgspec
import viser
from hardening.hostile import hostile_messages
from viz.websocket_client import CAMERA, WebSocketClient
from websockets.exceptions import WebSocketException
from websockets.sync.client import ClientConnection, connect

from kneeviz import viser_internals

HANDSHAKE = (
    "GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
    f"Sec-WebSocket-Protocol: viser-v{viser.__version__}\r\n\r\n"
)
PART = 512 * 1024
"""Bytes; what a page sends at once of a file."""


def fuzz(port: int, seconds: float, *, at_once: int = 2, seed: int = 0) -> int:
    """Send hostile messages over `at_once` connections; return how many were sent."""
    end, sent, lock = time.monotonic() + seconds, [0], threading.Lock()

    def attack(number: int) -> None:
        turn = 0
        while time.monotonic() < end:
            turn += 1
            count = _fuzz_one(port, end, seed=1000 * seed + 100 * number + turn)
            with lock:
                sent[0] += count

    threads = [threading.Thread(target=attack, args=(n,), daemon=True) for n in range(at_once)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(seconds + 30)
    return sent[0]


def _fuzz_one(port: int, end: float, *, seed: int) -> int:
    """Attack over one connection until it is closed, or it is time to come back anew."""
    sent, rng = 0, random.Random(seed)
    with contextlib.suppress(OSError, WebSocketException, AssertionError):
        if rng.random() < 0.3:
            client: WebSocketClient | ClientConnection = _speechless(port)
            send, widgets = client.send, []
        else:
            client = WebSocketClient(port)
            client.wait(lambda c: c.counts.get("ReplayDoneMessage"), 10)
            send, widgets = client.send_raw, sorted(client.props)
        with client:
            for raw in hostile_messages(seed, widgets):
                if time.monotonic() > end or sent >= 300:
                    break
                send(raw)
                sent += 1
    return sent


def _speechless(port: int) -> ClientConnection:
    """Connect and do not say where the camera is, as every page does first."""
    return connect(
        f"ws://127.0.0.1:{port}",
        subprotocols=[f"viser-v{viser.__version__}"],
        compression=None,
        max_size=None,
        close_timeout=1.0,
    )


@contextlib.contextmanager
def half_open(port: int, count: int) -> Iterator[list[socket.socket]]:
    """Hold `count` connections that were begun and never finished, in four ways."""
    held: list[socket.socket] = []
    shake = HANDSHAKE.format(port=port).encode()
    begun = (b"", shake[:60], shake, shake + b"\x82\xff" + struct.pack(">Q", 600_000) + b"\x00" * 9)
    try:
        for number in range(count):
            # The server may drop one while it is made: that is its right.
            with contextlib.suppress(OSError):
                one = socket.create_connection(("127.0.0.1", port), timeout=5)
                held.append(one)
                one.sendall(begun[number % len(begun)])
        yield held
    finally:
        for one in held:
            one.close()


@contextlib.contextmanager
def stalled(port: int, count: int) -> Iterator[list[socket.socket]]:
    """Hold `count` visitors who have joined and never read what they are sent."""
    held: list[socket.socket] = []
    try:
        for _ in range(count):
            one = socket.socket()
            one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            one.settimeout(5)
            one.connect(("127.0.0.1", port))
            one.sendall(HANDSHAKE.format(port=port).encode())
            one.sendall(_frame(msgspec.msgpack.encode(CAMERA)))
            held.append(one)
        yield held
    finally:
        for one in held:
            one.close()


@contextlib.contextmanager
def slow(port: int, count: int) -> Iterator[list[int]]:
    """Hold `count` visitors who read a few kB a second; yield the bytes that each has read."""
    over, read = threading.Event(), [0] * count

    def sip(number: int, line: socket.socket) -> None:
        line.settimeout(0.1)
        while not over.wait(0.1):
            with contextlib.suppress(TimeoutError, OSError):
                read[number] += len(line.recv(500))

    with stalled(port, count) as held:
        threads = [
            threading.Thread(target=sip, args=(number, line), daemon=True)
            for number, line in enumerate(held)
        ]
        for thread in threads:
            thread.start()
        yield read
        over.set()
        for thread in threads:
            thread.join(5)


def long_files() -> list[tuple[str, bytes]]:
    """Return files that keep a parser busy, or did once, of the largest size that is taken."""
    size = viser_internals.MAX_UPLOAD - 10_000
    return [
        ("dots.toml", b"a" + b".a" * 20_000 + b" = 1\n"),
        ("dots.toml", b"".join(b"a" + b".a" * 20 + b" = 1\n" for _ in range(20_000))),
        ("quotes.toml", b'a = """' + b'\\"' * 20_000),
        ("many.toml", b"".join(b"[a%d.b.c.d.e.f.g.h]\n" % k for k in range(3000))),
        ("remarks.toml", b"#x\n" * (size // 3)),
        ("deep.json", b"[" * size),
        ("objects.json", b'{"schema":[' + b'{"a":1},' * (size // 8) + b"0]}"),
        ("digits.json", b'{"schema":' + b"9" * size + b"}"),
        ("numbers.json", b'{"schema":[' + b"1e9," * (size // 4) + b"0]}"),
    ]


def send_file(client: WebSocketClient, name: str, content: bytes, number: int) -> None:
    """Upload a file in parts, as a page does."""
    common = {"source_component_uuid": upload_button(client), "transfer_uuid": f"file-{number}"}
    parts = [content[at : at + PART] for at in range(0, len(content), PART)]
    client.send(
        {"type": "FileTransferStartUpload", "filename": name, "mime_type": "",
         "part_count": len(parts), "size_bytes": len(content)} | common
    )  # fmt: skip
    for index, part in enumerate(parts):
        client.send({"type": "FileTransferPart", "part_index": index, "content": part} | common)


def _frame(content: bytes) -> bytes:
    """Return a masked binary frame (mask of zeros)."""
    return b"\x82\xfe" + struct.pack(">H", len(content)) + bytes(4) + content


@contextlib.contextmanager
def large_messages(port: int, count: int, seconds: float) -> Iterator[float]:
    """Hold `count` visitors who sent large messages as fast as they went; yield the MB sent."""
    sent, end = [0] * count, time.monotonic() + seconds
    part = {"type": "FileTransferPart", "source_component_uuid": None, "transfer_uuid": "t"}
    content = msgspec.msgpack.encode(part | {"part_index": 0, "content": b"x" * 600_000})
    frame = b"\x82\xff" + struct.pack(">Q", len(content)) + bytes(4) + content

    def push(number: int, line: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while time.monotonic() < end:
                line.settimeout(max(end - time.monotonic(), 0.1))
                line.sendall(frame)
                sent[number] += len(frame)

    with stalled(port, count) as held:
        threads = [
            threading.Thread(target=push, args=(number, line), daemon=True)
            for number, line in enumerate(held)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(seconds + 10)
        yield sum(sent) / 1e6


def trickle(port: int, seconds: float, *, count: int = 20) -> int:
    """Send requests and messages a byte at a time over `count` connections; return the bytes."""
    text = HANDSHAKE.format(port=port).encode() + _frame(msgspec.msgpack.encode(CAMERA))
    with contextlib.ExitStack() as stack:
        lines = [
            stack.enter_context(socket.create_connection(("127.0.0.1", port), 5))
            for _ in range(count)
        ]
        end, sent = time.monotonic() + seconds, 0
        while time.monotonic() < end and sent // count < len(text):
            for line in lines:
                with contextlib.suppress(OSError):
                    line.sendall(text[sent // count : sent // count + 1])
                sent += 1
            time.sleep(0.01)
    return sent


def upload_button(client: WebSocketClient) -> str:
    """Return the id of the button that takes files."""
    return client.wait(lambda c: next((u for u, p in c.props.items() if "mime_type" in p), None))


def begin_uploads(
    client: WebSocketClient, count: int, *, size: int = viser_internals.MAX_UPLOAD
) -> None:
    """Announce `count` files of `size` bytes and send all but the last part of each."""
    button, parts = upload_button(client), -(-size // PART)
    for number in range(count):
        common = {
            "source_component_uuid": button,
            "transfer_uuid": f"{id(client)}-{number}",
        }
        client.send(
            {"type": "FileTransferStartUpload", "filename": "x.toml", "mime_type": "",
             "part_count": parts, "size_bytes": size} | common
        )  # fmt: skip
        for index in range(parts - 1):
            content = b"x" * min(PART, size)
            client.send(
                {"type": "FileTransferPart", "part_index": index, "content": content} | common
            )


def flood(client: WebSocketClient, count: int) -> float:
    """Send `count` small messages as fast as they go; return the seconds until all were taken."""
    start = time.monotonic()
    for _ in range(count):
        client.send({"type": "GuiUpdateMessage", "uuid": "nobody", "updates": {"value": 1.0}})
    return time.monotonic() - start

"""Visitors who leave before they have come: joined, and gone some milliseconds later."""

import random
import threading
import time

import msgspec
import viser
from viz.websocket_client import CAMERA
from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

from kneeviz.server.app import App


def leave_early(port: int, seconds: float, *, politely: bool) -> bool:
    """Join, stay for `seconds`, and go, with a closing handshake or without; tell if let in."""
    try:
        socket = connect(
            f"ws://127.0.0.1:{port}",
            subprotocols=[f"viser-v{viser.__version__}"],
            compression=None,
            max_size=None,
            close_timeout=2.0,
        )
        socket.send(msgspec.msgpack.encode(CAMERA))
        time.sleep(seconds)
        if politely:
            socket.close()
        else:
            socket.socket.close()
    except (OSError, WebSocketException):
        return False
    return True


def hail_of_leavers(port: int, count: int, *, at_once: int = 24, seed: int = 0) -> int:
    """Let `count` visitors come and go within 0 to 40 ms, many at once; return how many got in."""
    rng = random.Random(seed)
    stays = [(0.04 * rng.random(), rng.random() < 0.5) for _ in range(count)]
    lock, got_in = threading.Lock(), [0]

    def come_and_go() -> None:
        while True:
            with lock:
                if not stays:
                    return
                seconds, politely = stays.pop()
            came = leave_early(port, seconds, politely=politely)
            with lock:
                got_in[0] += came

    threads = [threading.Thread(target=come_and_go, daemon=True) for _ in range(at_once)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return got_in[0]


class Watchdog:
    """Counts the sessions of an app that are alive at the same time, while it is in use."""

    def __init__(self, app: App) -> None:
        self.most, self._alive, self._lock = 0, 0, threading.Lock()
        make, end = app._session, app._end

        def counted(*arguments: object) -> object:
            with self._lock:
                self._alive += 1
                self.most = max(self.most, self._alive)
            try:
                return make(*arguments)
            except BaseException:
                with self._lock:
                    self._alive -= 1
                raise

        def ended(session: object) -> None:
            end(session)
            with self._lock:
                self._alive -= 1

        app._session = counted  # type: ignore[method-assign]
        app._end = ended  # type: ignore[method-assign]
        app.seats._discard = ended

    @property
    def alive(self) -> int:
        with self._lock:
            return self._alive

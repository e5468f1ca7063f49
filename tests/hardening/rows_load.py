"""Rows of load: many visitors who drag, one who searches, and some minutes of use."""

import contextlib
import math
import threading
import time

import msgspec
import numpy as np
import viser
from hardening.rows import Outcome, Scale, row
from hardening.served import LABEL, Honest, serving, slider
from viz.websocket_client import CAMERA, WebSocketClient
from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

SEARCH = "Worst case (true model)"
DRAGS_PER_SECOND = 20.0
"""What a browser sends while a slider moves."""


class Dragger:
    """A visitor who drags a slider and takes what he is sent, without looking at it."""

    def __init__(self, port: int, uuid: str, low: float, high: float) -> None:
        self.sent, self.failure = 0, ""
        self._move = (uuid, low, high)
        self._over = threading.Event()
        self._socket = connect(
            f"ws://127.0.0.1:{port}",
            subprotocols=[f"viser-v{viser.__version__}"],
            compression=None,
            max_size=None,
        )
        self._socket.send(msgspec.msgpack.encode(CAMERA))
        self._threads = [
            threading.Thread(target=work, daemon=True) for work in (self._read, self._drag)
        ]
        for thread in self._threads:
            thread.start()

    def _read(self) -> None:
        with contextlib.suppress(WebSocketException, OSError):
            for _ in self._socket:
                pass

    def _drag(self) -> None:
        uuid, low, high = self._move
        try:
            while not self._over.wait(1.0 / DRAGS_PER_SECOND):
                value = low + (high - low) * (0.5 + 0.4 * math.sin(0.05 * self.sent))
                update = {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}}
                self._socket.send(msgspec.msgpack.encode(update))
                self.sent += 1
        except Exception as error:
            self.failure = f"{type(error).__name__}: {error}"

    def close(self) -> None:
        """Let go and leave."""
        self._over.set()
        self._threads[1].join(10)
        self._socket.close()
        self._threads[0].join(10)


def others_sliders(client: WebSocketClient) -> list[tuple[str, float, float]]:
    """Return id and range of the sliders that the honest visitor leaves alone."""
    own = slider(client)
    return [
        (uuid, props["min"], props["max"])
        for uuid, props in client.props.items()
        if {"min", "max", "step", "label"} <= set(props)
        and uuid != own
        and " femur " in f"{props['label']} "
        and props["label"] != LABEL
    ]


def height_mm(client: WebSocketClient) -> float:
    """Return where the ACL's femoral end is drawn, which only its own slider moves, mm."""
    return 1e3 * float(client.scene["/knee/ligament_ACL"]["points"].reshape(2, 3)[0, 1])


def drag_and_measure(client: WebSocketClient, seconds: float) -> np.ndarray:
    """Move the honest visitor's slider for a while; return how long each answer took, ms."""
    own, took, end = slider(client), [], time.monotonic() + seconds
    client.wait(lambda c: "points" in c.scene.get("/knee/ligament_ACL", {}))
    values = np.random.default_rng(0).permutation(np.linspace(-1.2, 0.6, 181).round(2))
    for turn in range(10**6):
        if time.monotonic() > end:
            break
        before, value = height_mm(client), float(values[turn % len(values)])
        start = time.perf_counter()
        client.set(own, value)
        arrived = client.wait(
            lambda c, was=before: abs(height_mm(c) - was) > 1e-9 and c.arrived, 30
        )
        took.append(max(arrived - start, 0.0))
        time.sleep(0.1)
    return 1e3 * np.array(took)


@row("Thirty-two visitors drag while one searches")
def crowd(scale: Scale) -> Outcome:
    """Let thirty-two visitors of one knee drag while the true model is searched."""
    with (
        serving() as served,
        WebSocketClient(served.port) as client,
        contextlib.ExitStack() as stack,
    ):
        client.wait(lambda c: c.counts.get("ReplayDoneMessage"))
        search = slider(client, SEARCH)
        client.wait(lambda c: not c.props[search]["disabled"], 60)
        sliders = others_sliders(client)
        draggers = [Dragger(served.port, *sliders[n % len(sliders)]) for n in range(32)]
        for dragger in draggers:
            stack.callback(dragger.close)
        searches, end = 0, time.monotonic() + scale.seconds
        parts = []
        while time.monotonic() < end:
            if not client.props[search]["disabled"]:  # the last one has ended
                client.set(search, True)
                searches += 1
            parts.append(drag_and_measure(client, 2.0))
        took = np.concatenate(parts)
        sent = sum(dragger.sent for dragger in draggers)
        failed = sum(bool(dragger.failure) for dragger in draggers)
        quiet = served.said == ""
    return Outcome(
        injected=f"{sent:,} moves and {searches} searches in {scale.seconds:.0f} s",
        happened=f"{len(took)} moves of one more visitor answered, "
        f"95 % within {np.percentile(took, 95):.0f} ms; {failed} visitors cut off",
        sound=failed == 0 and sent > 0 and quiet and bool(np.percentile(took, 95) < 1000.0),
    )


@row("Minutes of use")
def soak(scale: Scale) -> Outcome:
    """Let visitors drag, leave and come again, and see whether the server grows."""
    seconds, moves = 3.0 * scale.seconds, 0
    with serving() as served, Honest(served.port) as honest:
        time.sleep(min(20.0, 0.3 * seconds))
        before, end = served.memory_mb, time.monotonic() + seconds
        while time.monotonic() < end:
            with WebSocketClient(served.port) as learner:
                learner.wait(lambda c: c.counts.get("ReplayDoneMessage"))
            time.sleep(0.5)
            moves += 1
        grew = served.memory_mb - before
        said, p95 = served.said, honest.p95_ms
    return Outcome(
        injected=f"{seconds / 60.0:.1f} min, {moves} visitors coming and going",
        happened=f"{len(honest.seconds):,} slider moves of an honest visitor answered rightly, "
        f"95 % within {p95:.0f} ms; memory {grew:+.0f} MB",
        sound=honest.failure is None and said == "" and grew < 60.0,
    )

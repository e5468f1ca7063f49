"""Rows of load: many visitors who drag, one who searches, and some minutes of use."""

import contextlib
import math
import threading
import time
from collections.abc import Iterator

import msgspec
import numpy as np
import viser
from hardening.attacks import upload_button
from hardening.rows import Guard, Outcome, Scale, row
from hardening.served import LABEL, Honest, Served, serving, slider
from viz.websocket_client import CAMERA, WebSocketClient
from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

SEARCH, SURROGATE = "Worst case (true model)", "Worst case (surrogate)"
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


@contextlib.contextmanager
def thirty_two_draggers() -> Iterator[tuple[Served, WebSocketClient, list[Dragger]]]:
    """Start a server that can search, with one honest visitor and thirty-two who drag."""
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
        yield served, client, draggers


def _crowd_limit_ms(scale: Scale) -> float:
    """Return what is asked of the long run on a quiet machine, or of the short one on any."""
    return 100.0 if scale.share == 1.0 else 400.0


@row(
    "Thirty-two visitors drag while one searches",
    Guard(
        file="kneeviz/viser_broadcast.py",
        function="Broadcast.frame",
        line="known = self._windows.get((cursor, end))",
        instead="known = None",
        test="tests/viz/test_broadcast.py -k packed_once",
    ),
)
def crowd(scale: Scale) -> Outcome:
    """Let thirty-two visitors of one knee drag while the true model is searched."""
    with thirty_two_draggers() as (served, client, draggers):
        search = slider(client, SEARCH)
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
        sound=failed == 0
        and sent > 500 * scale.seconds
        and quiet
        and bool(np.percentile(took, 95) < _crowd_limit_ms(scale)),
    )


def drop_in(port: int, turn: int) -> None:
    """Come, look, search in the surrogate or load a file that is none, and go."""
    with WebSocketClient(port) as learner:
        learner.wait(lambda c: c.counts.get("ReplayDoneMessage"))
        search = slider(learner, SURROGATE)
        if turn % 3 == 1 and not learner.props[search]["disabled"]:
            learner.set(search, True)
            learner.wait(lambda c: c.props[search]["disabled"], 20)
        if turn % 3 == 2:
            learner.upload(upload_button(learner), f"{turn}.json", b"[" * 1000)
            learner.wait(lambda c: c.notifications, 30)


@row(
    "Minutes of use",
    Guard(
        file="kneeviz/viser_internals.py",
        function="_forget_old_acks",
        line="for number in acks[:-_ACKS_KEPT]:",
        instead="for number in ():",
        test="tests/hardening/test_wire.py -k pile_up",
    ),
)
def soak(scale: Scale) -> Outcome:
    """Let visitors come, search, load files and go, and see whether the server grows."""
    seconds, turns, held = 3.0 * scale.seconds, 0, []
    with serving() as served, Honest(served.port) as honest:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            drop_in(served.port, turns)
            held.append(served.memory_mb)
            time.sleep(0.3)
            turns += 1
        said, p95 = served.said, honest.p95_ms
    third = max(len(held) // 3, 1)  # the first is left out: caches fill, kernels are loaded
    grew = float(np.median(held[-third:]) - np.median(held[third : 2 * third] or held))
    return Outcome(
        injected=f"{seconds / 60.0:.1f} min, {turns} visitors who come, search, load files and go",
        happened=f"{len(honest.seconds):,} slider moves of an honest visitor answered rightly, "
        f"95 % within {p95:.0f} ms; memory {grew:+.1f} MB from the second third to the last",
        sound=honest.failure is None and said == "" and turns > 3 and grew < 15.0,
    )

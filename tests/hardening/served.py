"""A server as a user starts it, and an honest visitor who goes on using it meanwhile."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from viz.websocket_client import WebSocketClient

import kneecore
from kneecore import NAMES, ParameterSpace

REPOSITORY = Path(__file__).resolve().parents[2]
ACL_Y, LABEL = NAMES.index("acl_femur_y"), "ACL femur y"
VALUES_MM = tuple(float(v) for v in np.linspace(-1.2, 0.6, 24).round(2))


@dataclass(kw_only=True)
class Served:
    """A running server in a process of its own."""

    pid: int
    port: int
    url: str
    errors: Path

    @property
    def memory_mb(self) -> float:
        """What the process holds, MB."""
        status = Path(f"/proc/{self.pid}/status").read_text()
        return int(re.search(r"VmRSS:\s+(\d+)", status)[1]) / 1024

    @property
    def said(self) -> str:
        """What it wrote to stderr."""
        return self.errors.read_text(errors="replace")


@contextlib.contextmanager
def serving(*arguments: str, environment: Mapping[str, str] = {}) -> Iterator[Served]:
    """Start ``python -m kneeviz`` and end it, which must go in peace."""
    with tempfile.TemporaryDirectory() as folder:
        errors = Path(folder) / "stderr"
        with errors.open("w") as stream:
            process = subprocess.Popen(
                [sys.executable, "-m", "kneeviz", "--no-browser", "--port", "0", *arguments],
                cwd=REPOSITORY, stdout=subprocess.PIPE, stderr=stream, text=True,
                env=os.environ | {"PYTHONUNBUFFERED": "1"} | environment,
            )  # fmt: skip
        try:
            line = next((line for line in process.stdout if "kneeviz: http" in line), "")
            found = re.search(r"(http://\S+:(\d+)\S*)", line)
            assert found, f"no address was printed: {errors.read_text()}"
            yield Served(pid=process.pid, port=int(found[2]), url=found[1], errors=errors)
            process.send_signal(signal.SIGINT)
            assert process.wait(20) == 0, "it did not end in peace"
            assert "Task was destroyed" not in errors.read_text(errors="replace")
        finally:
            process.kill()
            process.wait()
            process.stdout.close()


def slider(client: WebSocketClient, label: str = LABEL) -> str:
    """Return the id of the slider that has this label."""
    return client.wait(
        lambda c: next((u for u, p in c.props.items() if p.get("label") == label), None)
    )


def chart(client: WebSocketClient) -> str:
    """Return the id of the moment-angle chart: the one whose first scale stands upright."""
    return client.wait(
        lambda c: next(
            (u for u, p in c.props.items() if (p.get("scales") or {}).get("x", {}).get("ori") == 1),
            None,
        )
    )


def angles(data: list[np.ndarray]) -> np.ndarray:
    """Return the 12 angles of the visitor's knee in the chart's data, deg."""
    curve = data[-7]  # before surrogate, two worst cases and three dots
    drawn = np.isfinite(curve)
    if not drawn.any():
        return np.full(len(kneecore.MOMENT), np.nan)
    return np.interp(kneecore.MOMENT, data[0][drawn], curve[drawn])


def expected(value_mm: float) -> np.ndarray:
    """Return the 12 angles of the knee that only this slider has changed, deg."""
    x = np.array(ParameterSpace().baseline)
    x[ACL_Y] = 1e-3 * value_mm
    return np.degrees(kneecore.simulate(x).flexion)


@dataclass
class Honest:
    """Moves a slider again and again and compares each answer with the model's.

    Use it as a context manager: it moves the slider until the end of the block. As nobody else
    moves one, a right answer also says that nothing else has changed the knee.
    """

    port: int
    path: str = ""
    seconds: list[float] = field(default_factory=list)
    """How long each answer took."""
    failure: str | None = None

    def __enter__(self) -> "Honest":
        self._wanted = {value: expected(value) for value in VALUES_MM}
        self._client = WebSocketClient(self.port, path=self.path)
        self._slider, self._chart = slider(self._client), chart(self._client)
        self._client.wait(lambda c: len(c.props[self._chart]["data"]) > 40, 60)
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join(40)
        if self._thread.is_alive():
            self.failure = self.failure or "it waits for ever"
        self._client.close()

    def _run(self) -> None:
        rng = np.random.default_rng(0)
        try:
            while not self._over.is_set():
                for value in rng.permutation(VALUES_MM):
                    self.seconds.append(self._move(float(value)))
                    if self._over.wait(0.03):
                        break
        except Exception as error:
            self.failure = f"{type(error).__name__}: {error}"

    def _move(self, value: float) -> float:
        wanted = self._wanted[value]
        start = time.perf_counter()
        self._client.set(self._slider, value)
        arrived = self._client.wait(
            lambda c: (
                np.abs(angles(c.props[self._chart]["data"]) - wanted).max() < 1e-6 and c.arrived
            ),
            30,
        )
        return max(arrived - start, 0.0)

    @property
    def p95_ms(self) -> float:
        """The answer's time that one in twenty exceeds, ms."""
        return float(np.percentile(1e3 * np.asarray(self.seconds), 95))

"""How a page's news reach many visitors: at one beat for all, packed once. Touches viser's parts.

viser (1.1.1) lets every connection look for news by itself and pack them anew, as often as there
are any. With thirty visitors who all drag, each of their moves is news to the others, and packing
takes the server's whole time. Here one clock says up to where the news go out, so that all
connections send the same, which is packed once; only what a visitor has sent himself is left out
for him. The more visitors there are, the rarer the beats, but a `flush` is still followed at once.
"""

import asyncio
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

import msgspec
import zstandard
from viser.infra import _infra

_BEAT = 1.0 / 60.0
_BEAT_EACH, _FLUSH_EACH = 2e-3, 2e-4
"""s for each visitor: the usual time between beats, and the least between two flushes."""
_LONGEST_BEAT = 0.1
_MOST_AT_ONCE = 128
"""Messages of a frame."""
_ALIGNED = 8

_encode: Callable[[Any], bytes] = msgspec.msgpack.Encoder().encode
_single: Callable[..., Any] = _infra._message_producer
"""What viser does for one connection by itself."""


class _Window:
    """Messages that go out together, packed once for all who get the same."""

    def __init__(self, messages: list[Any]) -> None:
        buffers: list[memoryview] = []
        self._messages = [
            (m.excluded_self_client, msgspec.Raw(_encode(m.as_serializable_dict(buffers))))
            for m in messages
        ]
        self._own = {excluded for excluded, _ in self._messages if excluded is not None}
        self._lengths = tuple(buffer.nbytes for buffer in buffers)
        parts: list[bytes | memoryview] = []
        _infra._append_aligned_buffers(parts, buffers, 0)
        self._tail = b"".join(parts)
        self._common: bytes | None = None

    def frame(self, client_id: int, compressor: zstandard.ZstdCompressor) -> bytes | None:
        """Return what a visitor is sent: all but his own messages; None if nothing is left."""
        if client_id in self._own:
            return self._packed(
                [raw for own, raw in self._messages if own != client_id], compressor
            )
        if self._common is None:
            self._common = self._packed([raw for _, raw in self._messages], compressor)
        return self._common

    def _packed(
        self, messages: list[msgspec.Raw], compressor: zstandard.ZstdCompressor
    ) -> bytes | None:
        if not messages:
            return None
        inner = _encode(
            {
                "messages": messages,
                "timestampSec": time.perf_counter(),
                "binaryBufferLengths": self._lengths,
            }
        )
        packed = compressor.compress(inner)
        sizes = len(inner).to_bytes(8, "little") + len(packed).to_bytes(8, "little")
        return b"".join((sizes, packed, bytes(-len(packed) % _ALIGNED), self._tail))


class Broadcast:
    """The clock of one buffer of messages and what goes out at its present beat."""

    def __init__(self, buffer: Any) -> None:
        self._buffer = buffer
        self._at = -1
        self._listeners = 0
        self._clock: asyncio.Task[None] | None = None
        self._moved = asyncio.Event()
        self._windows: dict[tuple[int, int], tuple[_Window, int]] = {}
        self._compressor = zstandard.ZstdCompressor(level=1)

    @asynccontextmanager
    async def listening(self) -> AsyncIterator[None]:
        """Keep the clock going."""
        self._listeners += 1
        if self._clock is None:
            self._clock = asyncio.create_task(self._run())
        try:
            yield
        finally:
            self._listeners -= 1
            clock = self._clock
            if self._listeners == 0 and clock is not None:
                self._clock = None
                clock.cancel()
                await asyncio.gather(clock, return_exceptions=True)

    async def frame_after(self, cursor: int, client_id: int) -> tuple[bytes | None, int]:
        """Wait for news beyond the message `cursor`; return them packed, and the last one."""
        while self._at <= cursor and not self._buffer.done:
            await self._moved.wait()
        return self.frame(cursor, max(self._at, cursor), client_id)

    def frame(self, cursor: int, end: int, client_id: int) -> tuple[bytes | None, int]:
        """Return the messages after `cursor` up to `end`, packed, and the last of them."""
        known = self._windows.get((cursor, end))
        if known is None:
            messages, last = self._between(cursor, end)
            known = self._windows[cursor, end] = _Window(messages), last
        window, last = known
        return window.frame(client_id, self._compressor), last

    def _between(self, cursor: int, end: int) -> tuple[list[Any], int]:
        kept = self._buffer.message_from_id
        with self._buffer.buffer_lock:
            if end - cursor < len(kept):
                found = [(k, kept[k]) for k in range(cursor + 1, end + 1) if k in kept]
            else:
                found = [(k, message) for k, message in kept.items() if cursor < k <= end]
        if len(found) <= _MOST_AT_ONCE:
            return [message for _, message in found], end
        found = found[:_MOST_AT_ONCE]
        return [message for _, message in found], found[-1][0]

    async def _run(self) -> None:
        buffer, last = self._buffer, 0.0
        # Python 3.11's `wait_for` may take a cancellation for the end of its waiting.
        while not buffer.done and self._clock is asyncio.current_task():
            if buffer.message_counter - 1 <= self._at or buffer.atomic_counter > 0:
                await buffer.message_event.wait()
                buffer.message_event.clear()
                continue
            await self._pause(last)
            if buffer.atomic_counter > 0:
                continue
            last = time.monotonic()
            self._at = buffer.message_counter - 1
            self._windows.clear()
            self._wake()
        self._wake()

    def _wake(self) -> None:
        moved, self._moved = self._moved, asyncio.Event()
        moved.set()

    async def _pause(self, last: float) -> None:
        """Wait for a flush, or until the next beat is due; `last` is when the last one was."""
        n, flushed = self._listeners, self._buffer.flush_event
        try:
            usual = min(max(_BEAT, n * _BEAT_EACH), _LONGEST_BEAT)
            await asyncio.wait_for(flushed.wait(), usual)
        except TimeoutError:
            return
        flushed.clear()
        early = last + n * _FLUSH_EACH - time.monotonic()
        if early > 0.0:
            await asyncio.sleep(early)


async def _produce(
    websocket: Any, buffer: Any, client_id: int, backlog_done_message: Any = None
) -> None:
    """Send one connection what is in a buffer, and then its news."""
    if not buffer.persistent_messages:  # the visitor's own
        await _single(websocket, buffer, client_id, backlog_done_message)
        return
    broadcast: Broadcast = vars(buffer).setdefault("_kneeviz", Broadcast(buffer))
    # viser itself forgets the cursor when the connection ends.
    cursors, cursor = buffer.generator_cursors, -1
    cursors[client_id] = cursor
    async with broadcast.listening():
        backlog = buffer.message_counter - 1
        while cursor < backlog:
            frame, cursor = broadcast.frame(cursor, backlog, client_id)
            cursors[client_id] = cursor
            if frame is not None:
                await websocket.send(frame)
        if backlog_done_message is not None:
            done = _Window([backlog_done_message])
            await websocket.send(done.frame(client_id, broadcast._compressor))
        while not buffer.done:
            frame, cursor = await broadcast.frame_after(cursor, client_id)
            cursors[client_id] = cursor
            if frame is not None:
                await websocket.send(frame)


def install() -> None:
    """Let the connections of all servers of this process send in this way."""
    _infra._message_producer = _produce


__all__ = ["install"]

"""What stands in front of viser: the gate before a request, the caps on a connection.

viser (1.1.1) has no hook for this, but it rests on the package websockets, which has all that is
needed, documented: `serve` takes a function that looks at a request before it is answered, the
largest message, and a class of our own for connections. So while viser starts its server, what it
calls as `serve` is ours, which calls the real one with these. A proxy in front would have cost a
copy and two threads' turns a message, and would have left viser's own port open beside it.
"""

import asyncio
import contextlib
import logging
import threading
from collections.abc import Awaitable, Callable, Iterator
from functools import cached_property
from http import HTTPStatus
from typing import Any

from websockets.asyncio import server as sockets
from websockets.http11 import Request, Response

from kneeviz import viser_internals
from kneeviz.server.caps import (
    FREE_FRAMES,
    MAX_MESSAGE,
    MAX_WAITING,
    SILENT_SECONDS,
    Crowd,
    Message,
    Pace,
    ViewerCamera,
    understood,
)
from kneeviz.server.classroom import Classroom
from kneeviz.server.gate import Gate

_LOG = logging.getLogger(__name__)
_ONE_AT_A_TIME = threading.Lock()
_USUAL = ("opening handshake failed", "connection rejected (")

Answer = Response | None
Process = Callable[[sockets.ServerConnection, Request], Answer | Awaitable[Answer]]


class _Quiet(logging.Filter):
    """Drops what strangers could fill the log with: requests that are refused or never finish."""

    def filter(self, record: logging.LogRecord) -> bool:
        return not record.getMessage().startswith(_USUAL)


def _logger() -> logging.Logger:
    logger = logging.getLogger("kneeviz.server.wire")
    if not any(isinstance(known, _Quiet) for known in logger.filters):
        logger.addFilter(_Quiet())
    return logger


def _connection_class(
    gate: Gate, crowd: Crowd[Any], classroom: Classroom | None
) -> type[sockets.ServerConnection]:
    """Return the class of connections that `crowd` counts."""

    class Connection(sockets.ServerConnection):
        """A connection of which viser reads only what our page could have sent, at our pace."""

        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            self._pace, self._joined, self._told = Pace(), asyncio.Event(), 0

        @cached_property
        def leads(self) -> bool:
            """Whether the token of a class's teacher came with it."""
            request = self.request
            return request is not None and gate.leads(request.path, request.headers)

        def connection_made(self, transport: asyncio.BaseTransport) -> None:
            super().connection_made(transport)
            goes = crowd.enter(self)
            if goes is not None:
                goes.transport.abort()

        def connection_lost(self, exc: Exception | None) -> None:
            crowd.leave(self)
            super().connection_lost(exc)

        async def recv(self, decode: bool | None = None) -> Any:
            del decode  # viser wants bytes, and text could be none that a page sends
            while True:
                raw = await super().recv(decode=False)
                message = understood(raw)
                wait = self._pace.charge(len(raw), malformed=message is None)
                if wait > 0.0:
                    await asyncio.sleep(wait)
                # viser knows a client, and tidies up behind it, from its first camera on.
                if isinstance(message, ViewerCamera):
                    self._joined.set()
                if message is not None and self._joined.is_set():
                    crowd.know(self)
                    if self._counts(message):
                        return raw

        def _counts(self, message: Message) -> bool:
            if classroom is None or isinstance(message, ViewerCamera) or classroom.lets(self):
                return True
            classroom.dropped(self, message)
            return False

        async def send(self, *arguments: Any, **options: Any) -> None:
            # Who has not joined gets the page's state, but no thirty frames a second after it:
            # some hundred who only listen would otherwise keep the visitors waiting.
            self._told += 1
            if self._told > FREE_FRAMES and not self._joined.is_set():
                with contextlib.suppress(TimeoutError):
                    await asyncio.wait_for(self._joined.wait(), SILENT_SECONDS)
            await super().send(*arguments, **options)

    return Connection


def _process(gate: Gate, crowd: Crowd[Any], inner: Process | None) -> Process:
    """Return the function that looks at each request first, and then asks viser's own."""

    def answered(connection: sockets.ServerConnection, request: Request) -> Answer:
        refusal = gate.refusal(request.path, request.headers)
        if refusal is not None:
            return connection.respond(HTTPStatus.FORBIDDEN, f"{refusal}\n")
        answer = None if inner is None else inner(connection, request)
        assert answer is None or isinstance(answer, Response)
        if answer is None and not _is_of_our_version(request):
            return connection.respond(HTTPStatus.BAD_REQUEST, "Another version: load the page.\n")
        if answer is None and gate.has_token(request.path, request.headers):
            crowd.know(connection)
        if answer is not None:
            for name, value in gate.answer_headers(request.path, request.headers).items():
                answer.headers[name] = value
        return answer

    return answered


def _is_of_our_version(request: Request) -> bool:
    """Tell whether a page speaks as ours does; of others viser prints a line each time."""
    return request.headers.get_all("Sec-WebSocket-Protocol") == [viser_internals.subprotocol()]


@contextlib.contextmanager
def standing(gate: Gate, classroom: Classroom | None = None) -> Iterator[None]:
    """Put `gate`, the caps and a class's rule in front of the server that viser starts meanwhile.

    Raises
    ------
    RuntimeError
        If viser started none in the way that is known here: then nothing would guard it.
    """
    real, crowd, guarded = sockets.serve, Crowd[Any](), []

    def serve(handler: Any, *arguments: Any, **options: Any) -> Any:
        if not viser_internals.is_own_server(handler):
            return real(handler, *arguments, **options)
        guarded.append(True)
        ours = {
            "process_request": _process(gate, crowd, options.get("process_request")),
            "create_connection": _connection_class(gate, crowd, classroom),
            "max_size": MAX_MESSAGE,
            "max_queue": MAX_WAITING,
            "logger": _logger(),
        }
        return real(handler, *arguments, **{**options, **ours})

    with _ONE_AT_A_TIME:
        sockets.serve = serve  # type: ignore[assignment,misc]
        try:
            yield
        finally:
            sockets.serve = real  # type: ignore[misc]
    if not guarded:
        raise RuntimeError("viser started its server in a way that cannot be guarded")

"""A process that runs a model for another one: started by `kneecore.runs.hands`, led by a pipe.

It gets (name, ...) tuples on its standard input and answers on what was its standard output; what
the model prints goes to standard error. When the pipe closes, it ends, and with it all that it has
started.
"""

import os
import pickle
import queue
import signal
import struct
import sys
import threading
from contextlib import suppress
from typing import Any, BinaryIO

import numpy as np

from kneecore.runs.processes import end_all
from kneecore.runs.work import Work, loaded

__all__ = ["main", "read_message", "write_message"]

_LENGTH = struct.Struct("<Q")


def write_message(stream: BinaryIO, message: Any) -> None:
    """Write a message of Python's own and NumPy's types to a pipe."""
    content = pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL)
    stream.write(_LENGTH.pack(len(content)) + content)
    stream.flush()


def read_message(stream: BinaryIO) -> Any:
    """Return the next message of a pipe.

    Raises
    ------
    EOFError
        If the other end has closed it.
    """
    head = stream.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        raise EOFError
    (length,) = _LENGTH.unpack(head)
    content = stream.read(length)
    if len(content) < length:
        raise EOFError
    return pickle.loads(content)


def _leave() -> None:
    """End at once, and all that the model has started: whoever asked is gone, or has had enough."""
    end_all()
    if hasattr(os, "killpg") and os.getpgrp() == os.getpid():
        with suppress(OSError):
            os.killpg(0, signal.SIGKILL)
    os._exit(1)


def _listen(source: BinaryIO, orders: "queue.Queue[Any]") -> None:
    """Take in orders beside the model, which may hang: only so the end of the pipe is noticed."""
    try:
        while True:
            orders.put(read_message(source))
    except BaseException:  # whatever it is, there is nobody to work for
        _leave()


def _obey(sink: BinaryIO, orders: "queue.Queue[Any]") -> None:
    works: dict[str, Work] = {}
    while True:
        order, *given = orders.get()
        if order == "load":
            digest, blob = given
            try:
                works[digest] = loaded(digest, blob)
                write_message(sink, ("loaded", ""))
            except BaseException as error:
                said = " ".join(f"{type(error).__name__}: {error}".split())
                write_message(sink, ("refused", said[:500]))
            continue
        digest, x, observe, patience = given
        for part in works[digest].parts(np.asarray(x), observe=observe, patience=patience):
            write_message(sink, ("part", part))


def main() -> None:
    """Obey the standard input until it closes."""
    source = os.fdopen(os.dup(0), "rb")
    sink = os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    sys.stdin = open(os.devnull, encoding="utf-8")  # noqa: SIM115
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    orders: queue.Queue[Any] = queue.Queue()
    threading.Thread(target=_listen, args=(source, orders), daemon=True).start()
    _obey(sink, orders)

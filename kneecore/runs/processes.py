"""Processes that are started, and ended with all that they have started themselves."""

import os
import signal
import subprocess
import threading
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

__all__ = ["end", "end_all", "forget", "started"]

_RUNNING: set["subprocess.Popen[bytes]"] = set()
_LOCK = threading.Lock()


def started(command: Sequence[str], **options: Any) -> "subprocess.Popen[bytes]":
    """Start a process in a group of its own; `end` ends it, and `end_all` all of them.

    Raises
    ------
    OSError
        If there is no such program, or it cannot be started.
    """
    if os.name == "posix":
        options["start_new_session"] = True
    process = subprocess.Popen(command, **options)
    with _LOCK:
        _RUNNING.add(process)
    return process


def end(process: "subprocess.Popen[bytes]") -> None:
    """End a process and the processes that it has started, at once; wait until it is gone."""
    with suppress(OSError):
        if os.name == "posix":
            # A process that was waited for has given its number back; it may be a stranger's.
            if process.returncode is None:
                os.killpg(process.pid, signal.SIGKILL)
        elif process.poll() is None:
            subprocess.run(
                ["taskkill", "/F", "/T", "/PID", str(process.pid)], capture_output=True, check=False
            )
    with suppress(OSError):
        process.kill()
    process.wait()
    forget(process)


def forget(process: "subprocess.Popen[bytes]") -> None:
    """Leave a process that has ended alone from now on."""
    with _LOCK:
        _RUNNING.discard(process)


def end_all() -> None:
    """End all processes that were started here."""
    with _LOCK:
        running = list(_RUNNING)
    for process in running:
        end(process)

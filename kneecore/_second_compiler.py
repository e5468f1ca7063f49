"""A second process that compiles too, at the first start of all.

Numba compiles under one lock, so threads cannot share the work out; a process beside this one that
fills the same cache can. There is one only where nothing is compiled yet and a core is free, and it
ends with this one. It is a helper and no more: whatever becomes of it, the kernels that it has not
left in the cache are compiled here, and no result depends on who compiled. To ask it takes no
numba, so that it may begin while this process still loads that.
"""

import os
import subprocess
import sys
import threading
from contextlib import suppress
from functools import cache
from pathlib import Path

from kneecore._kernel_folder import cache_folder
from kneecore._threads import available_cores

__all__ = ["compile_apart", "wait_for"]

_PROGRAM = """
import gc, importlib, os, queue, sys, threading

gc.disable()  # a tenth of the time, and nothing is left over

def listen():
    for line in sys.stdin:
        asked.put(line)
    os._exit(0)  # who asked has ended, in whatever way: in the middle of a part, too

asked = queue.SimpleQueue()
threading.Thread(target=listen, daemon=True).start()
try:
    while True:
        line = asked.get()
        module, function = line.strip().split(":")
        getattr(importlib.import_module(module), function)()
        print(line, end="", flush=True)
finally:
    os._exit(1)
"""
_PATIENCE_S = 20.0
"""Three times what a part takes on an idle core: should it hang, the kernels are compiled here."""


class _SecondProcess:
    """It is given functions to call, one after the other, and tells of each when it is done."""

    def __init__(self) -> None:
        here = str(Path(__file__).resolve().parents[1])
        paths = [here, *filter(None, [os.environ.get("PYTHONPATH")])]
        self._done: dict[str, threading.Event] = {}
        self._process = subprocess.Popen(
            [sys.executable, "-c", _PROGRAM],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        threading.Thread(target=self._listen, name="second-compiler", daemon=True).start()

    def _listen(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._done[line.strip()].set()
        for done in list(self._done.values()):  # it has ended, with this or without
            done.set()

    def call(self, place: str) -> None:
        """Let it call a function, once."""
        if place in self._done:
            return
        self._done[place] = threading.Event()
        assert self._process.stdin is not None
        try:
            print(place, file=self._process.stdin, flush=True)
        except OSError:  # it has ended already
            self._done[place].set()

    def wait_for(self, place: str) -> None:
        if place in self._done:
            self._done[place].wait(_PATIENCE_S)


@cache
def _second_process() -> _SecondProcess | None:
    """Return it if nothing was compiled when it was first asked for, and it can help."""
    folder, interpreted = cache_folder(), os.environ.get("NUMBA_DISABLE_JIT", "0") != "0"
    if folder is None or interpreted or available_cores() < 2:
        return None
    # A program that embeds Python may name itself as the executable.
    if not Path(sys.executable or "").stem.startswith("python"):
        return None
    if next(folder.glob("*/*.nbi"), None) is not None:
        return None
    with suppress(OSError):  # no room for another process, say
        return _SecondProcess()
    return None


def compile_apart(place: str) -> None:
    """Let the second process call a function that compiles, after those that it was given before.

    Parameters
    ----------
    place : str
        "module:function", without arguments.
    """
    second = _second_process()
    if second is not None:
        second.call(place)


def wait_for(place: str) -> None:
    """Wait until a function that the second process was given has been called, if it was."""
    second = _second_process()
    if second is not None:
        second.wait_for(place)

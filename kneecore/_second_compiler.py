"""A second process that compiles too, at the first start of all.

Numba compiles under one lock, so threads cannot share the work out; a process beside this one that
fills the same cache can. It is started only where nothing is compiled yet and a core is free. It is
a helper and no more: whatever becomes of it, the kernels that it has not left in the cache are
compiled here, and no result depends on who compiled.
"""

import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path

from numba.core import config

from kneecore import _jit
from kneecore._threads import available_cores

__all__ = ["compile_apart"]

_BEHIND = "import os; hasattr(os, 'nice') and os.nice(10)"
"""Where there is not a core for each, the process that somebody waits for goes first."""
_PATIENCE_S = 15.0
"""Twice what a part takes on an idle core: on a busy machine, or should it hang, we do it here."""


@cache
def _worth_it() -> bool:
    """Tell whether nothing was compiled at the start, and a second process can help."""
    folder = _jit.cache_folder()
    if folder is None or config.DISABLE_JIT or available_cores() < 2:
        return False
    # A program that embeds Python may name itself as the executable.
    python = sys.executable is not None and Path(sys.executable).stem.startswith("python")
    return python and next(folder.glob("*/*.nbi"), None) is None


@cache
def _started(place: str) -> "subprocess.Popen[bytes] | None":
    module, function = place.split(":")
    here = str(Path(__file__).resolve().parents[1])
    paths = [here, *filter(None, [os.environ.get("PYTHONPATH")])]
    with suppress(OSError):  # no room for another process, say
        return subprocess.Popen(
            [sys.executable, "-c", f"{_BEHIND}; from {module} import {function} as part; part()"],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
    return None


def compile_apart(place: str) -> Callable[[], None]:
    """Let a second process call a function that compiles, if that is worth it; once in a process.

    Parameters
    ----------
    place : str
        "module:function", without arguments.

    Returns
    -------
    callable
        Waits until the second process has ended, if there is one.
    """
    second = _started(place) if _worth_it() else None

    def wait() -> None:
        if second is not None:
            with suppress(subprocess.TimeoutExpired):
                second.wait(_PATIENCE_S)

    return wait

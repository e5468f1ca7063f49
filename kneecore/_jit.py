"""The one place for numba's flags and for its cache.

Flags
-----
``contract`` alone of the fast-math flags: the compiler may fuse ``a * b + c``, which makes the
dynamics clearly faster, and nothing else changes. NaN and infinity keep their meaning
(``fastmath=True`` would delete the checks for them), sums keep their order, and the lanes of a
vector all run the same instructions, so a model's result does not depend on its neighbours. The
tests hold that bit by bit.

No kernel uses ``parallel=True``. Kernels release the GIL instead and `kneecore._threads` spreads
independent rows over Python threads: compilation stays short, and no threading layer can abort
the process when two Python threads meet in one.

Cache
-----
Numba notices a change in the file that holds a kernel but not in the kernels that it imports, and
then serves a stale result. So the cache folder's name carries a hash of all files that may hold
kernels: change one, and all are compiled anew. ``NUMBA_CACHE_DIR`` is honoured; without it the
user's cache folder is taken, and without that nothing is cached.
"""

import hashlib
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba
import platformdirs
from numba.core import config

__all__ = ["inline", "kernel"]

_F = TypeVar("_F", bound=Callable[..., Any])
_FASTMATH = {"contract"}


def _source_hash() -> str:
    package = Path(__file__).resolve().parent
    digest = hashlib.sha256()
    sources = sorted(
        [*package.glob("knee/**/*.py"), *package.glob("numerics/*.py"), Path(__file__)]
    )
    for source in sources:
        digest.update(source.name.encode() + b"\0" + source.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


@cache
def cache_folder() -> Path | None:
    """Return the folder of the compiled kernels; None where none can be written."""
    base = os.environ.get("NUMBA_CACHE_DIR") or platformdirs.user_cache_dir("kneecore", False)
    folder = Path(base) / f"kneecore-{_source_hash()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


def kernel(function: _F) -> _F:
    """Compile `function` at its first call: cached, without the GIL, division as in NumPy."""
    folder = cache_folder()
    before = config.CACHE_DIR
    # Numba reads the folder once, while it decorates; other people's kernels keep their own.
    config.CACHE_DIR = str(folder or "")
    try:
        compiled: _F = numba.njit(
            cache=folder is not None, nogil=True, error_model="numpy", fastmath=_FASTMATH
        )(function)
    finally:
        config.CACHE_DIR = before
    return compiled


def inline(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a small `function` into each of its callers."""
    compiled: Callable[..., Any] = numba.njit(
        forceinline=True, error_model="numpy", fastmath=_FASTMATH
    )(function)
    return compiled

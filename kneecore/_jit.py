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
It is in a folder of its own (`kneecore._kernel_folder`). One that is broken or cannot be written is
none (`kneecore._kernel_cache`).

Without the compiler
--------------------
With ``NUMBA_DISABLE_JIT=1`` the kernels run as Python, slowly. There 1 / 0 is an error where the
compiled code goes on with infinity, so all their numbers are kept NumPy's, whose 1 / 0 is infinity
too.
"""

import math
from collections.abc import Callable
from functools import wraps
from types import FunctionType
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba.core import config
from numba.core.registry import CPUDispatcher

from kneecore import _kernel_cache
from kneecore._kernel_folder import cache_folder

__all__ = ["inline", "inner", "kernel", "written_in"]

_F = TypeVar("_F", bound=Callable[..., Any])
_FASTMATH = {"contract"}


def kernel(function: _F) -> _F:
    """Compile `function` at its first call: cached, without the GIL, division as in NumPy."""
    if config.DISABLE_JIT:
        return _interpreted(function)
    compiled: _F = numba.njit(
        nogil=True, error_model="numpy", fastmath=_FASTMATH, no_cfunc_wrapper=True
    )(function)
    folder = cache_folder()
    if folder is not None:
        before = config.CACHE_DIR
        # Numba reads the folder once, here; other people's kernels keep their own.
        config.CACHE_DIR = str(folder)
        try:
            _kernel_cache.install(compiled, folder)
        finally:
            config.CACHE_DIR = before
    return compiled


class _CalledByKernels(CPUDispatcher):  # type: ignore[misc]
    """A function without the wrappers by which Python and C call: a fifth of its compilation."""

    def __call__(self, *arguments: Any) -> Any:
        """From Python it runs as Python: compiled there is no way in."""
        return self.py_func(*arguments)


def inner(function: _F, *, inlined: bool = False, written: bool = False) -> _F:
    """Compile `function`, which only kernels call."""
    if config.DISABLE_JIT:
        return _interpreted(function)
    compiled: Any = numba.njit(
        nogil=True,
        error_model="numpy",
        fastmath=_FASTMATH,
        forceinline=inlined,
        inline="always" if written else "never",
        no_cpython_wrapper=True,
        no_cfunc_wrapper=True,
    )(function)
    compiled.__class__ = _CalledByKernels
    return cast("_F", compiled)


def inline(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a small `function` into each of the kernels that call it."""
    return inner(function, inlined=True)


def written_in(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile `function` as a part of its only caller.

    Numba puts its text there, so that it is optimised once; alone it would be optimised, turned
    into machine code, and then optimised again within the caller. It gains for large functions.
    """
    return inner(function, written=True)


class _NumpyMath:
    """`math` with NumPy's numbers: the root of -1 is NaN, and a quotient of results may be inf."""

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name, None) or getattr(math, name)


def _interpreted(function: _F) -> _F:
    """Return `function` as Python that computes as the compiled one would, if slowly."""
    own: FunctionType | None = None

    @wraps(function)
    def call(*arguments: Any) -> Any:
        nonlocal own
        if own is None:  # only now are all names of its module there
            names = {**function.__globals__, "math": _NumpyMath(), "float": np.float64}
            own = FunctionType(function.__code__, names, function.__name__, function.__defaults__)
        with np.errstate(all="ignore"):
            return own(*arguments)

    return cast("_F", call)

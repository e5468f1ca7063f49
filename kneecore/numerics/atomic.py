"""Counters that several threads may raise at once: how kernels share one piece of work out.

Numba has no atomics for the processor, so the two instructions are handed to LLVM. In Python, and
with the compiler switched off, a lock does the same.
"""

from threading import Lock
from typing import Any

import numpy as np
from numba.core import types
from numba.core.typing import signature
from numba.extending import intrinsic, overload
from numpy.typing import NDArray

IntArray = NDArray[np.int64]

_lock = Lock()


def fetch_add(counters: IntArray, place: int) -> int:
    """Raise ``counters[place]`` by 1 and return what it was; no other thread comes in between.

    What a thread wrote before is seen by every thread that finds the counter raised.
    """
    with _lock:
        before = int(counters[place])
        counters[place] += 1
    return before


def fetch(counters: IntArray, place: int) -> int:
    """Return ``counters[place]`` and see all that was written before it was raised."""
    with _lock:
        return int(counters[place])


def _address(context: Any, builder: Any, array_type: Any, arguments: Any) -> Any:
    array = context.make_array(array_type)(context, builder, arguments[0])
    return builder.gep(array.data, [arguments[1]])


@intrinsic
def _fetch_add(typing_context, counters, place):  # type: ignore[no-untyped-def]
    def generate(context, builder, sig, arguments):  # type: ignore[no-untyped-def]
        address = _address(context, builder, sig.args[0], arguments)
        one = context.get_constant(types.int64, 1)
        return builder.atomic_rmw("add", address, one, "seq_cst")

    return signature(types.int64, counters, types.intp), generate


@intrinsic
def _fetch(typing_context, counters, place):  # type: ignore[no-untyped-def]
    def generate(context, builder, sig, arguments):  # type: ignore[no-untyped-def]
        address = _address(context, builder, sig.args[0], arguments)
        return builder.load_atomic(address, "seq_cst", 8)

    return signature(types.int64, counters, types.intp), generate


@overload(fetch_add)
def _compiled_fetch_add(counters, place):  # type: ignore[no-untyped-def]
    return lambda counters, place: _fetch_add(counters, place)


@overload(fetch)
def _compiled_fetch(counters, place):  # type: ignore[no-untyped-def]
    return lambda counters, place: _fetch(counters, place)

"""Independent chunks of work on a few threads; the answer never depends on how many."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from functools import lru_cache
from typing import TypeVar

from kneecore._arguments import whole_number

MOST_THREADS = 1024
"""No fewer than the cores of a large machine, and few enough for a process to start."""

_T = TypeVar("_T")


def available_cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def thread_count(threads: int | None) -> int:
    """Return `threads` checked, or the number of available cores for None.

    Raises
    ------
    ParameterError
        If `threads` is no whole number from 1 to 1,024.
    """
    if threads is None:
        return available_cores()
    return whole_number("threads", threads, 1, MOST_THREADS)


@lru_cache(maxsize=8)
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="kneecore")


if hasattr(os, "register_at_fork"):
    # A forked child has the pool, but none of its threads: it would wait for ever.
    os.register_at_fork(after_in_child=_pool.cache_clear)


def run_all(work: Callable[[_T], None], chunks: Iterable[_T], threads: int | None = None) -> None:
    """Call `work` once for each of `chunks`, on at most `threads` threads, and wait for all.

    `work` must release the GIL to gain anything and must write only to its own chunk's rows.
    """
    chunks = list(chunks)
    count = min(thread_count(threads), len(chunks))
    if count <= 1:
        for chunk in chunks:
            work(chunk)
        return
    futures = [_pool(count).submit(work, chunk) for chunk in chunks]
    for future in futures:
        future.result()


def run_together(work: Callable[[bool], None], threads: int) -> None:
    """Call ``work(True)`` here and ``work(False)`` on ``threads - 1`` others, as far as they come.

    For work that shares itself out: the call here must be able to do all of it alone, and a call
    that comes late must find nothing left. So a busy pool or a thread that fails to start costs
    time, but nobody waits for it.
    """
    helpers: list[Future[None]] = []
    with suppress(RuntimeError):  # no thread to be had
        helpers.extend(_pool(threads).submit(work, False) for _ in range(threads - 1))
    try:
        work(True)
    finally:
        for helper in helpers:
            if not helper.cancel():
                helper.result()

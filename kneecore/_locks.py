"""Locks on open files and folders: they go with the process, and a killed one leaves none."""

from types import ModuleType

try:
    import fcntl

    _fcntl: ModuleType | None = fcntl
except ImportError:  # there, two writers are not kept apart
    _fcntl = None

__all__ = ["lock"]


def lock(handle: int) -> bool:
    """Lock what is open as `handle` until it is closed; False if another holds it.

    Where the system or a network's disk has no locks, nobody is kept out.
    """
    if _fcntl is None:
        return True
    try:
        _fcntl.flock(handle, _fcntl.LOCK_EX | _fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True

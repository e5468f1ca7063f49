"""Where the compiled kernels are kept; known before numba is loaded.

Numba notices a change in the file that holds a kernel but not in the kernels that it imports, and
then serves a stale result. So the folder's name carries a hash of all files that may hold kernels:
change one, and all are compiled anew. ``NUMBA_CACHE_DIR`` is honoured; without it the user's cache
folder is taken, and without that nothing is cached.
"""

import errno
import hashlib
import logging
import os
from functools import cache
from pathlib import Path

import platformdirs

__all__ = ["cache_folder", "tell"]

_log = logging.getLogger("kneecore")
_told: set[str] = set()


def tell(folder: str, reason: object) -> None:
    """Log, once for each folder, that the cache there is not used."""
    if folder not in _told:
        _told.add(folder)
        reason = getattr(reason, "strerror", None) or reason
        said = " ".join(str(reason).split()) or type(reason).__name__
        _log.warning("the kernels' cache in %s cannot be used (%s); compiling anew", folder, said)


def _source_hash() -> str:
    package = Path(__file__).resolve().parent
    digest = hashlib.sha256()
    sources = sorted(
        [*package.glob("knee/**/*.py"), *package.glob("numerics/*.py")]
        + [package / "_jit.py", package / "_kernel_cache.py"]
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
        if not os.access(folder, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    except OSError as error:
        tell(str(folder), error)
        return None
    return folder

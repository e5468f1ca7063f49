"""The cache of compiled kernels as a helper that never stops the main job, nor changes a number.

Numba raises whatever goes wrong with its cache: a file that was cut off, a full disk, a folder that
became read-only end every later start. Here all of that is no cache: what is broken is deleted, the
kernel is compiled as if nothing had been there, and one line is logged.

A file may also be damaged without being unreadable, and then hold other machine code. So an entry
carries a digest of its code and of all that it depends on (kernel, sources, numba); an entry that
does not match is broken, and so is one that belongs to another signature.

What is built on are the methods that numba's `Cache` and `CacheImpl` are made to be subclassed by
(`load_overload`, `save_overload`; `reduce`, `rebuild`), as numba-cuda does. Only where the cache is
hung on a kernel is there no public way (`install`); the tests hold that it is in use.
"""

import hashlib
import pickle
from contextlib import suppress
from glob import escape
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache, UserProvidedCacheLocator
from numba.core.serialize import dumps

from kneecore._kernel_folder import tell

__all__ = ["install"]


class _CheckedEntries(CompileResultCacheImpl):  # type: ignore[misc]
    """Entries with a digest, in the given folder or nowhere."""

    # Elsewhere numba would fall back to folders that do not change with the sources.
    _locator_classes = [UserProvidedCacheLocator]  # noqa: RUF012

    def _digest(self, code: bytes) -> str:
        digest = hashlib.sha256()
        stamp = self.locator.get_source_stamp()
        place = Path(self.locator.get_cache_path()).name
        for part in (numba.__version__, place, self.filename_base, stamp):
            digest.update(repr(part).encode() + b"\0")
        digest.update(code)
        return digest.hexdigest()

    def reduce(self, compiled: Any) -> tuple[str, bytes]:
        code = dumps(super().reduce(compiled))
        return self._digest(code), code

    def rebuild(self, target_context: Any, entry: tuple[str, bytes]) -> Any:
        digest, code = entry
        if digest != self._digest(code):
            raise ValueError("a file in it is damaged")
        return super().rebuild(target_context, pickle.loads(code))


class _ForgivingCache(FunctionCache):  # type: ignore[misc]
    """The cache of one kernel, in which everything that fails is a miss."""

    _impl_class = _CheckedEntries

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            found = super().load_overload(sig, target_context)
            if found is not None and tuple(found.signature.args) != tuple(sig):
                raise ValueError("a file in it is another's")
        except Exception as error:  # a damaged pickle may raise anything
            self._give_up(error)
            return None
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except Exception as error:
            self._give_up(error)
            self.disable()

    def _give_up(self, error: Exception) -> None:
        tell(str(Path(self.cache_path).parent), error)
        base = escape(self._impl.filename_base)
        for pattern in (f"{base}.nbi", f"{base}.*.nbc"):
            for file in Path(self.cache_path).glob(pattern):
                with suppress(OSError):
                    file.unlink()


def install(kernel: Any, folder: Path) -> None:
    """Give a compiled function a cache in `folder`; numba's own setting must point there."""
    try:
        kernel._cache = _ForgivingCache(kernel.py_func)
    except (OSError, RuntimeError) as error:  # no such folder, or no source file to go by
        tell(str(folder), error)

"""The version of kneecore, and of what a result's bytes depend on."""

import platform
from functools import cache
from importlib.metadata import version

__version__ = "0.2.0"


@cache
def _installed() -> dict[str, str]:
    # Read once: it takes milliseconds, a good part of a quick search.
    return {name: version(name) for name in ("numpy", "scipy", "numba")}


def versions() -> dict[str, str]:
    """Return the versions that a result's bytes depend on."""
    return {"kneecore": __version__, "python": platform.python_version()} | _installed()

"""What tells one model's runs from another's."""

import inspect
import re
from collections.abc import Callable, Sequence
from functools import partial
from hashlib import sha256
from typing import Any

__all__ = ["digest_of"]

_ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")


def _code(code: Any) -> list[str]:
    parts = [code.co_name, code.co_code.hex(), repr(code.co_names)]
    for constant in code.co_consts:
        parts += _code(constant) if hasattr(constant, "co_code") else [repr(constant)]
    return parts


def _source(function: Any) -> list[str]:
    """Return a function's source; where there is no file with it, what it was compiled to."""
    try:
        return [inspect.getsource(function)]
    except (OSError, TypeError):
        code = getattr(function, "__code__", None)
        return _code(code) if code is not None else []


def _parts(function: Any) -> list[str]:
    own = getattr(function, "identity", None)
    if callable(own):
        told: Sequence[str] = own()
        return list(told)
    if isinstance(function, partial):
        return [
            *_parts(function.func),
            repr(function.args),
            repr(sorted(function.keywords.items())),
        ]
    name = f"{getattr(function, '__module__', '')}.{getattr(function, '__qualname__', '')}"
    if not hasattr(function, "__code__") and not hasattr(function, "__func__"):
        kind = type(function)
        return [kind.__qualname__, *_source(kind), repr(getattr(function, "__dict__", ""))]
    # A script is called __main__ when it is run, and by its name when it is imported.
    return [name.rpartition(".")[2], *_source(function)]


def digest_of(run: Callable[..., Any] | None, *names: Any) -> str:
    """Return what a model's runs are called: by its function's source, and what else is named.

    What the function calls, and what it closes over, is not looked at: nobody can follow that.
    """
    told = [*_parts(run), *(repr(name) for name in names)]
    text = "\0".join(_ADDRESS.sub("", part) for part in told)
    return sha256(text.encode("utf-8", errors="replace")).hexdigest()[:16]

"""A user's function, found by its name: ``package.module:function``."""

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import lazy_loader

from kneecore._arguments import shown, text
from kneecore.errors import ParameterError

__all__ = ["function_named"]

cloudpickle: Any = lazy_loader.load("cloudpickle")


def function_named(key: str, value: Any, folder: Path) -> Any:
    """Return the function that `value` names; its module is looked for in `folder` first.

    The module is imported, which runs it.

    Raises
    ------
    ParameterError
        If there is no such function, or its module cannot be imported.
    """
    place, colon, name = text(key, value, 300).partition(":")
    if not colon or not all(part.isidentifier() for part in [*place.split("."), *name.split(".")]):
        raise ParameterError(f"`{key}` is {shown(value)}; 'package.module:function' is allowed")
    if str(folder) not in sys.path:
        # It stays: the function may import late, and workers get the same path.
        sys.path.insert(0, str(folder))
    try:
        module = import_module(place)
    except BaseException as error:  # whatever a stranger's module does when it is imported
        if isinstance(error, KeyboardInterrupt):
            raise
        said = " ".join(f"{type(error).__name__}: {error}".split())[:300]
        raise ParameterError(
            f"`{key}` is {shown(value)}, which cannot be imported ({said})"
        ) from None
    found: Any = module
    for part in name.split("."):
        found = getattr(found, part, None)
    if not callable(found):
        raise ParameterError(f"`{key}` is {shown(value)}; the module {place} has no such function")
    own = getattr(module, "__file__", None)
    if own is not None and Path(own).resolve().parent == folder.resolve():
        # Workers on other machines do not have the file.
        cloudpickle.register_pickle_by_value(module)
    return found

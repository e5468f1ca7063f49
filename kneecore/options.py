"""Options that are born once: a field of a settings class, with its key, help text and place.

A settings class is a frozen, keyword-only dataclass whose fields have a docstring under them. From
these the command lines make their flags, files their keys, and the page its widgets.
"""

import ast
import inspect
import textwrap
from collections.abc import Callable
from dataclasses import MISSING, field, fields
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

from kneecore._arguments import shown
from kneecore.errors import ParameterError

__all__ = ["Option", "check_choices", "option", "options_of"]


def option(
    default: Any = MISSING,
    *,
    key: str | None = None,
    place: tuple[str, ...] | None = None,
    metavar: str | None = None,
    default_factory: Callable[[], Any] | None = None,
) -> Any:
    """Return a dataclass field for an option.

    Parameters
    ----------
    default
        Its default value, or `default_factory`, which makes it.
    key : str, optional
        What command lines (with hyphens) and files call it; the field's name if not given.
    place : tuple of str, optional
        Where it stands in a result's JSON, from the top; under its key if not given.
    metavar : str, optional
        What stands for its value in a command line's help.
    """
    metadata = {"key": key, "place": place, "metavar": metavar}
    if default_factory is not None:
        return field(default_factory=default_factory, metadata=metadata)
    return field(default=default, metadata=metadata)


class Option(NamedTuple):
    """One option of a settings class."""

    name: str
    """The field's name: the library's."""
    key: str
    """The command line's and the files' name."""
    place: tuple[str, ...]
    """Where it stands in a result's JSON."""
    type: Any
    metavar: str | None
    default: Any
    help: str
    """What it does, from the docstring under the field."""

    @property
    def flag(self) -> str:
        """As on a command line, where a flag turns off what is on."""
        return ("--no-" if self.default is True else "--") + self.key.replace("_", "-")

    @property
    def open_flag(self) -> bool:
        """Whether it is yes, no, or left open."""
        return self.default is None and bool in get_args(self.type)

    @property
    def choices(self) -> tuple[Any, ...]:
        """The values that are allowed, where they are a few words."""
        kinds = [self.type, *get_args(self.type)]
        return next((get_args(kind) for kind in kinds if get_origin(kind) is Literal), ())


def _source_of(settings: type[Any]) -> ast.ClassDef:
    """Return a class's source, parsed."""
    if "<locals>" in settings.__qualname__:
        parsed = ast.parse(textwrap.dedent(inspect.getsource(settings))).body
    else:  # three times as fast, which the command lines' help notices
        parsed = ast.parse(Path(inspect.getfile(settings)).read_text(encoding="utf-8")).body
    classes = (node for node in parsed if isinstance(node, ast.ClassDef))
    return next(node for node in classes if node.name == settings.__name__)


def _docstrings(settings: type[Any]) -> dict[str, str]:
    """Return the docstring under each field of a class."""
    tree = _source_of(settings)
    found = {}
    for above, below in zip(tree.body, tree.body[1:], strict=False):
        if not (isinstance(above, ast.AnnAssign) and isinstance(below, ast.Expr)):
            continue
        if isinstance(above.target, ast.Name) and isinstance(below.value, ast.Constant):
            found[above.target.id] = " ".join(str(below.value.value).split())
    return found


_KNOWN: dict[type[Any], tuple[Option, ...]] = {}


def options_of(settings: type[Any]) -> tuple[Option, ...]:
    """Return the options of a settings class, in its order."""
    if settings not in _KNOWN:
        _KNOWN[settings] = _options_of(settings)
    return _KNOWN[settings]


def _options_of(settings: type[Any]) -> tuple[Option, ...]:
    said: dict[str, str] = {}
    for base in reversed(settings.__mro__[:-1]):
        said |= _docstrings(base)
    hints = get_type_hints(settings)
    made = []
    for one in fields(settings):
        key = one.metadata.get("key") or one.name
        default = one.default
        if default is MISSING and one.default_factory is not MISSING:
            default = one.default_factory()
        made.append(
            Option(
                name=one.name,
                key=key,
                place=one.metadata.get("place") or (key,),
                type=hints[one.name],
                metavar=one.metadata.get("metavar"),
                default=default,
                help=said[one.name],
            )
        )
    return tuple(made)


def check_choices(settings: Any) -> None:
    """Raise a `ParameterError` if an option with few choices has none of them."""
    for one in options_of(type(settings)):
        value = getattr(settings, one.name)
        unset = value is None and one.default is None
        if one.choices and not unset and not (isinstance(value, str) and value in one.choices):
            allowed = " or ".join(repr(choice) for choice in one.choices)
            raise ParameterError(f"`{one.name}` is {shown(value)}; {allowed} is allowed")

"""The flags of a command line, made from the options of a settings class."""

import dataclasses
from collections.abc import Mapping
from typing import Annotated, Any, TypeVar, cast

import tyro

from kneecore.errors import ParameterError
from kneecore.options import Option, options_of

__all__ = ["flag_names", "settings_from", "with_flags"]

_Base = TypeVar("_Base")
_Settings = TypeVar("_Settings")


def _fields(one: Option, narrower: Mapping[str, Any]) -> list[tuple[str, Any, Any]]:
    if one.open_flag:
        no = f"The opposite of `--{one.key}`."
        return [_field(one.key, bool, False, one.help), _field(_no(one), bool, False, no)]
    kind = narrower.get(one.name, one.type)
    return [_field(one.key, kind, one.default, one.help, one.metavar)]


def _field(
    key: str, kind: Any, default: Any, told: str, metavar: str | None = None
) -> tuple[str, Any, Any]:
    annotated = Annotated[kind, tyro.conf.arg(help=told, metavar=metavar)]
    return key, annotated, dataclasses.field(default=default)


def _no(one: Option) -> str:
    return f"no_{one.key}"


def with_flags(
    base: type[_Base], settings: type[Any], narrower: Mapping[str, Any] = {}
) -> type[_Base]:
    """Return `base`, a dataclass of options, with one more for each option of `settings`.

    A flag is called by the option's key; one that may be left open has a second flag that says no.
    Types in `narrower`, by the option's name, take the place of its own where a command line knows
    a narrower one.
    """
    fields = [made for one in options_of(settings) for made in _fields(one, narrower)]
    made = dataclasses.make_dataclass(
        base.__name__, fields, bases=(base,), frozen=True, kw_only=True
    )
    made.__doc__ = base.__doc__
    return cast(type[_Base], made)


def settings_from(settings: type[_Settings], options: Any) -> _Settings:
    """Return the settings that parsed options say.

    Raises
    ------
    ParameterError
        If a value is not allowed.
    """
    return settings(**{o.name: _said(o, options) for o in options_of(settings)})


def _said(one: Option, options: Any) -> Any:
    """Return an option's value; None for a flag that was left open."""
    said = getattr(options, one.key)
    if not one.open_flag:
        return said
    no = getattr(options, _no(one))
    if said and no:
        raise ParameterError(f"`{one.name}` is given, and its opposite too; one is allowed")
    return said or (False if no else None)


def flag_names(*settings: type[Any]) -> dict[str, str]:
    """Return the flag of each option by its name in the library, for messages."""
    named = {}
    for one in (o for kind in settings for o in options_of(kind)):
        named[one.name] = one.flag
        if dataclasses.is_dataclass(one.default):
            named |= {
                f.name: f"{one.flag}.{f.name.replace('_', '-')}"
                for f in dataclasses.fields(one.default)
            }
    return named

"""The flags of a command line, made from the options of a settings class."""

import dataclasses
from collections.abc import Mapping
from typing import Annotated, Any, TypeVar, cast

import tyro

from kneecore.options import Option, options_of

__all__ = ["flag_names", "settings_from", "with_flags"]

_Base = TypeVar("_Base")
_Settings = TypeVar("_Settings")


def _field(one: Option, narrower: Mapping[str, Any]) -> tuple[str, Any, Any]:
    kind = narrower.get(one.name, one.type)
    return (
        one.key,
        Annotated[kind, tyro.conf.arg(help=one.help, metavar=one.metavar)],
        dataclasses.field(default=one.default),
    )


def with_flags(
    base: type[_Base], settings: type[Any], narrower: Mapping[str, Any] = {}
) -> type[_Base]:
    """Return `base`, a dataclass of options, with one more for each option of `settings`.

    A flag is called by the option's key. Types in `narrower`, by the option's name, take the place
    of its own where a command line knows a narrower one.
    """
    fields = [_field(one, narrower) for one in options_of(settings)]
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
    return settings(**{o.name: getattr(options, o.key) for o in options_of(settings)})


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

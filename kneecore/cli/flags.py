"""The flags of a command line, made from the options of a settings class."""

import dataclasses
from typing import Annotated, Any, TypeVar

import tyro

from kneecore.options import options_of

__all__ = ["flag_names", "flags_of", "settings_from"]

_Settings = TypeVar("_Settings")


def flags_of(settings: type[Any], **types: Any) -> Any:
    """Return a type for tyro with one flag an option, named by its key, without a prefix.

    `types` take the place of options' own types, where a command line knows a narrower one.
    """
    made = [
        (
            one.key,
            Annotated[types.get(one.name, one.type), tyro.conf.arg(help=one.help)],
            dataclasses.field(default=one.default),
        )
        for one in options_of(settings)
    ]
    flags = dataclasses.make_dataclass(settings.__name__, made, kw_only=True, frozen=True)
    return tyro.conf.OmitArgPrefixes[flags]


def settings_from(settings: type[_Settings], flags: Any) -> _Settings:
    """Return the settings that parsed flags say.

    Raises
    ------
    ParameterError
        If a value is not allowed.
    """
    return settings(**{o.name: getattr(flags, o.key) for o in options_of(settings)})


def flag_names(*settings: type[Any]) -> dict[str, str]:
    """Return the flag of each option by its name in the library, for messages."""
    return {o.name: o.flag for kind in settings for o in options_of(kind)}

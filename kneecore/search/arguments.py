"""What every search is asked with, checked."""

from typing import Any

from kneecore._arguments import callback_or_none, shown
from kneecore.errors import ParameterError
from kneecore.model import Model
from kneecore.search.settings import SearchSettings

__all__ = ["check_model", "checked"]


def check_model(model: Any) -> Model:
    """Return `model`, or raise a `ParameterError` that tells what is allowed."""
    if not isinstance(model, Model):
        raise ParameterError(
            f"`model` is {shown(model)}; a kneecore.Model is allowed, such as kneecore.Knee(space)"
        )
    return model


def checked(model: Any, settings: Any, callback: Any = None) -> SearchSettings:
    """Return the settings of a search, the default ones for None, after a look at all arguments.

    Raises
    ------
    ParameterError
        If the model is no `Model`, the settings are of another kind, or the callback is none.
    """
    check_model(model)
    callback_or_none(callback)
    if settings is None:
        return SearchSettings()
    if not isinstance(settings, SearchSettings):
        raise ParameterError(
            f"`settings` is {shown(settings)}; kneecore.SearchSettings are allowed"
        )
    return settings

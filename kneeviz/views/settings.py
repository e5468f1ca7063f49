"""The widgets whose values a visitor may want back."""

from collections.abc import Mapping
from typing import Any

from kneeviz import viser_internals
from kneeviz.jobs.messages import Post
from kneeviz.state.snapshot import Settings
from kneeviz.views.tabs.events import on_value


class SettingHandles:
    """A page's settings; each posts ("setting", its name).

    Parameters
    ----------
    handles : mapping
        The widgets by their settings' names.
    post : callable
    """

    def __init__(self, handles: Mapping[str, Any], post: Post) -> None:
        self._handles = dict(handles)
        for name, handle in self._handles.items():
            on_value(handle, post, ("setting", name))

    @property
    def values(self) -> Settings:
        """The values of all of them."""
        return tuple((name, handle.value) for name, handle in self._handles.items())

    def fault(self, settings: Settings) -> str | None:
        """Return what is wrong with values that somebody else has told, or None."""
        for name, value in settings:
            handle = self._handles.get(name)
            if handle is None:
                return f"{name[:60]!r} is unknown"
            fault = viser_internals.value_fault(handle, value)
            if fault is not None:
                return f"{name}: {fault}"
        return None

    def put(self, settings: Settings) -> None:
        """Set values that `values` has told."""
        for name, value in settings:
            if self._handles[name].value != value:
                self._handles[name].value = value

"""Widgets of a settings class: one for each of its options, made from what the option says.

What a person sees of an option - its label, ranges, words for its choices - may be said in a
`Look`; without one its key is the label and its help text the hint, so that a new option is on the
page at once.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from kneecore.options import Option, options_of

__all__ = ["Look", "OptionWidgets"]


@dataclass(frozen=True, kw_only=True)
class Look:
    """How an option looks on the page."""

    label: str
    low: float | None = None
    high: float | None = None
    step: float = 1
    words: Mapping[Any, str] = field(default_factory=dict)
    """The choices in words, by their value; the values themselves where there are none."""


def _plain_look(one: Option) -> Look:
    return Look(label=one.key.replace("_", " ").capitalize())


class OptionWidgets:
    """The widgets of a settings class's options.

    Parameters
    ----------
    gui
        viser's.
    settings : type
        The settings class.
    without : collection of str
        Options that have no widget here.
    looks : mapping of str to Look
        How options look, by name.
    """

    def __init__(
        self, gui: Any, settings: type[Any], *, without: Any, looks: Mapping[str, Look]
    ) -> None:
        self._values: dict[str, Callable[[], Any]] = {}
        self.handles: dict[str, Any] = {}
        for one in options_of(settings):
            if one.name not in without:
                self._add(gui, one, looks.get(one.name) or _plain_look(one))

    def _add(self, gui: Any, one: Option, look: Look) -> None:
        words = look.words or {choice: str(choice) for choice in one.choices}
        if words:
            handle = gui.add_dropdown(look.label, tuple(words.values()), hint=one.help)
            by_word = {word: value for value, word in words.items()}
            self._values[one.name] = lambda: by_word[handle.value]
        elif isinstance(one.default, bool) or one.open_flag:
            handle = gui.add_checkbox(look.label, bool(one.default), hint=one.help)
            self._values[one.name] = lambda: bool(handle.value)
        else:
            handle = gui.add_number(
                look.label, one.default, min=look.low, max=look.high, step=look.step, hint=one.help
            )
            whole = isinstance(one.default, int)
            self._values[one.name] = lambda: round(handle.value) if whole else float(handle.value)
        self.handles[one.name] = handle

    def value(self, name: str) -> Any:
        """Return what the visitor has set an option to."""
        return self._values[name]()

    def values(self) -> dict[str, Any]:
        """Return all options' values by name."""
        return {name: value() for name, value in self._values.items()}

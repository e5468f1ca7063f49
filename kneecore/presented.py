"""The one door from a result to its words, its files and its figures.

A result is data. How it is printed, saved and drawn is the business of `kneecore.report`,
`kneecore.files` and `kneecore.figures`, which know the results and are not known by them: here a
name tells where each type's are, and they are loaded when they are first asked for.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any, Self

__all__ = [
    "Format",
    "Presented",
    "Words",
    "format_of",
    "format_with_schema",
    "load",
    "rendered",
    "words_of",
]


@dataclass(frozen=True, kw_only=True)
class Words:
    """How a type of result is told to people."""

    summary: Callable[[Any], str]
    """In one sentence."""
    text: Callable[[Any], str]
    """As tables for a terminal."""
    html: Callable[[Any], str]
    """As HTML for a notebook."""


@dataclass(frozen=True, kw_only=True)
class Format:
    """How a type of result is written and read."""

    schema: str
    """What its JSON calls itself."""
    file: str
    """The JSON file in a folder; it is written last."""
    to_dict: Callable[[Any], dict[str, Any]]
    """JSON-ready values."""
    from_dict: Callable[[dict[str, Any]], Any]
    """The way back; raises `FileFormatError`."""
    others: Callable[[Any, bool], Iterator[tuple[str, bytes]]]
    """The files beside it, (name, content) each; no figures if the second argument is false."""
    stale: tuple[str, ...] = field(default=())
    """Names of files of an earlier result that must make way."""


# Where the words, the format and the figures of each type of result are.
_PLACES: dict[str, tuple[str, str, str]] = {
    "SearchResult": ("report.search", "files.search", "figures.search"),
    "MonteCarloResult": ("report.monte_carlo", "files.monte_carlo", "figures.monte_carlo"),
    "Comparison": ("report.comparison", "files.comparison", "figures.comparison"),
    "InfluenceResult": ("report.influence", "files.influence", "figures.influence"),
    "Landscape": ("report.landscape", "files.landscape", "figures.landscape"),
    "BoundSweep": ("report.bound_sweep", "files.bound_sweep", "figures.bound_sweep"),
    "NeededAccuracy": (
        "report.needed_accuracy",
        "files.needed_accuracy",
        "figures.needed_accuracy",
    ),
    "AccuracyAllocation": (
        "report.accuracy_allocation",
        "files.accuracy_allocation",
        "figures.accuracy_allocation",
    ),
    "TrainingSweep": ("report.training_sweep", "files.training_sweep", "figures.training_sweep"),
    "SurrogateQuality": (
        "report.surrogate_quality",
        "files.surrogate_quality",
        "figures.surrogate_quality",
    ),
    "PaperReport": ("report.paper", "files.paper", "figures.paper"),
    "Response": ("report.response", "files.response", ""),
}

_FILES_OF_SEVERAL = ("files.study", "files.bound_study")
"""Formats of files that command lines write of several results together."""


def _found(result: type[Any], place: int, name: str) -> Any:
    for kind in result.__mro__:
        if kind.__name__ in _PLACES:
            module = _PLACES[kind.__name__][place]
            # A response alone has no figure.
            return getattr(import_module(f"kneecore.{module}"), name) if module else lambda _: {}
    raise TypeError(f"{result.__name__} has no {name.lower()}")


def words_of(result: type[Any]) -> Words:
    """Return how a type of result is told."""
    found: Words = _found(result, 0, "WORDS")
    return found


def format_of(result: type[Any]) -> Format:
    """Return how a type of result is written."""
    found: Format = _found(result, 1, "FORMAT")
    return found


def format_with_schema(schema: Any) -> Format | None:
    """Return the format that calls itself `schema`, or None."""
    for place in (*(files for _, files, _ in _PLACES.values()), *_FILES_OF_SEVERAL):
        found: Format = import_module(f"kneecore.{place}").FORMAT
        if found.schema == schema:
            return found
    return None


class Presented:
    """What every result can do, by way of the rooms above it."""

    def summary(self) -> str:
        """Return the result in one sentence."""
        return words_of(type(self)).summary(self)

    def __str__(self) -> str:
        return words_of(type(self)).text(self)

    def _repr_html_(self) -> str:
        return words_of(type(self)).html(self)

    def figures(self) -> dict[str, Any]:
        """Return the result's figures (matplotlib) by name."""
        drawn: dict[str, Any] = _found(type(self), 2, "draw")(self)
        return drawn

    def to_dict(self) -> dict[str, Any]:
        """Return the result as JSON-ready values, units in the keys."""
        return format_of(type(self)).to_dict(self)

    def files(self, *, figures: bool = True) -> Iterator[tuple[str, bytes]]:
        """Yield (file name, content) of what `save` writes, the JSON last."""
        made: Iterator[tuple[str, bytes]] = _door("files.folder", "contents")(
            self, format_of(type(self)), figures=figures
        )
        return made

    def to_json(self) -> str:
        """Return the result as JSON text, ending in a newline."""
        text: str = _door("files.folder", "to_json")(self.to_dict())
        return text

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Return the result that `to_json` wrote.

        Raises
        ------
        FileFormatError
            If the text is no such result.
        """
        read: Self = _door("files.load", "from_json")(text, format_of(cls))
        return read

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Return the result in a file, or in the folder that `save` wrote.

        Raises
        ------
        FileFormatError
            If it cannot be read or is no such result; the message names the file.
        """
        read: Self = _door("files.load", "load_with")(path, format_of(cls))
        return read

    def save(
        self, folder: str | Path, *, force: bool = False, figures: bool = True
    ) -> tuple[Path, ...]:
        """Write the result's files to `folder`: JSON, and what goes with it.

        Each file is written whole or not at all, the JSON last.

        Returns
        -------
        tuple of Path
            The files, in the order written.

        Raises
        ------
        OutputError
            If the folder holds such a result already and `force` is not given, or cannot be
            written.
        """
        written: tuple[Path, ...] = _door("files.folder", "save")(
            self, format_of(type(self)), folder, force=force, figures=figures
        )
        return written


def _door(place: str, name: str) -> Any:
    return getattr(import_module(f"kneecore.{place}"), name)


def rendered(result: Presented, *beside: Any) -> Iterator[tuple[str, bytes]]:
    """Yield (file name, content) of a result's figures; Matplotlib is loaded only now.

    `beside` is what some results' figures may show too, or None.
    """
    drawn = _found(type(result), 2, "draw")(result, *beside)
    yield from _door("figures.style", "render")(drawn)


def load(path: str | Path) -> Any:
    """Return any result of kneecore's from its JSON file, or from the folder that holds one.

    Raises
    ------
    FileFormatError
        If it cannot be read, or is no result of kneecore's; the message names the file.
    """
    read: Any = _door("files.load", "load")(path)
    return read

"""Which files an export writes, and how: checked before anything is computed, each whole or not."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from kneecore import Knee, SearchResult
from kneecore.errors import OutputError, ParameterError
from kneecore.files.folder import write_all
from kneecore.progress import Callback
from kneeviz.export import pictures
from kneeviz.export.film import Film, film_of
from kneeviz.export.page import html_page
from kneeviz.export.sheet import html_sheet

LESSON = "lesson"
"""The kind that needs no result."""


def targets(**given: str | None) -> dict[str, Path]:
    """Return the files asked for, by their kind.

    Raises
    ------
    ParameterError
        If there is none, one has no name, or two are the same.
    """
    asked = {kind: Path(name) for kind, name in given.items() if name is not None}
    if not asked:
        raise ParameterError(
            "nothing is asked for; --html FILE, --gif FILE, --png FILE or --lesson FILE is"
        )
    for kind, path in asked.items():
        if not path.name:
            raise ParameterError(f"`{kind}` is {str(path)!r}; the name of a file is allowed")
    if len({path.absolute() for path in asked.values()}) < len(asked):
        raise ParameterError("two of the files have the same name")
    return asked


def result_path(kinds: Iterable[str], given: str | None) -> str | None:
    """Return where the result is that the kinds need, or None if they need none.

    Raises
    ------
    ParameterError
        If they need one and none is given.
    """
    needing = [kind for kind in kinds if kind != LESSON]
    if needing and given is None:
        raise ParameterError(
            f"`RESULT` is not given; a search's result.json or its folder is needed for "
            f"{', '.join(needing)}"
        )
    return given if needing else None


def check(files: Mapping[str, Path], *, position: float, force: bool) -> None:
    """Check what can be checked before a result is read.

    Raises
    ------
    ParameterError
        If `position` is not between 0 and 1.
    OutputError
        If a file is there already and `force` is not given, or its folder is not there.
    """
    if not 0.0 <= position <= 1.0:
        raise ParameterError(f"`position` is {position:g}; 0 to 1 is allowed")
    for kind, path in files.items():
        if path.exists() and not force:
            raise OutputError(
                f"`{kind}` is {str(path)!r}, which is there already; another name or --force is "
                "allowed"
            )
        if not path.parent.is_dir():
            raise OutputError(f"`{kind}` is {str(path)!r}; {str(path.parent)!r} is no folder")


def content(
    kind: str,
    result: SearchResult | None,
    *,
    position: float = 0.0,
    callback: Callback | None = None,
) -> bytes:
    """Return an export: `kind` is "html", "gif", "png" or, without a result, "lesson".

    Raises
    ------
    ParameterError
        If there is no motion to draw: the result is of another model than a knee, or the model
        failed for all its knees; or there is no result.
    Cancelled
        If `callback`, which gets reports of what takes long, asked to stop.
    """
    if kind == LESSON:
        return html_sheet(callback).encode()
    if result is None:
        raise ParameterError(f"`{kind}` needs a result")
    if kind == "html":
        return html_page(result).encode()
    film = _film(kind, result)
    if kind == "gif":
        return pictures.gif(result, film, callback)
    return pictures.png(result, film, position)


def _film(kind: str, result: SearchResult) -> Film:
    if not isinstance(result.model, Knee):
        raise ParameterError(
            f"`{kind}`: the result is of the model {result.model.name[:60]!r}, which has no "
            "motion; a page (html) is allowed"
        )
    film = film_of(result)
    if not film.knees:
        raise ParameterError(f"`{kind}`: the model failed for all knees of the result")
    return film


def write(path: Path, content: bytes) -> None:
    """Write a file whole or not at all.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    write_all(path.parent, [(path.name, content)])

"""Results on disk: each file whole or not at all, `result.json` last."""

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from kneecore.errors import OutputError

if TYPE_CHECKING:
    from kneecore.search.result import SearchResult

RESULT_FILE = "result.json"


def write_whole(path: Path, content: bytes) -> None:
    """Write `content` to `path` by way of a temporary file beside it.

    Raises
    ------
    OutputError
        If it cannot be written; nothing is left behind.
    """
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror or error})") from None
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        os.chmod(name, 0o644)
        os.replace(name, path)
    except BaseException as error:
        with contextlib.suppress(OSError):
            os.unlink(name)
        if isinstance(error, OSError):
            raise OutputError(f"{path}: cannot be written ({error.strerror or error})") from None
        raise


def prepare_folder(folder: str | Path, *, force: bool, holds: str = RESULT_FILE) -> Path:
    """Return `folder`, made if need be and known to be writable.

    Parameters
    ----------
    folder : path
    force : bool
        Whether a result that is there may be overwritten.
    holds : str
        The file that tells that a result is there.

    Raises
    ------
    OutputError
        If it holds a result already and `force` is not given, or cannot be written.
    """
    folder = Path(folder)
    if (folder / holds).exists() and not force:
        raise OutputError(
            f"`--out` is {str(folder)!r}, which holds a {holds} already; "
            "another folder or --force is allowed"
        )
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OutputError(
            f"`--out` is {str(folder)!r}, which cannot be written "
            f"({error.strerror or error}); a writable folder is allowed"
        ) from None
    return folder


def _contents(result: "SearchResult", figures: bool) -> Iterator[tuple[str, bytes]]:
    yield "curves.csv", result.curves_csv().encode()
    from kneecore.search.command import needs_file

    if needs_file(result.space):
        yield "knee.toml", result.space.to_toml().encode()
    if figures:
        from kneecore.search.figures import render_figures

        yield from render_figures(result)
    yield RESULT_FILE, result.to_json().encode()


def save(
    result: "SearchResult", folder: str | Path, *, force: bool = False, figures: bool = True
) -> tuple[Path, ...]:
    """Write a result's files to `folder`; see `SearchResult.save`."""
    folder = prepare_folder(folder, force=force)
    # An old result.json beside new curves would tell a wrong story if this were interrupted.
    with contextlib.suppress(FileNotFoundError):
        (folder / RESULT_FILE).unlink()
    written = []
    for name, content in _contents(result, figures):
        write_whole(folder / name, content)
        written.append(folder / name)
    return tuple(written)

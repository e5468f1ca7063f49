"""Results on disk: each file whole or not at all, `result.json` last."""

import contextlib
import json
import logging
import os
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from kneecore.errors import OutputError
from kneecore.files.digest import with_digest
from kneecore.presented import Format

_LOG = logging.getLogger("kneecore")

RESULT_FILE = "result.json"


def _stage(path: Path, content: bytes) -> Path:
    """Write `content` to a temporary file beside `path`, with the user's usual permissions."""
    staged = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        staged.write_bytes(content)
    except OSError as error:
        with contextlib.suppress(OSError):
            staged.unlink()
        raise OutputError(f"{path}: cannot be written ({error.strerror or error})") from None
    except BaseException:
        staged.unlink(missing_ok=True)
        raise
    return staged


def write_file(path: Path, content: bytes) -> None:
    """Put `content` in the place of the file at `path`, whole or not at all.

    Raises
    ------
    OutputError
        If it cannot be written; what was there stands.
    """
    staged = _stage(path, content)
    try:
        os.replace(staged, path)
    except OSError as error:
        staged.unlink(missing_ok=True)
        raise OutputError(f"{path}: cannot be written ({error.strerror or error})") from None


def write_all(
    folder: Path, files: Iterable[tuple[str, bytes]], *, stale: Iterable[str] = ()
) -> tuple[Path, ...]:
    """Write files to `folder`, each whole or not at all, the last one last.

    All are written under temporary names first: a full disk, or Ctrl-C before the last of them is
    ready, leaves what was there. Then the old files, `stale` ones included, make way.

    Raises
    ------
    OutputError
        If they cannot be written.
    """
    staged: list[tuple[Path, Path]] = []
    try:
        for name, content in files:
            staged.append((_stage(folder / name, content), folder / name))
        names = [path.name for _, path in staged]
        # The last file tells that the others are there: it goes first and comes last.
        for name in reversed([*stale, *names]):
            (folder / name).unlink(missing_ok=True)
        for temporary, path in staged:
            os.replace(temporary, path)
    except OutputError:  # it names the file already
        raise
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written ({error.strerror or error})") from None
    finally:
        for temporary, _ in staged:
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)
    return tuple(path for _, path in staged)


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
    if str(folder) == "":
        raise OutputError("`folder` is empty; the name of a folder is allowed")
    folder = Path(folder)
    try:
        if (folder / holds).exists() and not force:
            raise OutputError(
                f"`folder` is {str(folder)!r}, which holds a {holds} already; "
                "another folder or --force is allowed"
            )
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OutputError:
        raise
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise OutputError(
            f"`folder` is {str(folder)!r}, which cannot be written "
            f"({reason}); a writable folder is allowed"
        ) from None
    return folder


def to_json(document: dict[str, Any]) -> str:
    """Return JSON-ready values and their digest as text, ending in a newline."""
    return json.dumps(with_digest(document), allow_nan=False, ensure_ascii=False) + "\n"


def contents(result: Any, form: Format, *, figures: bool) -> Iterator[tuple[str, bytes]]:
    """Yield (file name, content) of a result's files, numbers first, its JSON last.

    Figures that cannot be drawn are told of in a line and left out: the numbers never wait for
    them.
    """
    files = dict(form.others(result, False))
    if figures:
        try:
            # A text that shows figures, as a report's page, is another with them.
            files |= dict(form.others(result, True))
        except Exception as error:
            why = " ".join(f"{type(error).__name__}: {error}".split())
            _LOG.warning("figures cannot be drawn and are left out: %s", why[:300])
    yield from files.items()
    yield form.file, to_json(form.to_dict(result)).encode()


def save(
    result: Any, form: Format, folder: str | Path, *, force: bool = False, figures: bool = True
) -> tuple[Path, ...]:
    """Write a result's files to `folder`; see `kneecore.presented.Presented.save`."""
    folder = prepare_folder(folder, force=force, holds=form.file)
    return write_all(folder, contents(result, form, figures=figures), stale=form.stale)

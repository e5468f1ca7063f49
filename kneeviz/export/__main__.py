"""The command ``python -m kneeviz.export``: a search's result, or the lesson, to take away."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import tyro

from kneecore.cli import run
from kneecore.errors import KneecoreError

COMMAND = "python -m kneeviz.export"
_File = Annotated[str | None, tyro.conf.arg(metavar="FILE")]


@dataclass(frozen=True, kw_only=True)
class Options:
    """Make a page, an animation or a picture of a search's result, or the lesson's sheet.

    The page is one HTML file that opens from disk, without a server or a network: for a course page
    or a supplement.
    """

    result: Annotated[str | None, tyro.conf.Positional, tyro.conf.arg(metavar="RESULT")] = None
    """A search's result.json, or the folder that holds it; the lesson needs none."""
    html: _File = None
    """The page to write: both knees moving over the baseline, their curves, and what differs."""
    gif: _File = None
    """The animation to write: the motion there and back."""
    png: _File = None
    """The picture to write."""
    lesson: _File = None
    """The lesson's sheet to write, to be printed on A4: questions, and the answers at the end."""
    position: float = 0.0
    """What the picture shows, from 0 (full extension) to 1 (full flexion)."""
    force: bool = False
    """Overwrite files that are there."""
    quiet: bool = False
    """Print no progress."""


def _run(options: Options) -> int:
    from kneecore import SearchResult
    from kneecore.cli.progress import ProgressDisplay
    from kneeviz.export import files

    targets = files.targets(
        html=options.html, gif=options.gif, png=options.png, lesson=options.lesson
    )
    files.check(targets, position=options.position, force=options.force)
    source = files.result_path(targets, options.result)
    result = None if source is None else SearchResult.load(source)
    with ProgressDisplay(quiet=options.quiet) as told:
        made = {
            kind: files.content(kind, result, position=options.position, callback=told)
            for kind in targets
        }
    for kind, path in targets.items():
        files.write(path, made[kind])
        run.put(str(path))
    return run.DONE


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    options = run.parse(Options, arguments, COMMAND)
    try:
        return _run(options)
    except KneecoreError as error:
        return run.fail(COMMAND, error, options)
    except KeyboardInterrupt:
        return run.interrupted(COMMAND, "interrupted; no file is half-written")


if __name__ == "__main__":
    sys.exit(main())

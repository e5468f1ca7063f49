r"""The one way out for text to a terminal.

Titles, notes, file names and messages may come from files of strangers. A terminal obeys control
characters: codes that clear the screen, rename the window, hide what was said or write backwards.
They are shown as what they are, such as ``\u001b``; that is JSON's spelling too, so that a document
that is printed keeps its meaning.
"""

import contextlib
import io
import os
import re
import sys
from typing import TextIO

from kneecore.errors import OutputError

__all__ = ["Held", "put", "put_as_it_is", "say", "visible"]

# C0 without tab and newline, DEL, C1; marks, separators and overrides of the writing direction and
# of the line; half characters; the byte-order mark.
_CONTROL = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\xad\u061c\u180e\u200b\u200e\u200f\u2028-\u202e\u2060-\u206f"
    "\ud800-\udfff\ufeff\ufff9-\ufffb]"
)


def visible(text: str) -> str:
    r"""Return `text` with each control character written as ``\u`` and four digits."""
    return _CONTROL.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def put(text: str) -> None:
    """Print to stdout, control characters made visible; a reader that has gone is no error.

    Raises
    ------
    OutputError
        If stdout takes no more.
    """
    put_as_it_is(visible(text))


def put_as_it_is(text: str) -> None:
    """Print our own text to stdout, colours and all; otherwise as `put`."""
    try:
        print(text, flush=True)
    except BrokenPipeError:  # ``| head``
        _give_up(sys.stdout)
    except OSError as error:
        _give_up(sys.stdout)
        raise OutputError(f"stdout cannot be written ({error.strerror or error})") from None


def say(command: str, text: str) -> None:
    """Print a line about `command` to stderr; where stderr takes none, there is nobody to tell."""
    line = visible(" ".join(text.split()))
    try:
        print(f"{command}: {line}", file=sys.stderr, flush=True)
    except OSError:
        _give_up(sys.stderr)


def _give_up(stream: TextIO) -> None:
    """Let nothing more reach a stream: what it still holds would fail when the process ends."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


class Held(io.StringIO):
    """Stands for stdout and keeps what is printed, as it would look there."""

    def __init__(self) -> None:
        super().__init__()
        self._stands_for = sys.stdout

    def isatty(self) -> bool:
        """Tell whether it stands for a terminal: then there are colours."""
        return self._stands_for.isatty()

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """Encoding of what it stands for: not every one has lines for boxes."""
        return self._stands_for.encoding

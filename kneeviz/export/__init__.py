"""To take away: a search's result as page, animation or picture, and the lesson on paper."""

from kneecore import SearchResult
from kneecore.progress import Callback

NAMES = {"knees.html": "html", "knees.gif": "gif", "knees.png": "png"}
"""What the page calls its exports, and their kinds."""


def content(
    kind: str, result: SearchResult | None, *, position: float, callback: Callback | None
) -> bytes:
    """Return an export; see `kneeviz.export.files.content`."""
    # Matplotlib, which only an export needs, takes half a second to load.
    from kneeviz.export import files

    return files.content(kind, result, position=position, callback=callback)

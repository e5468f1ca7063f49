"""What handles say of themselves under a pointer: kept on the page, for its script to show."""

import json
from collections.abc import Mapping

from kneeviz.views.html.pieces import escape

_FONT = 13.0  # px


def hints(texts: Mapping[str, str], *, reach: float, size: float) -> str:
    """Return an element that shows nothing and holds the texts of handles.

    Parameters
    ----------
    texts : mapping
        By the handles' names.
    reach : float
        m; so far from its middle a handle is taken.
    size : float
        The theme's.
    """
    told = json.dumps({"reach": reach, "size": _FONT * size, "texts": texts})
    return f'<div id="kneeviz-handles" data-texts="{escape(told)}" hidden></div>'

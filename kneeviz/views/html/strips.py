"""Where values lie between two bounds: a row with a name, a line with dots, and numbers."""

from collections.abc import Sequence

from kneeviz.views import theme

__all__ = ["strip"]


def strip(label: str, title: str, entries: Sequence[tuple[str, float, str]]) -> str:
    """Return one row; label and title must be escaped.

    Parameters
    ----------
    label : str
        What stands at its left.
    title : str
        What is told when the pointer rests on it.
    entries : sequence of (colour, place between 0 and 1, value)
        The dots; all but the first also with their values at the right.
    """
    dots = "".join(_dot(colour, place) for colour, place, _ in entries)
    values = " ".join(
        f'<span style="color:{theme.ink(hue)}">{value}</span>' for hue, _, value in entries[1:]
    )
    return (
        f'<div style="display:flex;align-items:center;gap:6px;height:17px" title="{title}">'
        f'<span style="width:122px;white-space:nowrap;overflow:hidden">{label}</span>'
        f'<span style="position:relative;flex:1;height:2px;background:rgba(128,128,128,.35)">'
        f'{dots}</span><span style="width:118px;text-align:right;font-size:10px;'
        f'white-space:nowrap;font-variant-numeric:tabular-nums">{values}</span></div>'
    )


def _dot(colour: str, share: float) -> str:
    place = 100.0 * min(max(share, 0.0), 1.0)
    return (
        f'<span style="position:absolute;left:{place:.1f}%;top:-4px;width:9px;height:9px;'
        f'margin-left:-4px;border-radius:50%;background:{colour};opacity:.85"></span>'
    )

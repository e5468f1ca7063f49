"""How a session shows what a search found. Runs on its worker."""

from typing import TYPE_CHECKING, Any

from kneeviz import controls, markup, theme
from kneeviz.state import PRESETS

if TYPE_CHECKING:
    from kneeviz.session import Session


def take_result(session: "Session", result: Any) -> None:
    """Show a result's two knees and offer its files."""
    session.state.take_result(result)
    tab, knee = session.view.search, session.view.knee
    tab.overlay.visible = tab.adopt.visible = True
    tab.overlay.value = True
    chosen = knee.preset.value
    knee.preset.options = (
        controls.OWN_KNEE,
        controls.BASELINE,
        *controls.WORST,
        *PRESETS,
        controls.RANDOM,
    )
    knee.preset.value = chosen
    for handle in session.view.files.result.values():
        handle.disabled = False
    session.show_overlay(True)
    show_result(session)


def show_result(session: "Session") -> None:
    """Write what the last search found, greyed if the bounds have changed since."""
    result, view = session.state.result, session.view
    if result is None:
        return
    stale = session.state.result_is_stale
    style = "opacity:.45" if stale else ""
    note = "<b>Bounds changed since this search.</b><br>" if stale else ""
    sentence = markup.escape(result.summary())
    view.search.found.content = markup.box(
        f"{note}<b>{sentence}</b><br>{markup.objective_line(result)}", style=style
    )
    colours = theme.palette(view.dark)
    command = "The same without a browser:" + markup.command_line(result.command())
    view.search.table.content = markup.box(
        markup.differences(result, colours)
        + f'<div style="margin-top:5px">{markup.bound_names(result)}</div>'
        + f'<div style="margin-top:5px">{command}</div>',
        style=style,
    )
    view.found.content = markup.box(f"{note}{sentence}", style=style)
    view.files.command.content = markup.box(command, style=style)

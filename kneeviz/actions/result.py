"""How a session shows what a search found. Runs on its worker."""

from typing import TYPE_CHECKING, Any

from kneeviz.state.knee import PRESETS
from kneeviz.views import theme
from kneeviz.views.html import pieces as markup
from kneeviz.views.tabs import controls

if TYPE_CHECKING:
    from kneeviz.server.session import Session


def take_result(session: "Session", result: Any, *, reveal: bool = True) -> None:
    """Show a result's two knees and offer its files.

    With `reveal` the knees are shown even if the visitor had hidden those before.
    """
    session.state.take_result(result)
    tab, preset = session.view.search, session.view.knee.preset
    tab.overlay.visible = tab.adopt.visible = True
    options = (
        controls.OWN_KNEE,
        controls.BASELINE,
        *controls.WORST,
        *PRESETS,
        controls.RANDOM,
    )
    if preset.options != options:
        chosen, preset.options = preset.value, options
        preset.value = chosen
    for handle in session.view.files.result.values():
        handle.disabled = False
    if reveal:
        tab.overlay.value = True
        session.show_overlay(True)
    session.touch()
    session.forget_runs()
    show_result(session)


def show_result(session: "Session") -> None:
    """Write what the last search found, greyed if the bounds have changed since."""
    result, view = session.state.result, session.view
    if result is None:
        return
    session.shown_stale = stale = session.is_stale()
    style = "opacity:.45" if stale else ""
    changed = "Bounds" if result.space.is_around_baseline else "Knee or bounds"
    note = f"<b>{changed} changed since this search.</b><br>" if stale else ""
    sentence = markup.escape(result.summary())
    told = f"{note}<b>{sentence}</b><br>{markup.objective_line(result)}"
    evidence = markup.repair_line(result) + markup.evidence_line(result)
    view.search.found.content = markup.box(told + evidence, style=style)
    colours = theme.palette(view.dark)
    command = "The same without a browser:" + markup.command_line(result.command())
    view.search.table.content = markup.box(
        markup.differences(result, colours)
        + f'<div style="margin-top:5px">{markup.bound_names(result)}</div>'
        + f'<div style="margin-top:5px">{command}</div>',
        style=style,
    )
    short = told + evidence if session.live.on else f"{note}{sentence}"
    view.found.content = markup.box(short, style=style)
    view.files.command.content = markup.box(command, style=style)

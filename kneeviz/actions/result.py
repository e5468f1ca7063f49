"""How a page shows what a search found. Runs on the session's worker."""

from kneecore import SearchResult
from kneecore import command_line as command_of
from kneeviz.page import belonging
from kneeviz.page.page import Page
from kneeviz.state.presets import BASELINE, OWN_KNEE, PRESETS, RANDOM, WORST
from kneeviz.views import theme
from kneeviz.views.html import pieces
from kneeviz.views.html.pieces import box, plain
from kneeviz.views.html.result import (
    bound_names,
    differences,
    evidence_line,
    objective_line,
    repair_line,
    unfinished_line,
)


def take_result(page: Page, result: SearchResult, *, reveal: bool = True) -> None:
    """Show a result's two knees and offer its files.

    With `reveal` the knees are shown even if the visitor had hidden those before.
    """
    page.state.take_result(result)
    tab, preset = page.view.search, page.view.knee.preset
    tab.overlay.visible = tab.adopt.visible = True
    options = (OWN_KNEE, BASELINE, *WORST, *PRESETS, RANDOM)
    if preset.options != options:
        chosen, preset.options = preset.value, options
        preset.value = chosen
    for handle in page.view.files.result.values():
        handle.disabled = False
    if reveal:
        tab.overlay.value = True
        page.show_overlay(True)
    page.touched = True
    page.motion.forget()
    show_result(page)


def forget_result(page: Page) -> None:
    """Show no result any more, and offer nothing of it."""
    page.state.forget_result()
    page.show_overlay(False)
    tab, preset = page.view.search, page.view.knee.preset
    tab.overlay.visible = tab.adopt.visible = False
    if preset.value in WORST:
        preset.value = OWN_KNEE
    preset.options = (OWN_KNEE, BASELINE, *PRESETS, RANDOM)
    for handle in page.view.files.result.values():
        handle.disabled = True
    show_result(page)


def show_result(page: Page) -> None:
    """Write what the last search found, if there is anything."""
    result, since = page.state.result, "this search"
    if result is None:
        for place in ("search.found", "search.table", "found", "files.command"):
            belonging.write(page, place, "")
        return
    sentence = plain(result.summary())
    told = f"<b>{sentence}</b><br>{objective_line(result)}"
    unfinished = unfinished_line(result, improving=page.live.improving)
    evidence = unfinished + repair_line(result) + evidence_line(result)
    command = ""
    if result.stop_reason != "cancelled":  # the command would go on to the end
        command = "The same without a browser:" + pieces.command_line(command_of(result) or "")
    table = (
        differences(result, theme.palette(page.view.dark))
        + f'<div style="margin-top:5px">{bound_names(result)}</div>'
        + f'<div style="margin-top:5px">{command}</div>'
    )
    short = told + evidence if page.live.on else f"{sentence}{unfinished}"
    belonging.write(page, "search.found", box(told + evidence), since=since)
    belonging.write(page, "search.table", box(table), since=since)
    belonging.write(page, "found", box(short), since=since)
    belonging.write(page, "files.command", box(command) if command else "", since=since)

"""How a page shows what a search found. Runs on the session's worker."""

from kneecore import SearchResult
from kneecore import command_line as command_of
from kneeviz.page import belonging
from kneeviz.page.page import Page
from kneeviz.state import results
from kneeviz.state.presets import BASELINE, OWN_KNEE, PRESETS, RANDOM, WORST
from kneeviz.views import theme
from kneeviz.views.html import pieces
from kneeviz.views.html.pieces import box, plain
from kneeviz.views.html.result import (
    bound_names,
    differences,
    evidence_line,
    objective_line,
    reconciled,
    repair_line,
    unfinished_line,
)


def take_result(page: Page, result: SearchResult, *, reveal: bool = True) -> None:
    """Show a result's two knees and offer its files.

    With `reveal` the knees are shown even if the visitor had hidden those before.
    """
    before = page.state.result
    if before is not None and results.solver(before) != results.solver(result):
        page.other = before
    page.state.take_result(result)
    tab, preset = page.view.search, page.view.knee.preset
    tab.offer_pair(True)
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
    tab.offer_pair(False)
    if preset.value in WORST:
        preset.value = OWN_KNEE
    preset.options = (OWN_KNEE, BASELINE, *PRESETS, RANDOM)
    for handle in page.view.files.result.values():
        handle.disabled = True
    show_result(page)


def _beside_other(page: Page) -> str:
    """Return how the result and one before it fit, of which one is at rest and one in motion."""
    pair = (page.state.result, page.other)
    if not page.exact_ready or any(r is None or r.stop_reason == "cancelled" for r in pair):
        return ""
    by_solver = {results.solver(r): r for r in pair if r is not None}
    if len(by_solver) < 2 or not results.same_question(*by_solver.values()):
        return ""
    rest, moving = by_solver["equilibrium"], by_solver["dynamics"]
    if rest.objective_model is None or moving.objective_model is None:
        return ""
    same_pair = results.objective_at_rest(moving)
    return reconciled(rest.objective_model, moving.objective_model, same_pair)


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
    evidence = unfinished + repair_line(result) + evidence_line(result) + _beside_other(page)
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

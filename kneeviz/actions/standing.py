"""Draws anew what has begun or ceased to belong to what is set. Runs on the session's worker."""

from kneeviz.actions import landscape, methods, study
from kneeviz.actions.result import show_result
from kneeviz.page import belonging
from kneeviz.page.page import Page


def follow(page: Page) -> None:
    """Grey, fade or leave out together what does not belong to the state; cheap if all is done."""
    standing, ghosts = belonging.standing(page), belonging.ghosts(page)
    now = (
        standing,
        page.state.result,
        page.band,
        (page.overlay, page.live.on, page.view.dark),
        ghosts,
    )
    if now == page.standing:
        return
    page.standing = now
    page.view.fade(belonging.faded(standing))
    page.view.show_legends(page.overlay, belonging.band(page), ghosts=bool(ghosts))
    show_result(page)
    for subject in (study, methods, landscape):
        subject.refresh(page)
    page.touched = True

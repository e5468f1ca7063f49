"""Links that open a state: made and opened. Runs on the session's worker."""

from collections.abc import Callable

import viser

from kneecore import KneecoreError
from kneeviz import viser_scripts
from kneeviz.actions import undo
from kneeviz.actions.search import stop_search
from kneeviz.jobs.messages import Asked
from kneeviz.page.page import Page
from kneeviz.state.links import Offered, from_code, to_code
from kneeviz.state.snapshot import Snapshot
from kneeviz.views.links import OPEN, add_link_reader, link_text, offer_link


def receive(page: Page, client: viser.ClientHandle) -> None:
    """Let a client that has joined tell the link by which it has come."""
    reader = add_link_reader(client.gui, page.post)
    viser_scripts.tell_link(client, reader, once=page.target is not client)


def follow(page: Page) -> None:
    """Show no link to what is no longer set."""
    made = page.links.made
    if made is not None and not made.same_as(page.snapshot()):
        page.links.made = None
        page.view.files.link.content = ""


def _copy(page: Page, value: Asked) -> None:
    state = page.snapshot()
    try:
        code = to_code(state, page.view.first_settings)
    except KneecoreError as error:
        page.notices.tell(value.client_id, "No link", str(error))
        return
    page.links.made = state
    page.view.files.link.content = link_text(code)
    client = page.clients().get(value.client_id)
    if client is not None:
        viser_scripts.copy_address(client, f"?knee={code}")
        page.notices.tell(value.client_id, "Link copied", "It also stands in Files.", bad=False)


def _arrived(page: Page, value: Asked) -> None:
    """Open the link of a visitor with a page of his own; where others look, too, ask him first."""
    try:
        state = undo.complete(page, from_code(value.value))
    except KneecoreError as error:
        text = f"{str(error)[:300]}. What was there stands."
        page.notices.tell(value.client_id, "Link not opened", text)
        return
    client = page.clients().get(value.client_id)
    if page.target is client:
        _open(page, state)
    elif client is not None:
        _offer(page, client, state)


def _offer(page: Page, client: viser.ClientHandle, state: Snapshot) -> None:
    here, links = page.clients(), page.links
    earlier = links.offered.pop(client.client_id, None)
    if earlier is not None:
        earlier.question.close()
    links.offered = {c: offered for c, offered in links.offered.items() if c in here}
    links.offered[client.client_id] = Offered(state, offer_link(client.gui, page.post))


def _answered(page: Page, value: Asked) -> None:
    """Open an offered link, or leave what is there."""
    offered = page.links.offered.pop(value.client_id, None)
    if offered is None:
        return
    offered.question.close()
    if value.value == OPEN:
        _open(page, offered.state)


def _open(page: Page, state: Snapshot) -> None:
    stop_search(page)
    undo.restore(page, state)
    page.say("Opened the linked knee. Undo brings back what was there.")


ACTIONS: dict[str, Callable[..., None]] = {
    "copy_link": _copy,
    "link": _arrived,
    "open_link": _answered,
}

"""What a visitor does with files. Runs on its worker."""

from collections.abc import Callable

from kneecore import FileFormatError, KneecoreError, KneeFile, SearchResult
from kneeviz.actions import export
from kneeviz.actions.downloads import result_files
from kneeviz.actions.knee import load_knee
from kneeviz.actions.live import set_live
from kneeviz.actions.result import take_result
from kneeviz.export import NAMES
from kneeviz.jobs.messages import Asked
from kneeviz.jobs.uploads import NAMELESS, Uploaded
from kneeviz.page.page import Page
from kneeviz.state import results
from kneeviz.views.html.pieces import escape


def _download(page: Page, value: Asked, name: str) -> None:
    client = page.clients().get(value.client_id)
    if client is None:
        return
    if name == "knee.toml":
        content = page.state.knee_text().encode()
    elif page.state.result is None:
        page.notices.tell(value.client_id, "Nothing to download", "No search has been made yet.")
        return
    elif name in NAMES:
        export.start(page, page.state.result, value.client_id, name)
        return
    else:
        content = result_files(page.state.result, name)
    client.send_file_download(name, content, save_immediately=True)


def _upload(page: Page, value: tuple[str, bytes], client_id: int) -> None:
    name, content = value
    told = escape(name[:80] or NAMELESS)
    if page.uploads.read(name, content, client_id):
        page.say(f"Reading {told} \u2026", "busy")
    else:
        _not_loaded(page, client_id, name or NAMELESS, "too many files are being read; try again.")


def _not_loaded(page: Page, client_id: int, name: str, why: str) -> None:
    page.notices.tell(client_id, "File not loaded", f"{name[:80]}: {why[:300]}")


def _uploaded(page: Page, value: Uploaded, client_id: int) -> None:
    loaded = value.loaded
    try:
        if value.why is not None:
            raise FileFormatError(value.why)
        if isinstance(loaded, SearchResult):
            results.of_knees(loaded)
    except KneecoreError as error:
        page.say("What you had stands.")
        _not_loaded(page, client_id, value.name, str(error))
        return
    if isinstance(loaded, KneeFile):
        load_knee(page, loaded)
        page.say(f"Loaded \u201c{escape(loaded.title[:60])}\u201d. Undo brings your knee back.")
    elif loaded is not None:
        set_live(page, False)
        take_result(page, loaded)
        page.say("Loaded the result: model 1 in blue, model 2 in orange. Undo: the last one.")


ACTIONS: dict[str, Callable[..., None]] = {
    "download": _download,
    "upload": _upload,
    "uploaded": _uploaded,
}

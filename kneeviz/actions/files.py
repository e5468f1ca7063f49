"""What a visitor does with files. Runs on its worker."""

from collections.abc import Callable

from kneecore import KneecoreError, KneeFile
from kneeviz.actions.downloads import read_upload, result_files
from kneeviz.actions.knee import load_knee
from kneeviz.actions.live import set_live
from kneeviz.actions.result import take_result
from kneeviz.jobs.messages import Asked
from kneeviz.page.page import Page
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
    else:
        content = result_files(page.state.result, name)
    client.send_file_download(name, content, save_immediately=True)


def _upload(page: Page, value: tuple[str, bytes, int]) -> None:
    name, content, client_id = value
    try:
        loaded = read_upload(name, content)
    except KneecoreError as error:
        page.notices.tell(client_id, "File not loaded", f"{name[:80]}: {str(error)[:300]}")
        return
    if isinstance(loaded, KneeFile):
        load_knee(page, loaded)
        page.say(f"Loaded the knee “{escape(loaded.title[:60])}”.")
    else:
        set_live(page, False)
        take_result(page, loaded)
        page.say("Loaded the result: model 1 in blue, model 2 in orange.")


ACTIONS: dict[str, Callable[..., None]] = {
    "download": _download,
    "upload": _upload,
}

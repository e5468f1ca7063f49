"""What a visitor of a model's page does with files. Runs on the session's worker."""

from collections.abc import Callable

from kneecore import FileFormatError, KneecoreError
from kneeviz.actions.downloads import everything, result_files
from kneeviz.anymodel.actions.search import take_result
from kneeviz.anymodel.page import ModelPage
from kneeviz.anymodel.state import of_this_model
from kneeviz.jobs.messages import Asked
from kneeviz.jobs.uploads import NAMELESS, Uploaded
from kneeviz.views.html.pieces import escape


def _download(page: ModelPage, value: Asked, name: str) -> None:
    client, state = page.clients().get(value.client_id), page.state
    if client is None:
        return
    if name in ("sampled", "influence", "landscape"):
        found = getattr(state, name)
        content = None if found is None else everything(found)
        name = f"{name}.zip"
    else:
        content = None if state.result is None else result_files(state.result, name)
    if content is None:
        page.notices.tell(value.client_id, "Nothing to download", "That has not been computed.")
        return
    client.send_file_download(name, content, save_immediately=True)


def _upload(page: ModelPage, value: tuple[str, bytes], client_id: int) -> None:
    name, content = value
    if page.uploads.read(name, content, client_id):
        page.say(f"Reading {escape(name[:80] or NAMELESS)} \u2026", "busy")
    else:
        why = "too many files are being read; try again."
        _not_loaded(page, client_id, name or NAMELESS, why)


def _not_loaded(page: ModelPage, client_id: int, name: str, why: str) -> None:
    page.notices.tell(client_id, "File not loaded", f"{name[:80]}: {why[:300]}")


def _uploaded(page: ModelPage, value: Uploaded, client_id: int) -> None:
    try:
        if value.why is not None:
            raise FileFormatError(value.why)
        result = of_this_model(page.state.model, value.loaded)
    except KneecoreError as error:
        page.say("What you had stands.")
        _not_loaded(page, client_id, value.name, str(error))
        return
    take_result(page, result)
    page.say("Loaded the result: model 1 in blue, model 2 in orange.")


ACTIONS: dict[str, Callable[..., None]] = {
    "download": _download,
    "upload": _upload,
    "uploaded": _uploaded,
}

"""What a session does with files. Runs on its worker."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from kneecore import Knee, KneecoreError
from kneeviz.actions import downloads as files
from kneeviz.actions.knee import load_knee
from kneeviz.actions.live import set_live
from kneeviz.actions.result import take_result
from kneeviz.views.html import pieces as markup

if TYPE_CHECKING:
    from kneeviz.server.session import Session


def _download(session: "Session", value: Any, name: str) -> None:
    client = session.clients().get(value.client_id)
    if client is None:
        return
    if name == "knee.toml":
        content = session.state.knee_text().encode()
    elif session.state.result is None:
        session.notices.tell(value.client_id, "Nothing to download", "No search has been made yet.")
        return
    else:
        content = files.result_files(session.state.result, name)
    client.send_file_download(name, content, save_immediately=True)


def _upload(session: "Session", value: tuple[str, bytes, int]) -> None:
    name, content, client_id = value
    try:
        loaded = files.read_upload(name, content)
    except KneecoreError as error:
        session.notices.tell(client_id, "File not loaded", f"{name[:80]}: {str(error)[:300]}")
        return
    if isinstance(loaded, Knee):
        load_knee(session, loaded)
        session.say(f"Loaded the knee “{markup.escape(loaded.title[:60])}”.")
    else:
        set_live(session, False)
        take_result(session, loaded)
        session.say("Loaded the result: model 1 in blue, model 2 in orange.")


DEEDS: dict[str, Callable[..., None]] = {
    "download": _download,
    "upload": _upload,
}

"""What a visitor takes away: of a result, and the lesson on paper. Drawn on a thread of its own."""

from collections.abc import Callable
from dataclasses import dataclass

from kneecore import SearchResult
from kneeviz import export
from kneeviz.jobs.job import Job, JobDone, JobProgress, Watch
from kneeviz.jobs.messages import Asked
from kneeviz.page.page import Page
from kneeviz.views.html.pieces import escape


@dataclass(frozen=True, kw_only=True, eq=False)
class Exported:
    """A drawn file, and who asked for it."""

    name: str
    client_id: int
    content: bytes


def start(page: Page, result: SearchResult, client_id: int, name: str) -> None:
    """Draw an export of a result; it goes to who asked for it."""
    position = page.playback.share if page.playback.mode == "sweep" else 0.0

    def draw(watch: Watch) -> bytes:
        return export.content(export.NAMES[name], result, position=position, callback=watch)

    _start(page, draw, client_id, name)


def _start(page: Page, draw: Callable[[Watch], bytes], client_id: int, name: str) -> None:
    if page.export_job is not None:
        page.notices.tell(client_id, "Not now", "Another file is being drawn; try again.")
        return

    def work(watch: Watch) -> Exported:
        return Exported(name=name, client_id=client_id, content=draw(watch))

    page.export_job = Job("export", work, page.post)
    page.say(f"Drawing {name} \u2026", "busy")
    page.export_job.start()


def _lesson_sheet(page: Page, value: Asked) -> None:
    def draw(watch: Watch) -> bytes:
        return export.content("lesson", None, position=0.0, callback=watch)

    if page.surrogate_ready:
        _start(page, draw, value.client_id, "lesson.html")
    else:
        text = "The model is still being prepared; try again in a moment."
        page.notices.tell(value.client_id, "Not now", text)


def _progress(page: Page, news: JobProgress) -> None:
    if news.job is page.export_job:
        page.say(f"Drawing the file \u2026 {news.percent:.0f} %", "busy")


def _done(page: Page, news: JobDone) -> None:
    if news.job is not page.export_job:
        return
    page.export_job = None
    if isinstance(news.result, Exported):
        client = page.clients().get(news.result.client_id)
        if client is not None:
            client.send_file_download(news.result.name, news.result.content, save_immediately=True)
        page.say(f"Drawn: {news.result.name}.")
    elif news.why is not None:
        page.say(f"The file could not be drawn: {escape(news.why)}", "bad")


ACTIONS: dict[str, Callable[..., None]] = {
    "export_progress": _progress,
    "export_done": _done,
    "lesson_sheet": _lesson_sheet,
}

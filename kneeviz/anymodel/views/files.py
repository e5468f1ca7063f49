"""The tab "Files" of a model: downloads, and a result to load."""

from typing import Any

from kneeviz.jobs.messages import Post
from kneeviz.views.html.pieces import box
from kneeviz.views.tabs.events import on_press


class FilesTab:
    """Downloads, shut until there is something, and an upload."""

    def __init__(self, gui: Any, post: Post) -> None:
        gui.add_html(box("<b>The last search</b>"))
        self.result = {
            "result.json": gui.add_button("Result (result.json)", disabled=True),
            "curves.csv": gui.add_button("Curves (curves.csv)", disabled=True),
            "result.zip": gui.add_button("All of it, with figures (.zip)", disabled=True),
        }
        gui.add_html(box("<b>Studies</b>, each with its figures"))
        self.studies = {
            "sampled": gui.add_button("Band (.zip)", disabled=True),
            "influence": gui.add_button("Influence (.zip)", disabled=True),
            "landscape": gui.add_button("Landscape (.zip)", disabled=True),
        }
        gui.add_html(box("<b>Load</b> a result of this model (.json)"))
        self.upload = gui.add_upload_button("Load a result …", mime_type=".json", color="gray")
        self.command = gui.add_html("")
        for name, handle in {**self.result, **self.studies}.items():
            on_press(handle, post, ("download", name))
        self._on_upload(post)

    def _on_upload(self, post: Post) -> None:
        async def arrived(event: Any) -> None:
            file = event.target.value
            post(("upload", event.client_id), (file.name, file.content))

        self.upload.on_upload(arrived)

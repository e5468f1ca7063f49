"""The tab "Files" of a model: downloads, and a result to load."""

from typing import Any

from kneeviz.jobs.messages import Post
from kneeviz.views.html.pieces import box, heading
from kneeviz.views.tabs.events import on_press, on_upload
from kneeviz.views.tabs.files import add_result_files


class FilesTab:
    """Downloads, shut until there is something, and an upload."""

    def __init__(self, gui: Any, post: Post) -> None:
        self.result = add_result_files(gui)
        gui.add_html(box(heading("Studies") + "Each with its figures"))
        self.studies = {
            "sampled": gui.add_button("Band (.zip)", disabled=True),
            "influence": gui.add_button("Influence (.zip)", disabled=True),
            "landscape": gui.add_button("Landscape (.zip)", disabled=True),
        }
        gui.add_html(box(heading("Load") + "A result of this model (.json)"))
        self.upload = gui.add_upload_button("Load a result …", mime_type=".json", color="gray")
        self.command = gui.add_html("")
        for name, handle in {**self.result, **self.studies}.items():
            on_press(handle, post, ("download", name))
        on_upload(self.upload, post)

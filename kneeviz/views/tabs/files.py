"""The tab "Files": downloads and the one upload that takes either file."""

from typing import Any

from kneeviz.jobs.messages import Post
from kneeviz.views.html.pieces import box
from kneeviz.views.tabs.events import on_press


class FilesTab:
    """Downloads and the one upload that takes either file."""

    def __init__(self, gui: Any, post: Post) -> None:
        gui.add_html(box("<b>The last search</b>"))
        self.result = {
            "result.json": gui.add_button("Result (result.json)", disabled=True),
            "curves.csv": gui.add_button("Curves (curves.csv)", disabled=True),
            "result.zip": gui.add_button("All of it, with figures (.zip)", disabled=True),
            "knees.html": gui.add_button(
                "Page that moves (.html)",
                disabled=True,
                hint="One file that opens from disk: both knees in motion, curves, what differs.",
            ),
            "knees.gif": gui.add_button("Animation (.gif)", disabled=True),
            "knees.png": gui.add_button(
                "Picture (.png)",
                disabled=True,
                hint="Knees and curves at the moment on screen.",
            ),
        }
        gui.add_html(box("<b>Your knee</b>: baseline, bounds and current values"))
        self.knee = gui.add_button("Knee (knee.toml)")
        gui.add_html(box("<b>Load</b> a knee (.toml) or a result (.json)"))
        self.upload = gui.add_upload_button("Load a file …", mime_type=".toml,.json", color="gray")
        self.command = gui.add_html("")
        for name, handle in (*self.result.items(), ("knee.toml", self.knee)):
            on_press(handle, post, ("download", name))
        self._on_upload(post)

    def _on_upload(self, post: Post) -> None:
        async def arrived(event: Any) -> None:
            file = event.target.value
            post(("upload", event.client_id), (file.name, file.content))

        self.upload.on_upload(arrived)

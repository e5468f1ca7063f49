"""The tab "Files": downloads and the one upload that takes either file."""

from typing import Any

from kneeviz.jobs.messages import Post
from kneeviz.views.html.pieces import box, heading
from kneeviz.views.tabs.events import on_press, on_upload


def add_result_files(gui: Any) -> dict[str, Any]:
    """Add the downloads of a search of any model, shut until there is a result."""
    gui.add_html(box(heading("The last search")))
    return {
        "result.json": gui.add_button("Result (result.json)", disabled=True),
        "curves.csv": gui.add_button("Curves (curves.csv)", disabled=True),
        "result.zip": gui.add_button("All of it, with figures (.zip)", disabled=True),
    }


class FilesTab:
    """Downloads and the one upload that takes either file."""

    def __init__(self, gui: Any, post: Post) -> None:
        self.result = add_result_files(gui) | {
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
        gui.add_html(box(heading("Your knee") + "Baseline, bounds and current values"))
        self.knee = gui.add_button("Knee (knee.toml)")
        self.copy = gui.add_button(
            "Copy link",
            color="gray",
            hint="An address that opens this knee, its bounds and settings; no results.",
        )
        self.link = gui.add_html("")
        gui.add_html(box(heading("Load") + "A knee (.toml) or a result (.json)"))
        self.upload = gui.add_upload_button("Load a file …", mime_type=".toml,.json", color="gray")
        self.command = gui.add_html("")
        for name, handle in (*self.result.items(), ("knee.toml", self.knee)):
            on_press(handle, post, ("download", name))
        on_press(self.copy, post, "copy_link")
        on_upload(self.upload, post)

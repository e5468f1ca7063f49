"""The tab "View": how things look and move."""

from typing import Any

from kneeviz.jobs.messages import Post
from kneeviz.views.html.pieces import box, faint
from kneeviz.views.tabs.events import on_press, on_value

MODES = {
    "Through the loads": "sweep",
    "In time, extending": "extension",
    "In time, flexing": "flexion",
}


class LookTab:
    """How things look and move."""

    def __init__(self, gui: Any, post: Post) -> None:
        self.mode = gui.add_dropdown(
            "Motion",
            tuple(MODES),
            hint="Through the loads: the knee at rest under each moment. In time: the simulated "
            "motion itself, with its damping.",
        )
        self.speed = gui.add_slider("Speed", min=0.25, max=4.0, step=0.25, initial_value=1.0)
        self.loop = gui.add_checkbox("Loop", True)
        self.forces = gui.add_checkbox(
            "Newtons", False, hint="Write each ligament's tension beside its name."
        )
        self.handles = gui.add_checkbox(
            "Handles",
            True,
            hint="While the motion is paused: drag a ring to move that point. Click it to see its "
            "bound, magnified, and drag the bound's edge. Two clicks: home. Escape: as it was.",
        )
        self.ghosts = gui.add_checkbox(
            "Ghosts",
            False,
            hint="Keep your last three knees faint behind the present one, in the picture (through "
            "the loads) and in the curve.",
        )
        self.clear_ghosts = gui.add_button("Clear ghosts", color="gray")
        self.dark = gui.add_checkbox("Dark theme", False)
        self.large = gui.add_checkbox(
            "Class size", False, hint="Larger text, lines and dots, for the last row."
        )
        self.note = gui.add_html(
            box(
                faint(
                    "Slack ligaments are thin and grey; taut ones take colour and width with their "
                    "tension. The arrow is the contact force on the tibia. The circle and the line "
                    "are what the model computes with; the bones around them, and all depth in the "
                    "3D view, are illustrative. Over a chart the pointer is told the values, "
                    "and a paused knee stands as the curve says there; a click lets it stay so."
                )
            )
        )
        for handle, key in (
            (self.mode, "mode"),
            (self.speed, "speed"),
            (self.loop, "loop"),
            (self.forces, "forces"),
            (self.handles, "handles"),
            (self.ghosts, "ghosts"),
            (self.dark, "dark"),
            (self.large, "large"),
        ):
            on_value(handle, post, key)
        on_press(self.clear_ghosts, post, "clear_ghosts")

"""What stands above the tabs: the pose in numbers, motion, view, and the status line."""

from dataclasses import dataclass
from typing import Any

import viser

from kneeviz.jobs.messages import Post
from kneeviz.views.html.pieces import status
from kneeviz.views.tabs.change import add_change
from kneeviz.views.tabs.events import on_press, on_value

PLAY, PAUSE = "Play", "Pause"


@dataclass(kw_only=True)
class Transport:
    """Play, position and view: always in sight, above the tabs."""

    readout: Any
    status: Any
    play: Any
    position: Any
    view: Any
    change: Any

    def show_playing(self, playing: bool) -> None:
        """Let the one button say what it would do, which also tells what is so now."""
        label = PAUSE if playing else PLAY
        if self.play.label != label:
            self.play.label = label
            self.play.icon = viser.Icon.PLAYER_PAUSE if playing else viser.Icon.PLAYER_PLAY


def add_transport(gui: Any, post: Post) -> Transport:
    """Build what stands above the tabs."""
    readout = gui.add_html("")
    play = gui.add_button(PAUSE, icon=viser.Icon.PLAYER_PAUSE)
    position = gui.add_slider(
        "Position (%)",
        min=0.0,
        max=100.0,
        step=0.1,
        initial_value=0.0,
        marks=((0.0, "straight"), (100.0, "bent")),
        hint="Through the loads: from +5 N·m (extension) to \u22125 N·m (flexion). "
        "In time: 0 to 23 s.",
    )
    view = gui.add_button_group("View", ("2D", "3D", "Reset"))
    change = add_change(gui, post, "knee, bounds, settings and result")
    line = gui.add_html(status("Preparing the model …", kind="busy"))
    on_press(play, post, "play")
    on_value(position, post, "position")
    on_press(view, post, "view")
    return Transport(
        readout=readout, status=line, play=play, position=position, view=view, change=change
    )

"""What can be done from the keyboard: shortcuts, and the palette (Ctrl+K) that lists them all."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Any

from kneeviz.jobs.messages import Post
from kneeviz.views.tabs.change import REDO, START_OVER, UNDO
from kneeviz.views.tabs.events import on_command


@dataclass(frozen=True, kw_only=True)
class Command:
    """One thing that can be done."""

    label: str
    key: Hashable
    """The action, as in `kneeviz.actions.table`."""
    value: Any = True
    """What a widget would have been set to."""
    hotkey: Any = None
    modifier: Any = None
    description: str | None = None


STEPS = (
    Command(label=UNDO, key="undo", hotkey="Z", modifier="cmd/ctrl"),
    Command(label=REDO, key="redo", hotkey="Z", modifier="cmd/ctrl+shift"),
)
"""What every page has."""

COMMANDS = (
    *STEPS,
    Command(label=START_OVER, key="start_over", description="Knee, bounds and settings."),
    Command(label="Play or pause", key="play", hotkey="space"),
    Command(label="Straight", key="position", value=0.0, hotkey="home"),
    Command(label="Bent", key="position", value=100.0, hotkey="end"),
    Command(label="A little straighter", key="step", value=-5.0, hotkey="pageup"),
    Command(label="A little more bent", key="step", value=5.0, hotkey="pagedown"),
    Command(label="Flat view", key="view", value="2D", hotkey="2"),
    Command(label="View in 3D", key="view", value="3D", hotkey="3"),
    Command(label="Reset the view", key="view", value="Reset", hotkey="R"),
    Command(
        label="Worst case (surrogate)",
        key=("search", "surrogate"),
        hotkey="W",
        description="Search in the stand-in; the true model's answer is shown beside it.",
    ),
    Command(label="Worst case (true model)", key=("search", "model"), hotkey="W", modifier="shift"),
    Command(label="Cancel the search", key="cancel", hotkey="C"),
    Command(label="Live worst case on or off", key=("toggle", "live"), hotkey="L"),
    Command(label="Show or hide both worst cases", key=("toggle", "overlay"), hotkey="O"),
    Command(label="Worst cases side by side or over yours", key=("toggle", "beside"), hotkey="B"),
    Command(label="Newtons beside the ligaments", key=("toggle", "forces"), hotkey="N"),
    Command(label="Ghosts of your last knees on or off", key=("toggle", "ghosts"), hotkey="G"),
    Command(label="Clear ghosts", key="clear_ghosts"),
    Command(label="Landscape or knee", key="landscape", hotkey="V"),
    Command(label="Dark or light theme", key=("toggle", "dark"), hotkey="D"),
    Command(
        label="Handle: as it was",
        key="handle_escape",
        hotkey="escape",
        description="Puts back what is being dragged; closes the magnified bound.",
    ),
    Command(label="Reset all to the baseline", key="reset_all"),
    Command(label="Download the knee (knee.toml)", key=("download", "knee.toml")),
    Command(label="Download the result (result.json)", key=("download", "result.json")),
    Command(label="Download the page that moves (knees.html)", key=("download", "knees.html")),
)


def add_commands(gui: Any, post: Post, commands: Sequence[Command] = COMMANDS) -> tuple[Any, ...]:
    """Offer all commands; returns their handles, in the same order."""
    handles = []
    for one in commands:
        handle = gui.add_command(
            one.label, description=one.description, hotkey=one.hotkey, modifier=one.modifier
        )
        on_command(handle, post, one.key, one.value)
        handles.append(handle)
    return tuple(handles)

"""What can be done on a model's page from the keyboard."""

from kneeviz.views.commands import STEPS, Command
from kneeviz.views.tabs.change import START_OVER

COMMANDS = (
    *STEPS,
    Command(label=START_OVER, key="start_over", description="Inputs and settings."),
    Command(label="All inputs home", key="home"),
    Command(label="Run the model here", key="run_here"),
    Command(label="Worst case", key="search", hotkey="W"),
    Command(label="Cancel what runs", key="cancel", hotkey="C"),
    Command(label="Show or hide both worst models", key=("toggle", "overlay"), hotkey="O"),
    Command(label="Landscape or picture", key=("study", "landscape"), hotkey="V"),
    Command(label="Band", key=("study", "sampling")),
    Command(label="Influence", key=("study", "influence")),
    Command(label="Reset the view", key="reset_view", hotkey="R"),
    Command(label="Class or desk size", key=("toggle", "large")),
    Command(label="Dark or light theme", key=("toggle", "dark"), hotkey="D"),
    Command(label="Download the result (result.json)", key=("download", "result.json")),
)

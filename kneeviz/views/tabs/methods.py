"""The widgets that compare the search's methods."""

from typing import Any

from kneeviz.jobs.messages import Post
from kneeviz.views.tabs.events import on_press
from kneeviz.views.tabs.running import show_running


class MethodsBox:
    """A button, its progress, and the convergence plot."""

    def __init__(self, gui: Any, post: Post) -> None:
        run = gui.add_button(
            "Compare methods",
            color="gray",
            hint="Searches these bounds by the genetic algorithm, in the surrogate, in one that "
            "repairs itself and in the true model, and by exact gradients: the best f found "
            "against the models that it took.",
        )
        self.runs = {"compare": run}
        self.progress = gui.add_progress_bar(0.0)
        self.cancel = gui.add_button("Cancel the comparison", color="red", disabled=True)
        self.content = gui.add_html("")
        on_press(run, post, "compare")
        on_press(self.cancel, post, "comparison_cancel")

    def set_running(self, running: bool) -> None:
        """Shut the button and open *Cancel*, or the other way round."""
        show_running(self, running)
